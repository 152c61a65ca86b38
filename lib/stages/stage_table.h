/* SPDX-License-Identifier: MIT */
/* The table of stages, in the order in which they run. A new stage is a row of it; CONTRIBUTING.md has the recipe. */
#ifndef SVO_LIB_STAGES_STAGE_TABLE_H
#define SVO_LIB_STAGES_STAGE_TABLE_H

#include "plan/plan_data.h"

const svo_i_stage *svo_i_stage_table(size_t *count);

#endif
