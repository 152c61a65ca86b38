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

#endif
