/* SPDX-License-Identifier: MIT */
/*
 * The stages of a plan: compiled, measured and run, in every mode; the reports of builds.
 *
 * The files of this room:
 *
 *   run        compiles, measures and runs the stages; svo_plan_create, reports
 *   build      svo_build, which waits; the fragment list; svo_plan_count, svo_device_warm
 *   workspace  the memory of enqueued builds, and those that are not finished
 *   enqueue    svo_build_enqueue and svo_tree_finish
 */
#ifndef SVO_LIB_PIPELINE_RUN_H
#define SVO_LIB_PIPELINE_RUN_H

#include "core/device.h"
#include "plan/arrays.h"
#include "stages/build_state.h"
#include "svocl/build.h"

/* svo_plan_create of any input. function: begins messages. */
svo_status svo_i_plan_create(svo_device *device, const char *function, const svo_i_plan_input *input, unsigned depth,
                             const svo_plan_options *options, svo_plan **out);

/* Writing build reports to the caller's struct, which may be of an earlier version. */

/* Checks struct_size of a report; NULL is allowed. */
svo_status svo_i_report_check(svo_device *device, const char *function, const svo_build_report *report);
/* Copies the fields that the caller's report has; NULL is allowed. */
void svo_i_report_write(const svo_build_report *made, svo_build_report *report);

/* Runs all stages that follow the fragment list. */
svo_status svo_i_order_run(svo_i_build *build);
/* Releases everything but the tree. No command may use it any more. */
void svo_i_order_release_scratch(svo_i_build *build);

/*
 * Measuring builds: the stages run with the plan's capacities instead of counts and record what they would allocate.
 * Plans predict their sizes, workspaces size their memory and builds warm up their kernels with them.
 */

/* Records what a build of the plan allocates, in the plan's list of buffers. allocations: also receives the allocations
   of an enqueued build; NULL measures a blocking build. frontend: NULL for "cl". */
svo_status svo_i_measure(svo_plan *plan, svo_frontend *frontend, const svo_i_chunking *chunking,
                         svo_i_allocations *allocations);
/* Compiles what a build of the plan needs, and warms up newly compiled kernels. build: its commands and frontend are
   set; its programs are filled in. The plan's list of buffers does not change. */
svo_status svo_i_compile(svo_i_build *build);
/* The same for the fragment list alone. */
svo_status svo_i_compile_frontend(svo_i_build *build);

SVO_I_SHARED_BEGIN

/* A plan of the whole, for the header of its parts: as svo_plan_create, but up to SVO_PARTS_DEPTH_MAX, and without a
   prediction, since it is not built. function: for messages. */
svo_status svo_i_plan_of_parts(svo_device *device, const char *function, const svo_mesh *mesh, unsigned depth,
                               const svo_plan_options *options, svo_plan **out);
/* Fills the plan's list of buffers with a prediction, and sets its predicted_bytes. */
svo_status svo_i_predict(svo_plan *plan);

SVO_I_SHARED_END

#endif
