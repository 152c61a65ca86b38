/* SPDX-License-Identifier: MIT */
/* The fragment estimate: the expected number of fragments and nodes of a level. estimate.c has the formula. */
#ifndef SVO_LIB_PLAN_ESTIMATE_H
#define SVO_LIB_PLAN_ESTIMATE_H

#include "plan/plan_data.h"

/* Adds a kept triangle to the sums. Returns its expected number of fragments. */
float svo_i_estimate_add(svo_plan *plan, const uint32_t corners[3]);
/* Makes the estimate of the sums and the number of kept triangles. */
void svo_i_estimate_end(svo_plan *plan);
/* svo_plan_info.ray_depth */
uint32_t svo_i_plan_ray_depth(const svo_plan *plan);
/* The expected number with a margin. */
uint64_t svo_i_with_slack(double expected);
/* Nodes of an inner level, given the number of fragments: the estimate with its margin, or the worst case. */
uint64_t svo_i_plan_level_nodes(const svo_plan *plan, uint32_t level, uint64_t fragments, bool worst_case);

SVO_I_SHARED_BEGIN

/* What a triangle adds to the sums: of its widths, and of twice the areas of its projections, as far as it is in a grid
   of 2^units_log2 units. */
void svo_i_estimate_sums(const int32_t corners[3][3], uint32_t units_log2, uint64_t *widths, uint64_t *doubled_areas);
/* Expected number of fragments at a level. */
double svo_i_plan_expected(const svo_plan *plan, uint32_t level);
/* Bytes of a fragment in the list. */
uint32_t svo_i_plan_fragment_bytes(const svo_plan *plan);
/* The sum of svo_i_plan_level_nodes over all inner levels. */
uint64_t svo_i_plan_inner_nodes(const svo_plan *plan, uint64_t fragments, bool worst_case);

SVO_I_SHARED_END

#endif
