/* SPDX-License-Identifier: MIT */
/* INPUT of a command where it is a voxel file, .vox, .svx, .binvox, .nvdb, .vdb, .bt, or a point cloud. */
#ifndef SVOCL_TOOLS_SUPPORT_VOXEL_INPUT_H
#define SVOCL_TOOLS_SUPPORT_VOXEL_INPUT_H

#include <stdbool.h>

#include "support/json.h"
#include "support/points_input.h"
#include "support/program.h"
#include "svocl/voxel_files.h"

struct table;

typedef struct voxel_input {
    svo_voxels *voxels; /* NULL: none */
    svo_voxel_file_info file;
    svo_voxels_info list;
    svo_points_info points; /* of a point cloud; else its struct_size is 0 */
} voxel_input;

/* Whether INPUT is a voxel file or a point cloud, judged by its suffix or, from a pipe, by its bytes. */
bool voxel_input_is_given(const program *state);

/* Reads the file by --hidden and --frame. Returns the exit code; on failure nothing stays open. */
int voxel_input_open(program *state, voxel_input *opened);
/* Writes the file again by svo_voxels_copy_vox; opened has no list then. */
svo_status voxel_input_copy(program *state, svo_sink sink, voxel_input *opened, svo_message *message);
/* Reads the file by svo_voxels_load_parts; opened has no list then. */
svo_status voxel_input_read_parts(program *state, svo_voxel_part_callback callback, void *user, voxel_input *opened,
                                  svo_message *message);
/* Warns of what the file holds and the list does not, and of what else is left out; others: NULL or its words. */
void voxel_input_warn(program *state, const voxel_input *opened, const char *others);
void voxel_input_close(voxel_input *opened);

/* Refuses options of meshes, and what voxels do not have of need. Returns the exit code. */
int voxel_input_check_options(program *state, uint32_t need);

/* Plans the tree of the voxels by the options: at --depth if it is given, else at the least depth. */
svo_status voxel_input_plan(const program *state, svo_device *device, const voxel_input *opened,
                            const svo_plan_options *plan_options, svo_plan **out);

/* What the file holds, as cells "NAME" and "COUNT" of a table's rows, and as JSON. */
void voxel_input_add_rows(struct table *rows, const voxel_input *opened);
void voxel_input_add_json(cJSON *document, const voxel_input *opened);

#endif
