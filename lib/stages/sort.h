/* SPDX-License-Identifier: MIT */
/*
 * Sorts the fragment list by Morton code, and within a voxel by triangle where lists are asked for, by
 * kernels/stages/sort.cl: a radix sort in one buffer.
 * Reads: the fragment list. Writes: the list, which then is one chunk of the build's own.
 */
#ifndef SVO_LIB_STAGES_SORT_H
#define SVO_LIB_STAGES_SORT_H

#include "stages/build_state.h"

svo_status svo_i_sort(svo_i_build *build);

#endif
