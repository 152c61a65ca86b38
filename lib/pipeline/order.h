/* SPDX-License-Identifier: MIT */
/* Compiles and runs the stages in the order of their table, in every mode. */
#ifndef SVO_LIB_PIPELINE_ORDER_H
#define SVO_LIB_PIPELINE_ORDER_H

#include "stages/build_state.h"

/* Fills build->programs with those of the plan's stages. Adds newly compiled programs to warm_up. */
svo_status svo_i_order_get_programs(svo_i_build *build, svo_i_warm_up *warm_up);
/* Runs all stages that follow the fragment list. */
svo_status svo_i_order_run(svo_i_build *build);
/* Releases everything but the tree. No command may use it any more. */
void svo_i_order_release_scratch(svo_i_build *build);

#endif
