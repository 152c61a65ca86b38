/* SPDX-License-Identifier: MIT */
/*
 * Drivers compile a kernel when it is first launched. Launching every kernel of a fresh program once on nothing counts
 * that time as compilation, so that no stage of the first build looks slow.
 */
#ifndef SVO_LIB_COMMANDS_WARM_UP_H
#define SVO_LIB_COMMANDS_WARM_UP_H

#include "core/program.h"

#define SVO_I_WARM_UP_BUFFERS  20
#define SVO_I_WARM_UP_LAUNCHES 64
#define SVO_I_WARM_UP_PROGRAMS 8

/* A kernel that was launched, and whether the launch was a large one: drivers may compile the two apart. */
typedef struct svo_i_warm_launch {
    char name[48];
    cl_program program;
    bool is_large;
} svo_i_warm_launch;

typedef struct svo_i_warm_up {
    svo_device *device;
    cl_command_queue queue;
    cl_program programs[SVO_I_WARM_UP_PROGRAMS]; /* the fresh ones; only their kernels are launched */
    size_t program_count;
    cl_mem zeros[SVO_I_WARM_UP_BUFFERS]; /* a buffer of its own for each argument, so that none aliases another */
    svo_i_warm_launch launches[SVO_I_WARM_UP_LAUNCHES];
    size_t launch_count;
    cl_event last;
} svo_i_warm_up;

svo_i_warm_up svo_i_warm_up_begin(svo_device *device, cl_command_queue queue);
void svo_i_warm_up_add_program(svo_i_warm_up *warm_up, cl_program program);
/* Launches the kernel with arguments of the same kinds and sizes, on zeros, unless a launch of that size was made. */
svo_status svo_i_warm_up_launch(svo_i_warm_up *warm_up, cl_kernel kernel, const svo_i_argument *arguments,
                                cl_uint argument_count, uint64_t items);
/* Waits for the launches and releases the buffers. */
void svo_i_warm_up_end(svo_i_warm_up *warm_up);

#endif
