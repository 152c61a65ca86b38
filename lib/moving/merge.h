/* SPDX-License-Identifier: MIT */
/* Merging of lists of kept pairs. */
#ifndef SVO_LIB_MOVING_MERGE_H
#define SVO_LIB_MOVING_MERGE_H

#include "moving/state.h"

/* Merges lists of different objects into the first; the others are released. count: at least 1. */
svo_status svo_i_moving_merge_all(svo_moving *moving, const char *function, cl_command_queue queue,
                                  svo_i_kept_list *lists, uint32_t count);
/* Merges the scene's list, without what does not stay, with that of the objects that changed, into to, whose buffers
   are used where they are large enough. fragments: those of the result. Waits. */
svo_status svo_i_moving_merge(svo_moving *moving, const char *function, cl_command_queue queue,
                              const svo_i_kept_list *changed, uint64_t fragments, svo_i_kept_list *to);

#endif
