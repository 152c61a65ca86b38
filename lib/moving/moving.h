/* SPDX-License-Identifier: MIT */
/* An update of a scene that moves: what svo_moving_update and svo_moving_update_enqueue have in common. */
#ifndef SVO_LIB_MOVING_MOVING_H
#define SVO_LIB_MOVING_MOVING_H

#include "moving/chain.h"

typedef struct svo_i_moving_update {
    svo_moving *moving;
    svo_i_chain chain;
    uint64_t fragment_limit; /* most pairs of the scene */
    bool timed;
    svo_moving_report report;
    double start_ms; /* of the current stage */
    svo_i_kept_list *changed; /* lists of the objects in members */
    uint32_t *members; /* indices of objects whose pairs are made anew */
    uint32_t changed_count;
    svo_i_kept_list list; /* of the new tree */
    svo_tree *tree;
} svo_i_moving_update;

/* Whether anything in the list is to change. */
bool svo_i_moving_is_due(const svo_moving *moving);
/* Whether the pairs of an object are to be made anew. */
bool svo_i_moving_is_new(const svo_i_moving_object *object);
/* Makes changed and members, empty, with room for all objects. */
svo_status svo_i_moving_alloc_changed(svo_i_moving_update *u);
/* Makes the list of the new tree. Counts pairs for the report: the most, where the device counts them. */
svo_status svo_i_moving_merge_changed(svo_i_moving_update *u);
/* Takes the new list and tree. counts: the pairs of each member. */
void svo_i_moving_commit(svo_i_moving_update *u, const uint64_t *counts);
/* Releases what was not taken. */
void svo_i_moving_release_update(svo_i_moving_update *u);

#endif
