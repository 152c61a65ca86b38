/* SPDX-License-Identifier: MIT */
/*
 * The material of every node, by kernels/stages/material.cl.
 * Reads: the list, build->cursors, SVO_TREE_LIST_BEGIN, build->surface. Writes: SVO_TREE_MATERIALS. Comes before the
 * filter, which uses up the cursors.
 */
#ifndef SVO_LIB_STAGES_MATERIAL_H
#define SVO_LIB_STAGES_MATERIAL_H

#include "stages/build_state.h"

SVO_I_SHARED_BEGIN

svo_status svo_i_material(svo_i_build *build);

SVO_I_SHARED_END

#endif
