/* SPDX-License-Identifier: MIT */
/* The pairs of one object: voxelized, in Morton order, weighed. */
#ifndef SVO_LIB_MOVING_PAIRS_H
#define SVO_LIB_MOVING_PAIRS_H

#include "moving/state.h"

/* The program of kernels/moving. */
svo_status svo_i_moving_program(const svo_moving *moving, const char *function, cl_program *out);
/* Makes buffers of a list with room for so many pairs, at least one. */
svo_status svo_i_kept_list_alloc(const svo_moving *moving, const char *function, uint64_t capacity,
                                 svo_i_kept_list *out);
void svo_i_kept_list_free(svo_i_kept_list *list);
/* Voxelizes an object. out: a new list of fragments without values; the sorted order is that of a leaf list. */
svo_status svo_i_moving_voxelize(svo_moving *moving, uint32_t index, cl_command_queue queue, svo_i_kept_list *out);
/* Adds the values to such a list. */
svo_status svo_i_moving_weigh(svo_moving *moving, const char *function, uint32_t index, cl_command_queue queue,
                              svo_i_kept_list *list);

#endif
