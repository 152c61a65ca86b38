/* SPDX-License-Identifier: MIT */
/*
 * What rays need of the mesh, in the tree's buffers.
 * Reads: the plan's snapped mesh. Writes: SVO_TREE_VERTICES, _INDICES and _TRIANGLE_IDS.
 */
#ifndef SVO_LIB_STAGES_GEOMETRY_H
#define SVO_LIB_STAGES_GEOMETRY_H

#include "stages/build_state.h"

SVO_I_SHARED_BEGIN

svo_status svo_i_geometry_upload(svo_i_build *build);

SVO_I_SHARED_END

#endif
