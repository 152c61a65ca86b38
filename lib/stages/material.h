/* SPDX-License-Identifier: MIT */
/*
 * Computes the material of every node. Kernels: kernels/stages/material.cl.
 *
 * Reads: the fragment list, build->cursors, build->state, build->surface, SVO_TREE_LIST_BEGIN.
 * Writes: SVO_TREE_MATERIALS. Releases SVO_TREE_LIST_BEGIN where the plan has no leaf lists.
 * Needs: pack or bottom_up, surface. Runs before filter, which overwrites the cursors.
 */
#ifndef SVO_LIB_STAGES_MATERIAL_H
#define SVO_LIB_STAGES_MATERIAL_H

#include "stages/build_state.h"

SVO_I_SHARED_BEGIN

svo_status svo_i_material(svo_i_build *build);

SVO_I_SHARED_END

#endif
