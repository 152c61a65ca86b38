/* SPDX-License-Identifier: MIT */
/* The commands of one call: the queue that they go to, the buffers that stand for its arrays (svocl/submit.h), and its
   launches, in bands where one would take too long. */
#ifndef SVO_LIB_CORE_SUBMIT_H
#define SVO_LIB_CORE_SUBMIT_H

#include <stdbool.h>
#include <stddef.h>

#include "core/message.h"
#include "svocl/device.h"
#include "svocl/submit.h"

#define SVO_I_ARRAYS_MAX 2u /* of a call */

typedef struct svo_i_call {
    svo_device *device;
    const char *function; /* for messages */
    /* For the first command, and for the last one: its event, NULL for none. */
    cl_command_queue queue;
    cl_uint num_wait;
    const cl_event *wait;
    cl_event *event;
    /* Of submit.c alone. */
    bool waits; /* the call, for its commands */
    cl_event done; /* of the last command; owned, where it waits */
    cl_event *given; /* the caller's */
    cl_mem own[SVO_I_ARRAYS_MAX]; /* buffers in place of arrays in host memory */
    cl_uint own_count;
    const void *borrowed; /* the input that kernels read where it is in host memory; NULL: none */
    size_t borrowed_bytes;
    bool is_mapped; /* the output is written where it is in host memory */
    cl_mem from; /* what is read */
    void *to; /* NULL: nothing is */
    size_t first_byte, read_bytes;
} svo_i_call;

SVO_I_SHARED_BEGIN

/* Finds the queue and checks the wait list. Nothing is owned yet. out: must not be copied. */
svo_status svo_i_call_begin(svo_device *device, const char *function, const svo_submit *submit, svo_i_call *out);
/* Waits where the call has to, reads what goes to host memory, gives the caller the event, and releases the rest.
   status: of what the call did until now. Returns it, or what failed here. */
svo_status svo_i_call_end(svo_i_call *call, svo_status status);

SVO_I_SHARED_END

/* The buffer of an array that kernels read, of so many bytes; of no bytes NULL is allowed. name: for messages. */
svo_status svo_i_call_input(svo_i_call *call, const char *name, const svo_array *array, size_t bytes, cl_mem *out);
/* The same of the array that they write: a call has one. To host memory go read_bytes of them from first_byte on. */
svo_status svo_i_call_output(svo_i_call *call, const char *name, const svo_array *array, size_t bytes,
                             size_t first_byte, size_t read_bytes, cl_mem *out);
/* A kernel whose arguments are set, in whole groups, which find what is theirs by get_global_id. */
typedef struct svo_i_launch {
    cl_kernel kernel;
    size_t groups, group_items; /* at least one */
    size_t band_groups; /* of the first band, and of all that are not measured; 0: svo_device.bands, and all at once */
} svo_i_launch;

/* Launches it for a call. A driver may end a launch that takes seconds, so a call that waits does it in bands on GPUs:
   it waits for each, whose time decides how large the next one is, toward svo_device.bands.target_ms. Bands of other
   calls are not measured. The last one has the call's event. */
svo_status svo_i_call_launch(const svo_i_call *call, const svo_i_launch *launch);
/* The call waits for its last command, which is yet to come, whatever its svo_submit. */
void svo_i_call_wait(svo_i_call *call);
/* In place of a command for a call that has nothing to do: signals the event all the same. */
svo_status svo_i_call_none(svo_i_call *call);

#endif
