/* SPDX-License-Identifier: MIT */
/*
 * Exclusive sums, by kernels/stages/scan.cl: reduce, scan of the partial sums, add. build->partials is made when it is
 * first needed.
 */
#ifndef SVO_LIB_STAGES_SCAN_H
#define SVO_LIB_STAGES_SCAN_H

#include "stages/build_state.h"

/* Room for the partial sums. */
svo_status svo_i_scan_alloc(svo_i_build *build);
/* sums[i] = numbers[0] + ... + numbers[i - 1] for i in 0 .. params.leaf_count. state: limits the count on the device;
   NULL: the count is the host's. */
svo_status svo_i_scan_lists(svo_i_build *build, svo_i_program_kind program, cl_mem numbers, cl_mem sums, cl_mem state,
                            svo_filter_params params);

#endif
