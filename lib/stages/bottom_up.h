/* SPDX-License-Identifier: MIT */
/*
 * Makes the nodes from the leaves up, and the leaf lists. Kernels: kernels/stages/bottom_up.cl, scan.cl.
 *
 * Reads: the fragment list; svo_i_bottom_up_lists also build->cursors.
 * Writes: svo_i_bottom_up writes what subdivide writes; svo_i_bottom_up_lists writes what pack writes.
 * Needs: a list that sort has sorted; svo_i_bottom_up before svo_i_bottom_up_lists.
 */
#ifndef SVO_LIB_STAGES_BOTTOM_UP_H
#define SVO_LIB_STAGES_BOTTOM_UP_H

#include "stages/build_state.h"

svo_status svo_i_bottom_up(svo_i_build *build);
svo_status svo_i_bottom_up_lists(svo_i_build *build);

#endif
