/* SPDX-License-Identifier: MIT */
/* Plans of parts of a tree: the grid of a part, and what it takes from the header of the whole. */
#ifndef SVO_LIB_PLAN_PART_H
#define SVO_LIB_PLAN_PART_H

#include "plan/plan_data.h"

/* Grid units per axis of a tree of that depth, as a power of two. */
uint32_t svo_i_snap_bits(uint32_t depth);

bool svo_i_plan_is_part(const svo_plan *plan);

/* Checks the options of a part and replaces those that the header decides. Leaves *part as it is where there is no
   header. */
svo_status svo_i_part_read(svo_device *device, const char *function, uint32_t depth, svo_plan_options *options,
                           svo_i_plan_part *part);

/* Sets the grid of a part. */
void svo_i_part_grid(svo_plan *plan);
/* Allocates part.positions, in plans of parts. */
svo_status svo_i_part_alloc(svo_plan *plan, size_t triangles);
/* Replaces what was counted over the triangles of a part by the counts of the whole. */
void svo_i_part_counts(svo_plan *plan);
/* Takes constant payload and the unit of weights from the header. */
void svo_i_plan_take_constants(svo_plan *plan);
/* Names the kept triangles of a part by their positions among those of the whole. */
void svo_i_part_name_triangles(svo_plan *plan);
/* Whether a level above the part sums up its root's payload. */
bool svo_i_part_sums_root(const svo_plan *plan);

#endif
