/* SPDX-License-Identifier: MIT */
/*
 * Exclusive prefix sums, for stages: reduce, scan the partial sums, add. Kernels: kernels/stages/scan.cl.
 *
 * Reads: an array of numbers.
 * Writes: their sums; build->partials.
 * Needs: svo_i_scan_alloc before the first sum.
 */
#ifndef SVO_LIB_STAGES_SCAN_H
#define SVO_LIB_STAGES_SCAN_H

#include "stages/build_state.h"

/* Allocates build->partials, unless it is there. */
svo_status svo_i_scan_alloc(svo_i_build *build);
/* Groups for a scan of at most that many numbers: 1 .. device->scan_groups. */
uint32_t svo_i_scan_groups(const svo_device *device, uint64_t numbers);
/* sums[i] = numbers[0] + ... + numbers[i - 1] for i in 0 .. params.leaf_count. state: takes the count from the build's
   state on the device; NULL: params.leaf_count is the count. */
svo_status svo_i_scan_lists(svo_i_build *build, const svo_i_program *program, cl_mem numbers, cl_mem sums, cl_mem state,
                            svo_filter_params params);

#endif
