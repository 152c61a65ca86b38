/* SPDX-License-Identifier: MIT */
/* The fragment estimate: how many fragments and nodes to expect at a level. plan.h has the formula. */
#ifndef SVO_LIB_PLAN_ESTIMATE_H
#define SVO_LIB_PLAN_ESTIMATE_H

#include "plan/plan_data.h"

SVO_I_SHARED_BEGIN

/* Adds a kept triangle to the sums; returns the fragments expected of it alone. */
float svo_i_estimate_add(svo_plan *plan, const uint32_t corners[3]);
/* Fragments expected at a level. */
double svo_i_plan_expected(const svo_plan *plan, uint32_t level);
/* The expected number with a margin for scenes that are not random. */
uint64_t svo_i_with_slack(double expected);
uint32_t svo_i_plan_fragment_bytes(const svo_plan *plan);
/* Nodes of an inner level, and of all inner levels, given the number of fragments: the estimate with its margin, or the
   worst case. */
uint64_t svo_i_plan_level_nodes(const svo_plan *plan, uint32_t level, uint64_t fragments, bool worst_case);
uint64_t svo_i_plan_inner_nodes(const svo_plan *plan, uint64_t fragments, bool worst_case);

SVO_I_SHARED_END

#endif
