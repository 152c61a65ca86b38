/* SPDX-License-Identifier: MIT */
/* The tree of a list of kept pairs. */
#ifndef SVO_LIB_MOVING_TREE_H
#define SVO_LIB_MOVING_TREE_H

#include "moving/pairs.h"

/* An update that does not wait. */
typedef struct svo_i_moving_news {
    const uint32_t *moved; /* the indices of the objects whose vertices are new to the device */
    uint32_t moved_count;
    uint64_t pairs; /* the most that are made anew */
    svo_build_state *state; /* receives the tree's counts when the commands are done */
} svo_i_moving_news;

/* Makes a new tree of the scene's objects and their pairs. news: NULL: waits; else the tree has room for all that there
   may be, and no content until svo_i_moving_tree_end. report: receives times; NULL: waits only at the end. */
svo_status svo_i_moving_tree(svo_moving *moving, svo_i_chain *chain, const svo_i_kept_list *list,
                             const svo_i_moving_news *news, svo_moving_report *report, svo_tree **out);
/* Sets the tree's counts. */
svo_status svo_i_moving_tree_end(const svo_moving *moving, const svo_build_state *state, svo_tree *tree);

#endif
