/* SPDX-License-Identifier: MIT */
/*
 * The configuration of a build: what it does, what it leaves out, which kernels it compiles, and which front end it
 * should have.
 */
#ifndef SVO_LIB_PLAN_CONFIGURATION_H
#define SVO_LIB_PLAN_CONFIGURATION_H

#include "plan/plan_data.h"
#include "svocl/build.h"

/* The rules for choosing a front end. svocl::gl passes what it knows of the renderer. */

typedef struct svo_i_renderer {
    const char *name;
    bool is_software; /* draws on the CPU */
    bool in_place; /* OpenCL reads the list from OpenGL's memory */
} svo_i_renderer;

SVO_I_SHARED_BEGIN

/* Whether OpenCL alone should be faster than OpenGL, and why. reason: NULL allowed. */
bool svo_i_frontend_prefers_cl(const svo_device *device, const svo_i_renderer *renderer, svo_message *reason);

SVO_I_SHARED_END

/* Fills plan->work. Needs plan->stages, the snapped mesh and the payload inputs. Fails where work lacks room. */
svo_status svo_i_plan_configure(svo_plan *plan);
/* Whether a stage that runs has kernels in the program. */
bool svo_i_plan_needs_program(const svo_plan *plan, const svo_i_program *program);
/* The program that builds compile for a row of the table of stages; NULL where an earlier row has the same, where the
   stage does not run or has none, and for that of the front end. */
const svo_i_program *svo_i_plan_new_program(const svo_plan *plan, size_t row);

SVO_I_SHARED_BEGIN

/* The -D options of a program that stages use, a space before each. bytes: SVO_I_DEFINES_BYTES suffice for a program of
   the plan, as svo_i_plan_configure has checked. */
void svo_i_plan_defines(const svo_plan *plan, const svo_i_program *program, char *defines, size_t bytes);

SVO_I_SHARED_END

/* The same for the voxelizer's variant for an overlap test. */
void svo_i_plan_test_defines(const svo_plan *plan, svo_i_test test, char *defines, size_t bytes);

#endif
