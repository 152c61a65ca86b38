/* SPDX-License-Identifier: MIT */
/* Creates a plan without the prediction of its sizes, which needs the stages (build/measure.c). */
#ifndef SVO_LIB_PLAN_PLAN_H
#define SVO_LIB_PLAN_PLAN_H

#include "plan/plan_data.h"

/* Checks the request and creates a plan for it. stages: the table of stages, which must outlive the plan. */
svo_status svo_i_plan_new(svo_device *device, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options,
                          const svo_i_stage *stages, size_t stage_count, svo_plan **out);

#endif
