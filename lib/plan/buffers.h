/* SPDX-License-Identifier: MIT */
/* The plan's list of buffers, with the largest sum of bytes that is allocated at one time. */
#ifndef SVO_LIB_PLAN_BUFFERS_H
#define SVO_LIB_PLAN_BUFFERS_H

#include "plan/plan_data.h"

SVO_I_SHARED_BEGIN

void svo_i_plan_buffers_reset(svo_plan *plan);
void svo_i_plan_buffer_add(svo_plan *plan, const char *name, uint64_t bytes);
void svo_i_plan_buffer_remove(svo_plan *plan, uint64_t bytes);

SVO_I_SHARED_END

#endif
