/* SPDX-License-Identifier: MIT */
/* Creates a plan without the prediction of its sizes, which needs the stages (pipeline/run.c). */
#ifndef SVO_LIB_PLAN_PLAN_H
#define SVO_LIB_PLAN_PLAN_H

#include "plan/arrays.h"
#include "plan/plan_data.h"

/* Plans of fewer triangles are made on the host: launches would take longer. */
#define SVO_I_KERNEL_TRIANGLES_MIN 4096u
/* A handle loads the plan's kernels when its plans had so many triangles in all: until then the host takes less than a
   fourth of a second longer, and compiling the kernels where no driver has saved them takes two. */
#define SVO_I_LOAD_TRIANGLES 524288u

/* The table of stages, which must outlive plans. */
typedef struct svo_i_stage_list {
    const svo_i_stage *rows;
    size_t count;
} svo_i_stage_list;

/* Checks the request and creates a plan for it. function: the public one, for messages. device, input and out: not
   NULL. */
svo_status svo_i_plan_new(svo_device *device, const char *function, const svo_i_plan_input *input, unsigned depth,
                          const svo_plan_options *options, const svo_i_stage_list *stages, svo_plan **out);

SVO_I_SHARED_BEGIN

/* Grid units per axis of a tree of that depth, as a power of two. */
uint32_t svo_i_plan_snap_bits(uint32_t depth);

SVO_I_SHARED_END

#endif
