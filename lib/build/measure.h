/* SPDX-License-Identifier: MIT */
/*
 * A build that only measures: the stages run with the plan's capacities in place of counts, and write down what they
 * would allocate.
 */
#ifndef SVO_LIB_BUILD_MEASURE_H
#define SVO_LIB_BUILD_MEASURE_H

#include "stages/build_state.h"

/* What a build of the plan allocates, into the plan's list of buffers; and into allocations, which may be NULL, what
   one that is enqueued does. frontend: NULL for that of OpenCL alone. */
svo_status svo_i_measure(svo_plan *plan, svo_frontend *frontend, const svo_i_chunking *chunking,
                         svo_i_allocations *allocations);
/* Compiles what a build of the plan needs, and launches kernels that are new to the device once on nothing.
   build: its commands are ready; its programs are filled in. The plan's list of buffers is left alone. */
svo_status svo_i_compile(svo_i_build *build);
/* The same for the list alone. */
svo_status svo_i_compile_frontend(svo_i_build *build);
/* Predicts the plan's list of buffers and its bytes. */
svo_status svo_i_predict(svo_plan *plan);

#endif
