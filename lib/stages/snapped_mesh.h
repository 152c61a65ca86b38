/* SPDX-License-Identifier: MIT */
/*
 * The snapped mesh on the device, uploaded once a build: by the first stage that reads it, and kept for the last one.
 * A tree with leaf lists takes the buffers.
 */
#ifndef SVO_LIB_STAGES_SNAPPED_MESH_H
#define SVO_LIB_STAGES_SNAPPED_MESH_H

#include "commands/commands.h"

/* Gets the buffers, which stay commands->mesh's. */
svo_status svo_i_snapped_vertices(svo_i_commands *commands, cl_mem *out);
svo_status svo_i_snapped_indices(svo_i_commands *commands, cl_mem *out);
/* Releases what no stage after the voxelizer reads. */
void svo_i_snapped_mesh_listed(svo_i_commands *commands);
void svo_i_snapped_mesh_free(svo_i_commands *commands);

#endif
