/* SPDX-License-Identifier: MIT */
/* Makes updatable plans. */
#ifndef SVO_LIB_PLAN_UPDATE_CREATE_H
#define SVO_LIB_PLAN_UPDATE_CREATE_H

#include "plan/update.h"

/* Makes the plan's arrays and plan->update from the input, and waits. mesh receives the input's arrays; the caller
   frees it. */
svo_status svo_i_update_create(svo_plan *plan, svo_i_device_work *work, const svo_i_plan_input *input,
                               svo_i_device_mesh *mesh);

#endif
