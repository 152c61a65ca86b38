/* SPDX-License-Identifier: MIT */
/*
 * What the stages ask of OpenCL: buffers, copies and launches. Every command waits for the one before it by an event,
 * so the caller's queue may be out-of-order.
 */
#ifndef SVO_LIB_COMMANDS_COMMANDS_H
#define SVO_LIB_COMMANDS_COMMANDS_H

#include "commands/allocations.h"
#include "commands/warm_up.h"
#include "core/program.h"
#include "plan/plan_data.h"

/* The stages are the same in every mode; what a command does is not. */
typedef enum svo_i_mode {
    SVO_I_MODE_RUN = 0, /* allocates, launches, waits for counts, grows what was too small */
    SVO_I_MODE_MEASURE, /* writes down what it would allocate; counts are capacities, and nothing is launched */
    SVO_I_MODE_ENQUEUE /* launches in memory that is there and never waits; counts are capacities */
} svo_i_mode;

/* The launches of one stage, to be timed when they are done. */
typedef struct svo_i_span {
    svo_stage stage;
    cl_event first, last; /* owned */
} svo_i_span;
#define SVO_I_SPANS_MAX 24

typedef struct svo_i_commands {
    svo_i_mode mode;
    svo_device *device;
    svo_plan *plan; /* its list of buffers is kept */
    cl_command_queue queue;
    bool profiling; /* the queue has CL_QUEUE_PROFILING_ENABLE */
    svo_build_report *report;

    cl_event last; /* the newest command; NULL at first */
    cl_event stage_first; /* the first command of the open stage */
    double stage_start_ms; /* wall clock when it was opened */
    svo_i_span spans[SVO_I_SPANS_MAX]; /* of a build that was enqueued */
    size_t span_count;

    svo_i_allocations *allocations; /* measuring: written; enqueuing: handed out */
    size_t next_allocation;
    svo_i_warm_up *warm_up; /* measuring: launches its kernels on nothing; NULL: launches nothing */
} svo_i_commands;

/* The name of svo_build, for messages. */
#define SVO_I_BUILD "svo_build"

SVO_I_SHARED_BEGIN

/* What is wrong with the queue, or NULL. */
const char *svo_i_wrong_queue(const svo_device *device, cl_command_queue queue);

/* Commands of the mode SVO_I_MODE_RUN. */
svo_i_commands svo_i_commands_begin(svo_plan *plan, cl_command_queue queue, svo_build_report *report);
/* Waits for the newest command, also after a failure, and releases the events. */
void svo_i_commands_end(svo_i_commands *commands);

/* A buffer in the plan's list. */
svo_status svo_i_commands_alloc(svo_i_commands *commands, const char *name, uint64_t bytes, cl_mem *out);
/* The same, filled from the host. */
svo_status svo_i_commands_upload(svo_i_commands *commands, const char *name, const void *data, uint64_t bytes,
                                 cl_mem *out);
void svo_i_commands_free(svo_i_commands *commands, cl_mem *buffer);

/* Writes to the start of a buffer. */
svo_status svo_i_commands_write(svo_i_commands *commands, cl_mem buffer, const void *data, uint64_t bytes);
svo_status svo_i_commands_fill(svo_i_commands *commands, cl_mem buffer, const void *pattern, size_t pattern_bytes,
                               uint64_t bytes);
svo_status svo_i_commands_fill_zero(svo_i_commands *commands, cl_mem buffer, uint64_t bytes);
/* Copies bytes from the start of one buffer to an offset of another. */
svo_status svo_i_commands_copy(svo_i_commands *commands, cl_mem from, cl_mem to, uint64_t to_offset, uint64_t bytes);
/* Reads bytes from the start of a buffer; waits in the mode SVO_I_MODE_RUN. */
svo_status svo_i_commands_read(svo_i_commands *commands, cl_mem buffer, void *to, size_t bytes);
/* Waits for the newest command, in the mode SVO_I_MODE_RUN. */
svo_status svo_i_commands_wait(svo_i_commands *commands);

/* Whether kernels are launched. Measuring, they are only to be warmed up. */
bool svo_i_commands_launch_kernels(const svo_i_commands *commands);
/* A kernel of the caller's own; NULL where nothing will be launched. */
svo_status svo_i_commands_kernel(svo_i_commands *commands, cl_program program, const char *name, cl_kernel *out);
/* Sets all arguments and launches enough groups for items work-items; nothing for none. */
svo_status svo_i_commands_launch(svo_i_commands *commands, cl_kernel kernel, const svo_i_argument *arguments,
                                 cl_uint argument_count, uint64_t items);
/* Both, for a kernel that is launched once or a few times a build. */
svo_status svo_i_commands_run(svo_i_commands *commands, cl_program program, const char *name,
                              const svo_i_argument *arguments, cl_uint argument_count, uint64_t items);

SVO_I_SHARED_END

#endif
