/* SPDX-License-Identifier: MIT */
/*
 * Drops pairs by their alpha. Kernels: kernels/stages/drop.cl.
 *
 * Reads: the plan's attributes, which it uploads for the stages of the payload as well.
 * Writes: the fragment list and its counts; the report, where the host learns them.
 * Needs: the list, with all that is undecided decided.
 */
#ifndef SVO_LIB_STAGES_DROP_H
#define SVO_LIB_STAGES_DROP_H

#include "stages/build_state.h"

svo_status svo_i_drop(svo_i_build *build);

#endif
