/* SPDX-License-Identifier: MIT */
/*
 * Payload that is the same in every node, stored once. The last stage: nothing reads the mesh's attributes any more.
 * Reads: the plan's configuration. Writes: those of SVO_TREE_COLORS, _NORMALS and _MATERIALS that are constant.
 */
#ifndef SVO_LIB_STAGES_CONSTANTS_H
#define SVO_LIB_STAGES_CONSTANTS_H

#include "stages/build_state.h"

svo_status svo_i_constants_store(svo_i_build *build);

#endif
