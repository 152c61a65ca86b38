/* SPDX-License-Identifier: MIT */
/* The arrays of plans that kernels made, for those who need them on the host. */
#ifndef SVO_LIB_PLAN_HOST_COPY_H
#define SVO_LIB_PLAN_HOST_COPY_H

#include "plan/plan_data.h"

/* Whether a plan has an array, on the host or on the device. */
bool svo_i_plan_has(const void *host, cl_mem memory);
/* Reads an array of the plan's memory; the caller frees *out. */
svo_status svo_i_plan_read(const svo_plan *plan, cl_mem memory, uint64_t bytes, void **out);
SVO_I_SHARED_BEGIN
/* Brings all arrays to the host, for front ends and builders of OpenGL and for files. Does nothing where they are. */
svo_status svo_i_plan_copy_to_host(svo_plan *plan);
SVO_I_SHARED_END
void svo_i_plan_memory_free(svo_i_plan_memory *memory);

#endif
