/* SPDX-License-Identifier: MIT */
/* The pairs of one object: voxelized, in Morton order, weighed. */
#ifndef SVO_LIB_MOVING_PAIRS_H
#define SVO_LIB_MOVING_PAIRS_H

#include "moving/chain.h"

/* What the device counts of an object in an update that does not wait. */
typedef struct svo_i_pair_count {
    cl_uint words[2]; /* low and high word of the pairs that the object has */
    uint64_t capacity; /* pairs that there is room for */
} svo_i_pair_count;

/* Makes buffers of a list with room for so many pairs, at least one. */
svo_status svo_i_kept_list_alloc(const svo_moving *moving, const char *function, uint64_t capacity,
                                 svo_i_kept_list *out);
void svo_i_kept_list_free(svo_i_kept_list *list);
/* Marks of a list of so many pairs. */
static inline uint64_t svo_i_kept_list_marks(uint64_t pairs)
{
    return (pairs + SVO_MERGE_STRIP - 1) / SVO_MERGE_STRIP;
}
/* Voxelizes an object. out: a new list of fragments without values; the sorted order is that of a leaf list. later:
   of a chain that does not wait; receives the count when the commands are done. */
svo_status svo_i_moving_voxelize(svo_moving *moving, uint32_t index, svo_i_chain *chain, svo_i_pair_count *later,
                                 svo_i_kept_list *out);
/* Adds the values to such a list. */
svo_status svo_i_moving_weigh(svo_moving *moving, uint32_t index, svo_i_chain *chain, svo_i_kept_list *list);
/* The next voxelization of an object has room for so many pairs, and an eighth more. Room does not shrink. */
void svo_i_moving_remember(svo_i_moving_object *object, uint64_t fragments);

#endif
