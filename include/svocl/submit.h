/* SPDX-License-Identifier: MIT */
/** \file
 * What calls have in common that put commands into a queue: where the commands go, what they wait for, and where the
 * arrays are that they read and write.
 */
#ifndef SVOCL_SUBMIT_H
#define SVOCL_SUBMIT_H

#include <stdint.h>

#include "svocl/device.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Where the commands of a call go.
 *
 *     svo_trace_triangles(target, svo_in_host(rays), svo_in_host(hits), count, SVO_TRACE_CLOSEST, NULL);
 *     svo_submit submit = {.queue = queue, .num_wait = 1, .wait = &written, .event = &traced};
 *     svo_trace_triangles(target, svo_in_buffer(rays), svo_in_buffer(hits), count, SVO_TRACE_CLOSEST, &submit);
 *
 * In place of one, NULL means the device's own queue, and that the call returns when its commands are complete. With
 * one, the call returns when its commands are in the queue, unless one of its arrays is in host memory. All zero: the
 * device's own queue, which is in-order. This struct does not grow.
 *
 * Drivers of GPUs with a display end a launch that takes seconds. A call that waits for rays, points or pixels launches
 * them in bands there, of about 50 ms each, with the same results. One that returns at once cannot know how long they
 * take: rays and points are one launch, pictures are launches of so many pixels. */
typedef struct svo_submit {
    cl_command_queue queue; /**< of the handle's context and device, in-order or out-of-order; NULL: the device's own */
    cl_uint num_wait; /**< number of events in wait */
    const cl_event *wait; /**< events of that context that the commands wait for; NULL when num_wait is 0 */
    cl_event *event; /**< receives an event of all commands, which the caller releases; NULL allowed */
} svo_submit;

/** An array in host memory or in a buffer; all zero: none. This struct does not grow. */
typedef struct svo_array {
    /** Host memory. It is read or written until the call returns, which waits for that; after a failure what a call
     *  writes is undefined. On CPUs kernels use it where it is, without a copy, if it is aligned to 16 bytes and, where
     *  it is written, is written whole (bands of pictures are not) and has no byte of what is read. NULL: the array is
     *  in buffer */
    void *host;
    /** Of the context of the call's device, from its first byte on; a sub-buffer serves as well. What a call writes is
     *  not CL_MEM_READ_ONLY. Unused with host */
    cl_mem buffer;
} svo_array;

/** An array in host memory.
 *
 * \param host its first byte, written only by calls that say so
 * \returns the array. */
static inline svo_array svo_in_host(const void *host)
{
    const svo_array array = {(void *)(uintptr_t)host, NULL};
    return array;
}

/** An array in a buffer.
 *
 * \param buffer see svo_array
 * \returns the array. */
static inline svo_array svo_in_buffer(cl_mem buffer)
{
    const svo_array array = {NULL, buffer};
    return array;
}

#ifdef __cplusplus
}
#endif

#endif
