/* SPDX-License-Identifier: MIT */
/* What stages get from the plan: the parameters of payload kernels, the snapped mesh, its attributes, constants. */
#ifndef SVO_LIB_STAGES_INPUTS_H
#define SVO_LIB_STAGES_INPUTS_H

#include "stages/build_state.h"

/* The parameters that payload kernels share. */

SVO_I_SHARED_BEGIN

/* Of fragments that front ends leave undecided, without those of a chunk. */
svo_decide_params svo_i_decide_params(const svo_plan *plan);
/* Parameters of a build, without those of a level or a chunk. */
svo_filter_params svo_i_payload_params(const svo_i_build *build);
/* Sets the parameters of a level. */
void svo_i_params_of_level(svo_filter_params *params, const svo_tree_info *info, uint32_t level);
/* Number of radix passes of SVO_DIGIT_BITS bits that sort triangle indices. It is even, so that the result is in the
   buffer that held the input. */
uint32_t svo_i_digit_passes(uint32_t triangle_count);

SVO_I_SHARED_END

/*
 * The mesh on the device, snapped and as it was given, uploaded once a build: by the first stage that reads it, and
 * kept for the last one. A tree with leaf lists takes the buffers.
 */

/* Gets the buffers, which stay commands->mesh's. */
svo_status svo_i_build_mesh_get(svo_i_commands *commands, svo_i_build_mesh *out);
/* Releases what no stage after the voxelizer reads. */
void svo_i_build_mesh_listed(svo_i_commands *commands);
void svo_i_build_mesh_free(svo_i_commands *commands);

/*
 * Stores the snapped mesh in the tree, for rays. Kernels: none.
 *
 * Reads: the plan's snapped mesh.
 * Writes: SVO_TREE_VERTICES, _INDICES and _TRIANGLE_IDS, SVO_TREE_POSITIONS or _POSITIONS_DOUBLE where rays meet
 *         triangles, and their counts and kind in the tree's info.
 * Needs: nothing.
 */

SVO_I_SHARED_BEGIN

svo_status svo_i_geometry_upload(svo_i_build *build);

SVO_I_SHARED_END

/*
 * Uploads the mesh's attributes for the stages that compute payload. Kernels: none; kernels/stages/attribute.clh reads
 * the buffers.
 *
 * Reads: the plan's payload inputs.
 * Writes: build->surface.
 * Needs: geometry before it, where the plan has leaf lists: the tree's vertices and indices are then used in place.
 */

svo_status svo_i_surface_upload(svo_i_build *build);
/* Releases build->surface. To be called before the tree is released, also after a failure. */
void svo_i_surface_free(svo_i_build *build);

/*
 * Stores payload that is the same in every node, as one element. Kernels: none.
 *
 * Reads: the plan's configuration.
 * Writes: SVO_TREE_COLORS, _NORMALS and _MATERIALS, as far as they are constant. Releases build->surface.
 * Needs: all stages that read build->surface before it.
 */

svo_status svo_i_constants_store(svo_i_build *build);

#endif
