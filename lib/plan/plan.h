/* SPDX-License-Identifier: MIT */
/* Creates a plan without the prediction of its sizes, which needs the stages (pipeline/measure.c). */
#ifndef SVO_LIB_PLAN_PLAN_H
#define SVO_LIB_PLAN_PLAN_H

#include "plan/device_mesh.h"

/* The table of stages, which must outlive plans. */
typedef struct svo_i_stage_list {
    const svo_i_stage *rows;
    size_t count;
} svo_i_stage_list;

/* Checks the request and creates a plan for it. function: the public one, for messages. device, input and out: not
   NULL. */
svo_status svo_i_plan_new(svo_device *device, const char *function, const svo_i_plan_input *input, unsigned depth,
                          const svo_plan_options *options, const svo_i_stage_list *stages, svo_plan **out);

#endif
