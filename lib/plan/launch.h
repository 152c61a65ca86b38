/* SPDX-License-Identifier: MIT */
/* Launches of the plan's kernels (kernels/plan). Each command waits for the one before by an event. */
#ifndef SVO_LIB_PLAN_LAUNCH_H
#define SVO_LIB_PLAN_LAUNCH_H

#include "core/program.h"

typedef struct svo_i_launcher {
    svo_device *device;
    const char *function; /* for messages */
    cl_command_queue queue;
    cl_program program;
    cl_uint wait_count; /* of the first command */
    const cl_event *wait;
    cl_event last; /* the newest command; NULL at first */
} svo_i_launcher;

/* Whether a handle has the plan's program already. */
bool svo_i_launcher_is_ready(const svo_device *device);
/* Gets the program. queue, wait_count and wait are set. */
svo_status svo_i_launcher_begin(svo_i_launcher *launcher, svo_device *device, const char *function);
/* Waits for the newest command, also after a failure. */
void svo_i_launcher_end(svo_i_launcher *launcher);

/* A buffer of at least one byte. */
svo_status svo_i_launcher_buffer(svo_i_launcher *launcher, const char *name, uint64_t bytes, cl_mem *out);
/* A buffer with bytes from the host. It may use the host's memory, which has to outlive it. */
svo_status svo_i_launcher_input(svo_i_launcher *launcher, const char *name, const void *data, uint64_t bytes,
                                cl_mem *out);
/* Releases a buffer; NULL allowed. */
void svo_i_launcher_free(cl_mem *buffer);
svo_status svo_i_launcher_fill(svo_i_launcher *launcher, cl_mem buffer, const void *pattern, size_t pattern_bytes,
                               uint64_t bytes);
svo_status svo_i_launcher_zero(svo_i_launcher *launcher, cl_mem buffer, uint64_t bytes);
svo_status svo_i_launcher_copy(svo_i_launcher *launcher, cl_mem from, cl_mem to, uint64_t bytes);
/* Does not wait: data must stay until the launch that follows it has ended. */
svo_status svo_i_launcher_write(svo_i_launcher *launcher, cl_mem buffer, const void *data, uint64_t bytes);
/* Waits for the result. */
svo_status svo_i_launcher_read(svo_i_launcher *launcher, cl_mem buffer, uint64_t offset, void *to, uint64_t bytes);
/* Launches enough work-groups for items work-items; nothing if items is 0. */
svo_status svo_i_launcher_run(svo_i_launcher *launcher, const char *kernel, const svo_i_argument *arguments,
                              cl_uint argument_count, uint64_t items);

#endif
