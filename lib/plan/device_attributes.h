/* SPDX-License-Identifier: MIT */
/* The payload inputs by kernels: the same steps and the same bytes as attributes.c on the host. */
#ifndef SVO_LIB_PLAN_DEVICE_ATTRIBUTES_H
#define SVO_LIB_PLAN_DEVICE_ATTRIBUTES_H

#include "plan/device_mesh.h"

/* Resolves SVO_NEED_DEFAULT, fills the payload inputs and finds constant payload. mesh receives the arrays that are
   read; the caller frees it. */
svo_status svo_i_device_attributes(svo_plan *plan, svo_i_device_work *work, const svo_i_plan_input *input,
                                   svo_i_device_mesh *mesh);

#endif
