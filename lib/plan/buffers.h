/* SPDX-License-Identifier: MIT */
/* The plan's list of buffers, and the peak of the bytes that are allocated at one time. */
#ifndef SVO_LIB_PLAN_BUFFERS_H
#define SVO_LIB_PLAN_BUFFERS_H

#include "plan/plan_data.h"

/* Empties the list. */
void svo_i_plan_buffers_reset(svo_plan *plan);
/* Adds an allocation to the entry of its name. name: a static string. Fails where the list is full. */
svo_status svo_i_plan_buffer_add(svo_plan *plan, const char *name, uint64_t bytes);
/* Counts a release. The entry remains in the list. */
void svo_i_plan_buffer_remove(svo_plan *plan, uint64_t bytes);

/* Refuses a plan that needs more bytes than the device's budget has left. function: for the message. */
svo_status svo_i_plan_check_budget(const svo_plan *plan, const char *function, uint64_t bytes);

#endif
