/* SPDX-License-Identifier: MIT */
/* Merging of lists of kept pairs. */
#ifndef SVO_LIB_MOVING_MERGE_H
#define SVO_LIB_MOVING_MERGE_H

#include "moving/chain.h"

/* Merges lists of different objects into the first; the others are released. */
svo_status svo_i_moving_merge_all(svo_moving *moving, svo_i_chain *chain, svo_i_kept_list *lists, uint32_t count);
/* Merges the scene's list, without what does not stay, with that of the objects that changed, into to, whose buffers
   are used where they are large enough. fragments: those of the result, or the most where the device counts. */
svo_status svo_i_moving_merge(svo_moving *moving, svo_i_chain *chain, const svo_i_kept_list *changed,
                              uint64_t fragments, svo_i_kept_list *to);

#endif
