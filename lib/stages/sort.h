/* SPDX-License-Identifier: MIT */
/*
 * Sorts the fragment list by Morton code, and within a voxel by triangle where leaf lists are needed. It is a radix
 * sort. Kernels: kernels/stages/sort.cl, scan.cl.
 *
 * Reads: the fragment list.
 * Writes: the list, which becomes one chunk that the build owns; build->partials.
 * Needs: the whole list in one allocation, and a second one of its size.
 */
#ifndef SVO_LIB_STAGES_SORT_H
#define SVO_LIB_STAGES_SORT_H

#include "stages/build_state.h"

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
