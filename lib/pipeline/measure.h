/* SPDX-License-Identifier: MIT */
/*
 * Measuring builds: the stages run with the plan's capacities instead of counts and record what they would allocate.
 * Plans predict their sizes, workspaces size their memory and builds warm up their kernels with them.
 */
#ifndef SVO_LIB_PIPELINE_MEASURE_H
#define SVO_LIB_PIPELINE_MEASURE_H

#include "stages/build_state.h"

/* Records what a build of the plan allocates, in the plan's list of buffers. allocations: also receives the allocations
   of an enqueued build; NULL measures a blocking build. frontend: NULL for "cl". */
svo_status svo_i_measure(svo_plan *plan, svo_frontend *frontend, const svo_i_chunking *chunking,
                         svo_i_allocations *allocations);
/* Compiles what a build of the plan needs, and warms up newly compiled kernels. build: its commands and frontend are
   set; its programs are filled in. The plan's list of buffers does not change. */
svo_status svo_i_compile(svo_i_build *build);
/* The same for the fragment list alone. */
svo_status svo_i_compile_frontend(svo_i_build *build);
/* Fills the plan's list of buffers with a prediction, and sets its predicted_bytes. */
svo_status svo_i_predict(svo_plan *plan);

#endif
