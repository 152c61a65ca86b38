/* SPDX-License-Identifier: MIT */
/*
 * Makes sorted leaf lists, or only the ranges of their entries, and the order of the fragments by leaves. Kernels:
 * kernels/stages/pack.cl, scan.cl.
 *
 * Reads: the fragment list, build->cursors, build->state.
 * Writes: SVO_TREE_LIST_BEGIN, SVO_TREE_LIST where leaf lists are needed, build->order where that is.
 * Needs: subdivide.
 */
#ifndef SVO_LIB_STAGES_PACK_H
#define SVO_LIB_STAGES_PACK_H

#include "stages/build_state.h"

svo_status svo_i_pack(svo_i_build *build);

#endif
