/* SPDX-License-Identifier: MIT */
/* Prefix sums and the radix sort, for stages and for other rooms' kernels. */
#ifndef SVO_LIB_STAGES_SORT_H
#define SVO_LIB_STAGES_SORT_H

#include "stages/build_state.h"

/*
 * Exclusive prefix sums, for stages: reduce, then add. Kernels: kernels/stages/scan.cl.
 *
 * Reads: an array of numbers.
 * Writes: their sums; build->partials.
 * Needs: svo_i_build_alloc_state before the first sum.
 */

/* sums[i] = numbers[0] + ... + numbers[i - 1] for i in 0 .. params.leaf_count. state: takes the count from the build's
   state on the device; NULL: params.leaf_count is the count. */
svo_status svo_i_scan_lists(svo_i_build *build, const svo_i_program *program, cl_mem numbers, cl_mem sums, cl_mem state,
                            svo_filter_params params);

/*
 * Sorts the fragment list by Morton code, and within a voxel by triangle where leaf lists are needed. It is a radix
 * sort. Kernels: kernels/stages/sort.cl, scan.cl.
 *
 * Reads: the fragment list.
 * Writes: the list, which becomes one chunk that the build owns; build->partials.
 * Needs: the whole list in one allocation, and a second one of its size.
 */

svo_status svo_i_sort(svo_i_build *build);

/* What selects the kernels of a sort for a device, and the bytes of local memory that they get. */
static inline const char *svo_i_sort_defines(const svo_device *device)
{
    return device->cpu_path ? " -DSVO_SORT -DSVO_SORT_SERIAL" : " -DSVO_SORT";
}

static inline size_t svo_i_sort_local_bytes(const svo_device *device)
{
    return device->cpu_path ? SVO_SORT_SERIAL_BYTES : SVO_SORT_TILE_BYTES;
}

#endif
