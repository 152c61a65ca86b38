/* SPDX-License-Identifier: MIT */
/*
 * The commands of an update, each after the one before, whatever the queue; and the pairs of one object (voxelized, in
 * Morton order, weighed) and those of all in one list.
 */
#ifndef SVO_LIB_MOVING_PAIRS_H
#define SVO_LIB_MOVING_PAIRS_H

#include "commands/commands.h"
#include "core/work.h"
#include "moving/handle.h"

/* ---- the chain of commands ---- */

typedef struct svo_i_chain {
    const char *function; /* for messages */
    cl_command_queue queue;
    bool waits; /* each stage waits for its commands; else none does, and counts stay on the device */
    cl_event last; /* the newest command, owned; NULL: nothing is to be waited for */
} svo_i_chain;

/* The program of kernels/moving. */
svo_status svo_i_moving_program(const svo_moving *moving, const char *function, cl_program *out);

/* Begins stages of builds, and ends them after a failure too. The commands have buffers of their own. */
svo_i_commands svo_i_chain_begin_commands(svo_i_chain *chain, svo_plan *plan, svo_build_report *report);
void svo_i_chain_end_commands(svo_i_chain *chain, svo_i_commands *commands, svo_status status);

/* Waits for the newest command and releases the chain. */
void svo_i_chain_settle(svo_i_chain *chain);

/* ---- pairs of an object ---- */

/* What the device counts of an object in an update that does not wait. */
typedef struct svo_i_pair_count {
    cl_uint words[SVO_COUNTER_WORDS]; /* of the list (kernels/stages/drop.cl): its pairs; those that were dropped */
    uint64_t capacity; /* pairs that there is room for */
} svo_i_pair_count;

void svo_i_kept_list_free(svo_i_kept_list *list);
/* Voxelizes an object. out: a new list of fragments without values; the sorted order is that of a leaf list. later:
   of a chain that does not wait; receives the count when the commands are done. */
svo_status svo_i_moving_voxelize(svo_moving *moving, uint32_t index, svo_i_chain *chain, svo_i_pair_count *later,
                                 svo_i_kept_list *out);
/* Adds the values to such a list. */
svo_status svo_i_moving_weigh(svo_moving *moving, uint32_t index, svo_i_chain *chain, svo_i_kept_list *list);
/* The next voxelization of an object has room for so many pairs, and an eighth more. Room does not shrink. */
void svo_i_moving_remember(svo_i_moving_object *object, uint64_t fragments);

/* ---- lists ---- */

/* Merges the lists of objects that changed into the first, and that with the pairs of the scene's list that stay.
   fragments: of the result, or the most where the device counts. The other lists keep what out does not use. */
svo_status svo_i_moving_merge(svo_moving *moving, svo_i_chain *chain, svo_i_kept_list *changed, uint32_t changed_count,
                              uint64_t fragments, svo_i_kept_list *out);

#endif
