/* SPDX-License-Identifier: MIT */
/* INPUT of a command where it is a point cloud: .las, or .ply without faces. */
#ifndef SVOCL_TOOLS_SUPPORT_POINTS_INPUT_H
#define SVOCL_TOOLS_SUPPORT_POINTS_INPUT_H

#include <stdbool.h>

#include "support/json.h"
#include "support/program.h"
#include "svocl/points.h"

struct table;

/* Whether INPUT is a point cloud: by its suffix, and of .ply by what its header declares. */
bool points_input_is_given(const program *state);

/* Reads the points by --depth, --origin and --edge, --voxel-size, --max-memory, --max-voxels, --counts and --axes.
   voxels: NULL for info alone. Returns the exit code. */
int points_input_read(program *state, svo_voxels **voxels, svo_points_info *info);

/* What the cloud holds, as rows of two cells and as JSON. */
void points_input_add_rows(struct table *rows, const svo_points_info *info);
void points_input_add_json(cJSON *document, const svo_points_info *info);

#endif
