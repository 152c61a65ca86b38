/* SPDX-License-Identifier: MIT */
/* Counts buffers by their destructor callbacks, which a driver may call on any thread. */
#define _POSIX_C_SOURCE 200809L
#include "core/budget.h"

#include <stdatomic.h>
#include <time.h>

/* Waits for buffers that the driver is about to destroy, in milliseconds. */
#define DESTROY_WAITS 100

struct svo_i_budget {
    svo_i_memory memory; /* of the counted buffers */
    uint64_t max_bytes;
    atomic_uint_least64_t held_bytes;
    atomic_uint_least64_t users; /* the handle and the buffers */
};

/* A buffer that counts. */
typedef struct counted_buffer {
    svo_i_budget *budget;
    uint64_t bytes;
} counted_buffer;

svo_i_budget *svo_i_budget_create(const svo_i_memory *memory, uint64_t max_bytes)
{
    svo_i_budget *budget = svo_i_alloc_zeroed(memory, 1, sizeof *budget);
    if (budget != NULL) {
        budget->memory = *memory;
        budget->max_bytes = max_bytes;
        atomic_init(&budget->held_bytes, 0);
        atomic_init(&budget->users, 1);
    }
    return budget;
}

void svo_i_budget_release(svo_i_budget *budget)
{
    if (budget != NULL && atomic_fetch_sub(&budget->users, 1) == 1) {
        svo_i_free(budget);
    }
}

uint64_t svo_i_budget_max(const svo_i_budget *budget)
{
    return budget != NULL ? budget->max_bytes : UINT64_MAX;
}

uint64_t svo_i_budget_held(const svo_i_budget *budget)
{
    return budget != NULL ? atomic_load(&budget->held_bytes) : 0;
}

static bool fits_now(const svo_i_budget *budget, uint64_t bytes)
{
    const uint64_t held = svo_i_budget_held(budget);
    return budget == NULL || (held <= budget->max_bytes && bytes <= budget->max_bytes - held);
}

bool svo_i_budget_fits(const svo_i_budget *budget, uint64_t bytes)
{
    const struct timespec millisecond = {.tv_nsec = 1000000};
    bool fits = fits_now(budget, bytes);
    for (unsigned i = 0; !fits && i < DESTROY_WAITS && bytes <= svo_i_budget_max(budget); ++i) {
        nanosleep(&millisecond, NULL);
        fits = fits_now(budget, bytes);
    }
    return fits;
}

static void CL_CALLBACK forget(cl_mem buffer, void *user)
{
    counted_buffer *counted = user;
    (void)buffer;
    atomic_fetch_sub(&counted->budget->held_bytes, counted->bytes);
    svo_i_budget_release(counted->budget);
    svo_i_free(counted);
}

cl_int svo_i_budget_count(svo_i_budget *budget, cl_mem buffer, uint64_t bytes)
{
    if (budget == NULL) {
        return CL_SUCCESS;
    }
    counted_buffer *counted = svo_i_alloc(&budget->memory, sizeof *counted);
    if (counted == NULL) {
        return CL_OUT_OF_HOST_MEMORY;
    }
    *counted = (counted_buffer){budget, bytes};
    atomic_fetch_add(&budget->held_bytes, bytes);
    atomic_fetch_add(&budget->users, 1);
    const cl_int error = clSetMemObjectDestructorCallback(buffer, forget, counted);
    if (error != CL_SUCCESS) {
        forget(buffer, counted);
    }
    return error;
}
