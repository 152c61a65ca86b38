/* SPDX-License-Identifier: MIT */
/*
 * Nodes from the leaves up, of a sorted list, by kernels/stages/bottom_up.cl; and leaf lists, which the list already is
 * in the order of.
 * Reads: the sorted list. Writes: the same as subdivide; the same as pack.
 */
#ifndef SVO_LIB_STAGES_BOTTOM_UP_H
#define SVO_LIB_STAGES_BOTTOM_UP_H

#include "stages/build_state.h"

svo_status svo_i_bottom_up(svo_i_build *build);
svo_status svo_i_bottom_up_lists(svo_i_build *build);

#endif
