/* SPDX-License-Identifier: MIT */
/*
 * Stores the snapped mesh in the tree, for rays. Kernels: none.
 *
 * Reads: the plan's snapped mesh.
 * Writes: SVO_TREE_VERTICES, _INDICES and _TRIANGLE_IDS, SVO_TREE_POSITIONS or _POSITIONS_DOUBLE where rays meet
 *         triangles, and their counts and kind in the tree's info.
 * Needs: nothing.
 */
#ifndef SVO_LIB_STAGES_GEOMETRY_H
#define SVO_LIB_STAGES_GEOMETRY_H

#include "stages/build_state.h"

SVO_I_SHARED_BEGIN

svo_status svo_i_geometry_upload(svo_i_build *build);

SVO_I_SHARED_END

#endif
