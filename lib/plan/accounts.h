/* SPDX-License-Identifier: MIT */
/* What a running call on a plan accounts for: its progress and its buffers. */
#ifndef SVO_LIB_PLAN_ACCOUNTS_H
#define SVO_LIB_PLAN_ACCOUNTS_H

#include "plan/plan_data.h"

/*
 * The progress of calls on a plan. A measuring build predicts what the launches of each stage cost; a build adds up
 * what it has done of that, and tells the caller's callback, which may stop it.
 *
 * The costs are nanoseconds of two CPU cores. Only their ratios count.
 */

/* The bit of a stage, for svo_i_progress_begin. */
#define SVO_I_STAGE_BIT(stage) (1u << (stage))
/* All stages of a build. */
#define SVO_I_STAGES_OF_BUILDS (SVO_I_STAGE_BIT(SVO_STAGE_COUNT) - 1u - SVO_I_STAGE_BIT(SVO_STAGE_GRID))

/* Rough times of a plan's work on the host: per vertex that is read, fitted and snapped; per triangle that is
   classified; and per triangle for its attributes. */
#define SVO_I_SNAP_NS       30.0
#define SVO_I_KEEP_NS       100.0
#define SVO_I_ATTRIBUTES_NS 60.0

/* A call begins, whose progress is that of the stages. Tells 0. All functions return SVO_CANCELED when the callback
   stops the call. */
svo_status svo_i_progress_begin(svo_plan *plan, const char *function, uint32_t stages);

/* Adds work that was done. Returns whether the callback is to be told: when there is one, and it has not been told for
   some time. */
bool svo_i_progress_add(svo_plan *plan, svo_stage stage, double ns);

/* Calls the callback, if there is one. */
svo_status svo_i_progress_tell(svo_plan *plan, svo_stage stage);

SVO_I_SHARED_BEGIN

/* A part of a stage is done, 0 .. 1. Tells. */
svo_status svo_i_progress_reach(svo_plan *plan, svo_stage stage, double part);

SVO_I_SHARED_END

/* The call has succeeded. Tells 1. */
svo_status svo_i_progress_end(svo_plan *plan, svo_stage last_stage);

/* The plan's list of buffers, and the peak of the bytes that are allocated at one time. */

/* Empties the list. */
void svo_i_plan_buffers_reset(svo_plan *plan);
/* Adds an allocation to the entry of its name. name: a static string. Fails where the list is full. */
svo_status svo_i_plan_buffer_add(svo_plan *plan, const char *name, uint64_t bytes);
/* Counts a release. The entry remains in the list. */
void svo_i_plan_buffer_remove(svo_plan *plan, uint64_t bytes);
/* The bytes of those that are part of the tree. */
uint64_t svo_i_plan_tree_bytes(const svo_plan *plan);

/* Refuses a plan that needs more bytes than the device's budget has left. function: for the message. */
svo_status svo_i_plan_check_budget(const svo_plan *plan, const char *function, uint64_t bytes);

#endif
