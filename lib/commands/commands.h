/* SPDX-License-Identifier: MIT */
/*
 * Buffers, copies and launches for the stages. Each command waits for the previous one by an event, so the caller's
 * queue may be out-of-order.
 *
 * The files of this room:
 *
 *   commands  buffers, copies and launches in three modes; allocations; the times of stages
 *   warm_up   launches of newly compiled kernels
 *   frontend  the interface of front ends
 */
#ifndef SVO_LIB_COMMANDS_COMMANDS_H
#define SVO_LIB_COMMANDS_COMMANDS_H

#include "commands/warm_up.h"
#include "core/device.h"
#include "core/program.h"
#include "plan/plan_data.h"

/*
 * The allocations of a build, in order, with their lifetimes. A measuring build records them. Enqueued builds take them
 * in the same order. Buffers with disjoint lifetimes share memory.
 */

typedef struct svo_i_allocation {
    const char *name; /* static string */
    uint64_t bytes;
    uint64_t born, died; /* clock values of the allocation and the release; died UINT64_MAX: never released */
    uint64_t offset_bytes; /* in the scratch memory */
    bool persistent; /* part of the tree, not scratch */
    cl_mem memory; /* owned; a sub-buffer of the scratch memory; NULL until there is one */
} svo_i_allocation;

typedef struct svo_i_allocations {
    svo_i_allocation *entries;
    size_t count, capacity;
    uint64_t clock; /* counts allocations and releases */
    uint64_t scratch_bytes; /* size of the scratch memory; set by svo_i_allocations_place */
} svo_i_allocations;

/* Assigns offsets to the scratch entries, in multiples of alignment bytes. */
void svo_i_allocations_place(svo_i_allocations *list, uint64_t alignment);
/* Frees the list and releases the memory of its entries. */
void svo_i_allocations_free(svo_i_allocations *list);

/* Stages issue the same commands in every mode; the mode selects what a command does. */
typedef enum svo_i_mode {
    SVO_I_MODE_RUN = 0, /* a blocking build: allocates, launches, waits for counts, grows buffers that were too small */
    SVO_I_MODE_MEASURE, /* records allocations and launches nothing, except for warm-up; counts are capacities */
    /* Launches in the workspace's memory and never waits; counts are capacities. Without a workspace's allocations it
       makes its own, which OpenCL keeps until the commands are done. */
    SVO_I_MODE_ENQUEUE
} svo_i_mode;

/* The first and last command of a stage, for timing after the build has ended. */
typedef struct svo_i_span {
    svo_stage stage;
    cl_event first, last; /* owned */
} svo_i_span;
#define SVO_I_SPANS_MAX 24

/* The mesh's buffers; NULL where they are not uploaded or the tree has taken them. */
typedef struct svo_i_build_mesh {
    cl_mem vertices, indices;
    cl_mem positions; /* the mesh's own, floats or doubles */
} svo_i_build_mesh;

typedef struct svo_i_commands {
    svo_i_mode mode;
    svo_device *device;
    svo_plan *plan; /* allocations update its list of buffers */
    cl_command_queue queue;
    bool profiling; /* the queue has CL_QUEUE_PROFILING_ENABLE */
    bool untimed; /* nobody asks for the times of stages */
    bool blocks; /* SVO_I_MODE_RUN: writes wait, since their sources end before the build does */
    uint64_t released_bytes; /* SVO_I_MODE_RUN: of buffers released since the last wait, which may still be in use */
    svo_i_build_mesh mesh; /* what stages share of it; stages/inputs.h */
    svo_build_report *report;
    svo_stage stage; /* that the progress reports */
    double item_ns; /* rough time of a work-item of the next launches, for the progress; stages may set it */

    cl_event last; /* the newest command; NULL at first */
    cl_event stage_first; /* the first command of the current stage */
    double stage_start_ms; /* wall clock at the start of the current stage */
    svo_i_span spans[SVO_I_SPANS_MAX]; /* whose times svo_i_stage_collect will read */
    size_t span_count;

    svo_i_allocations *allocations; /* SVO_I_MODE_MEASURE appends to it; SVO_I_MODE_ENQUEUE takes from it; or NULL */
    size_t next_allocation; /* SVO_I_MODE_ENQUEUE: the next entry to take */
    svo_i_warm_up *warm_up; /* SVO_I_MODE_MEASURE: performs warm-up launches; NULL: no launches */
    double *expected_ns; /* SVO_I_MODE_MEASURE: receives the predicted time of each stage; NULL: not wanted */
} svo_i_commands;

/* An allocation waits while more released memory than this may be in use, so that a build's peak on the device is about
   the plan's. Small builds never wait for that. */
#define SVO_I_RELEASED_BYTES_MAX (16u << 20)

/* Commands in SVO_I_MODE_RUN. */
svo_i_commands svo_i_commands_begin(svo_plan *plan, cl_command_queue queue, svo_build_report *report);
/* Waits for the newest command, also after a failure, and releases the events. */
void svo_i_commands_end(svo_i_commands *commands);

SVO_I_SHARED_BEGIN

/* Allocates a buffer and adds it to the plan's list. name: a static string that the table of stages lists. */
svo_status svo_i_commands_alloc(svo_i_commands *commands, const char *name, uint64_t bytes, cl_mem *out);
/* The same for several scratch buffers that are released together: few allocations of OpenCL. */
svo_status svo_i_commands_alloc_all(svo_i_commands *commands, const svo_i_request *requests, size_t count);
/* Allocates a buffer and fills it from the host. The data must stay until the next wait. */
svo_status svo_i_commands_upload(svo_i_commands *commands, const char *name, const void *data, uint64_t bytes,
                                 cl_mem *out);

/* An array of the plan, for commands that only read it: its memory on the device, or where that is NULL a buffer that
   is filled from the host. */
svo_status svo_i_commands_borrow(svo_i_commands *commands, const char *name, const void *host, cl_mem memory,
                                 uint64_t bytes, cl_mem *out);
/* The same in a buffer that outlives the plan. */
svo_status svo_i_commands_take(svo_i_commands *commands, const char *name, const void *host, cl_mem memory,
                               uint64_t bytes, cl_mem *out);

SVO_I_SHARED_END

/* Releases a buffer, unless it is the plan's, and sets it to NULL; NULL allowed. */
void svo_i_commands_free(svo_i_commands *commands, cl_mem *buffer);

/* Writes bytes to the start of a buffer. The data must stay until the next wait. */
svo_status svo_i_commands_write(svo_i_commands *commands, cl_mem buffer, const void *data, uint64_t bytes);
/* Fills bytes from the start of a buffer with a pattern. */
svo_status svo_i_commands_fill(svo_i_commands *commands, cl_mem buffer, const void *pattern, size_t pattern_bytes,
                               uint64_t bytes);
svo_status svo_i_commands_fill_zero(svo_i_commands *commands, cl_mem buffer, uint64_t bytes);
/* Copies bytes from the start of one buffer to an offset of another. */
svo_status svo_i_commands_copy(svo_i_commands *commands, cl_mem from, cl_mem to, uint64_t to_offset, uint64_t bytes);
/* Reads bytes from the start of a buffer. Waits for the result in SVO_I_MODE_RUN only. */
svo_status svo_i_commands_read(svo_i_commands *commands, cl_mem buffer, void *to, size_t bytes);
/* Waits for the newest command in SVO_I_MODE_RUN; returns at once in other modes. */
svo_status svo_i_commands_wait(svo_i_commands *commands);

/* The launches that follow are a stage's: their progress is reported as that stage's. */
void svo_i_commands_stage(svo_i_commands *commands, svo_stage stage, double item_ns);

/* Work-items of a part of a large launch. A multiple of the group, and large enough for drivers that compile small
   launches separately. */
#define SVO_I_PART_ITEMS (1u << 18)
/* In how many parts to launch work-items: 1, or more in a blocking build with a callback. All but the last have
   SVO_I_PART_ITEMS. */
uint64_t svo_i_commands_parts(const svo_i_commands *commands, uint64_t items);

/* Whether launches reach the device, be it for warm-up only. */
bool svo_i_commands_launch_kernels(const svo_i_commands *commands);
/* A new kernel, which the caller releases; NULL if svo_i_commands_launch_kernels is false. */
svo_status svo_i_commands_kernel(svo_i_commands *commands, cl_program program, const char *name, cl_kernel *out);
/* Sets all arguments and launches enough work-groups for items work-items. Launches nothing if items is 0. */
svo_status svo_i_commands_launch(svo_i_commands *commands, cl_kernel kernel, const svo_i_argument *arguments,
                                 cl_uint argument_count, uint64_t items);
/* The same with work-groups of so many work-items, which divide SVO_GROUP_ITEMS. */
svo_status svo_i_commands_launch_groups(svo_i_commands *commands, cl_kernel kernel, const svo_i_argument *arguments,
                                        cl_uint argument_count, uint64_t items, size_t group_items);
/* Creates a kernel, launches it and releases it: for kernels that a build launches only a few times. */
svo_status svo_i_commands_run(svo_i_commands *commands, cl_program program, const char *name,
                              const svo_i_argument *arguments, cl_uint argument_count, uint64_t items);

/* The time of each stage, from its first to its last command: from OpenCL's events, or from the wall clock. */

SVO_I_SHARED_BEGIN

/* Adds to a stage's time. clock: a static string. */
void svo_i_report_add(svo_build_report *report, svo_stage stage, double ms, const char *clock);

SVO_I_SHARED_END

/* Commands between begin and end are timed as the stage's. A stage may begin several times; its times add up. */
void svo_i_stage_begin(svo_i_commands *commands);
svo_status svo_i_stage_end(svo_i_commands *commands, svo_stage stage);
/* Adds the times of a build that has ended to the report, and releases their events. */
void svo_i_stage_collect(svo_i_commands *commands);

#endif
