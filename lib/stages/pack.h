/* SPDX-License-Identifier: MIT */
/*
 * Sorted leaf lists, by kernels/stages/pack.cl and scan.cl.
 * Reads: the list, build->cursors, build->state. Writes: SVO_TREE_LIST_BEGIN, and SVO_TREE_LIST where lists are asked
 * for.
 */
#ifndef SVO_LIB_STAGES_PACK_H
#define SVO_LIB_STAGES_PACK_H

#include "stages/build_state.h"

svo_status svo_i_pack(svo_i_build *build);

#endif
