/* SPDX-License-Identifier: MIT */
/*
 * The budget of a device handle: how many bytes the OpenCL buffers may have that live at the same time. A buffer counts
 * until the driver destroys it, whoever holds it last. Handles without a budget count nothing.
 */
#ifndef SVO_LIB_CORE_BUDGET_H
#define SVO_LIB_CORE_BUDGET_H

#include <stdbool.h>
#include <stdint.h>

#include "core/memory.h"
#include "svocl/device.h"

/* Shared by a device handle and its buffers, some of which may live longer. */
typedef struct svo_i_budget svo_i_budget;

/* NULL when out of memory. */
svo_i_budget *svo_i_budget_create(const svo_i_memory *memory, uint64_t max_bytes);
/* Gives up the handle's part; NULL allowed. */
void svo_i_budget_release(svo_i_budget *budget);

/* The most bytes; UINT64_MAX without a budget. */
uint64_t svo_i_budget_max(const svo_i_budget *budget);
/* The bytes of the buffers that live. */
uint64_t svo_i_budget_held(const svo_i_budget *budget);
/* Whether so many more bytes fit. A driver may destroy a released buffer a moment after the last command that used it,
   so this waits up to a tenth of a second before it says no. */
bool svo_i_budget_fits(const svo_i_budget *budget, uint64_t bytes);

/* Counts a new buffer until it is destroyed. Returns an error of OpenCL, and then counts nothing. */
cl_int svo_i_budget_count(svo_i_budget *budget, cl_mem buffer, uint64_t bytes);

#endif
