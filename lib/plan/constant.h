/* SPDX-License-Identifier: MIT */
/* Payload that is the same in every node. */
#ifndef SVO_LIB_PLAN_CONSTANT_H
#define SVO_LIB_PLAN_CONSTANT_H

#include "plan/plan_data.h"

/* Equal vertex colors become part of the materials; equal normals become the plan's constant normal. */
void svo_i_plan_fold_colors(svo_plan *plan);
void svo_i_plan_fold_normals(svo_plan *plan);
/* Finds the payload that is the same in every node, and frees its inputs. */
void svo_i_plan_find_constants(svo_plan *plan);

#endif
