/* SPDX-License-Identifier: MIT */
/*
 * Stores payload that is the same in every node, as one element. Kernels: none.
 *
 * Reads: the plan's configuration.
 * Writes: SVO_TREE_COLORS, _NORMALS and _MATERIALS, as far as they are constant. Releases build->surface.
 * Needs: all stages that read build->surface before it.
 */
#ifndef SVO_LIB_STAGES_CONSTANTS_H
#define SVO_LIB_STAGES_CONSTANTS_H

#include "stages/build_state.h"

svo_status svo_i_constants_store(svo_i_build *build);

#endif
