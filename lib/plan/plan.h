/* SPDX-License-Identifier: MIT */
/* Making a plan, up to the prediction of its sizes (build/predict.c), which needs the stages. */
#ifndef SVO_LIB_PLAN_PLAN_H
#define SVO_LIB_PLAN_PLAN_H

#include "plan/plan_data.h"

/* A plan for the request, not yet predicted. stages: the table of stages, which must outlive it. */
svo_status svo_i_plan_new(svo_device *device, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options,
                          const svo_i_stage *stages, size_t stage_count, svo_plan **out);

#endif
