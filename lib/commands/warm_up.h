/* SPDX-License-Identifier: MIT */
/*
 * Warm-up launches. Some drivers compile a kernel at its first launch. Launching every kernel of a newly compiled
 * program once, on empty input, counts that time as compilation and not as a stage of the first build.
 */
#ifndef SVO_LIB_COMMANDS_WARM_UP_H
#define SVO_LIB_COMMANDS_WARM_UP_H

#include "core/program.h"
#include "plan/plan_data.h"

/* The name of svo_build, for messages. */
#define SVO_I_BUILD "svo_build"

/* Limits of a warm-up. A build that exceeds one fails with SVO_INTERNAL. */
#define SVO_I_WARM_UP_BUFFERS  22 /* buffer arguments of a kernel */
#define SVO_I_WARM_UP_LAUNCHES 64
#define SVO_I_WARM_UP_PROGRAMS 16

/* A warm-up launch. Drivers may compile a kernel once for small and once for large launches. */
typedef struct svo_i_warm_launch {
    char name[48];
    cl_program program;
    bool is_large;
} svo_i_warm_launch;

typedef struct svo_i_warm_up {
    svo_device *device;
    svo_plan *plan; /* whose callback is told */
    cl_command_queue queue;
    cl_program programs[SVO_I_WARM_UP_PROGRAMS]; /* newly compiled; only their kernels are launched */
    size_t program_count;
    cl_mem zeros[SVO_I_WARM_UP_BUFFERS]; /* one per buffer argument, so that no two arguments alias */
    svo_i_warm_launch launches[SVO_I_WARM_UP_LAUNCHES];
    size_t launch_count;
    cl_event last;
} svo_i_warm_up;

svo_i_warm_up svo_i_warm_up_begin(svo_plan *plan, cl_command_queue queue);
svo_status svo_i_warm_up_add_program(svo_i_warm_up *warm_up, cl_program program);
/* Launches the kernel on zeros, with arguments of the same kinds and sizes. Kernels that were warmed up at this launch
   size, and kernels of programs that are not new, are skipped. */
svo_status svo_i_warm_up_launch(svo_i_warm_up *warm_up, cl_kernel kernel, const svo_i_argument *arguments,
                                cl_uint argument_count, uint64_t items, size_t group_items);
/* Waits for the launches and releases the buffers. */
void svo_i_warm_up_end(svo_i_warm_up *warm_up);

#endif
