/* SPDX-License-Identifier: MIT */
/* Payload that is the same in every node. */
#ifndef SVO_LIB_PLAN_CONSTANT_H
#define SVO_LIB_PLAN_CONSTANT_H

#include "plan/plan_data.h"

/* Moves vertex colors that are all equal into the materials. */
void svo_i_plan_fold_colors(svo_plan *plan);
/* Moves vertex normals that are all equal into the plan's constant normal. */
void svo_i_plan_fold_normals(svo_plan *plan);
/* Finds the payload that is the same in every node, and frees its inputs. */
void svo_i_plan_find_constants(svo_plan *plan);

#endif
