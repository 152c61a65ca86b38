/* SPDX-License-Identifier: MIT */
/* The configuration: what a build of the plan does, what it leaves out, and which kernels it compiles. */
#ifndef SVO_LIB_PLAN_CONFIGURATION_H
#define SVO_LIB_PLAN_CONFIGURATION_H

#include "plan/plan_data.h"

SVO_I_SHARED_BEGIN

/* Fills plan->work. The last step before sizes are predicted; needs plan->stages. */
void svo_i_plan_configure(svo_plan *plan);
/* Whether a stage that runs has kernels in the program. */
bool svo_i_plan_needs_program(const svo_plan *plan, svo_i_program_kind program);
/* The -D options, a space before each, of a program for the stages; and of a variant of the voxelizer.
   bytes: SVO_I_DEFINES_BYTES are enough. */
void svo_i_plan_defines(const svo_plan *plan, svo_i_program_kind program, char *defines, size_t bytes);
void svo_i_plan_test_defines(const svo_plan *plan, svo_i_test test, char *defines, size_t bytes);

SVO_I_SHARED_END

#endif
