/* SPDX-License-Identifier: MIT */
/* Compares a plan that kernels made with one of the host. Call inside a running cmocka test. */
#ifndef SVOCL_TESTS_PLAN_COMPARE_H
#define SVOCL_TESTS_PLAN_COMPARE_H

#include "plan/plan_data.h"

/* Fails unless every field of the plans and every byte of their arrays are equal, times and places aside. Brings the
   arrays of device to the host. */
void plan_compare(const svo_plan *host, svo_plan *device);

#endif
