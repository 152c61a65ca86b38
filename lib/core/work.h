/* SPDX-License-Identifier: MIT */
/* What is made on the device outside a build: works, and chains of commands. */
#ifndef SVO_LIB_CORE_WORK_H
#define SVO_LIB_CORE_WORK_H

#include "core/device.h"
#include "core/program.h"

/*
 * Commands that follow each other on any queues: each waits for the newest one before it. One that ended with an error,
 * as after an event of the caller's that failed, must not be waited for, or all that come later would fail too. It may
 * have failed while those before it still run, so all that are in flight are kept.
 */

/* All zero: empty. */
typedef struct svo_i_in_flight {
    cl_event *events; /* owned: in the order of the commands, the newest one that has completed and those after it */
    size_t count, capacity;
} svo_i_in_flight;

SVO_I_SHARED_BEGIN

/* What the next command has to wait for; NULL: nothing. The event stays theirs. */
cl_event svo_i_in_flight_newest(svo_i_in_flight *commands);
/* Makes room for one more command, before it is enqueued. */
svo_status svo_i_in_flight_reserve(svo_i_in_flight *commands, svo_device *device, const char *function);
/* Adds a command that waits for the newest one, or for what did, where room was made; its event is retained. After a
   failure the command has ended. */
svo_status svo_i_in_flight_add(svo_i_in_flight *commands, svo_device *device, const char *function, cl_event event);
/* Waits for all and releases their events. */
void svo_i_in_flight_end(svo_i_in_flight *commands);

SVO_I_SHARED_END

/*
 * What is made on the device outside a build: scratch buffers, copies, launches. Each command waits for the previous
 * one by an event, so the caller's queue may be out-of-order.
 */

/* Most scratch buffers of one work. */
#define SVO_I_WORK_BUFFERS_MAX 24

typedef struct svo_i_device_work {
    svo_device *device;
    const char *function; /* for messages */
    cl_command_queue queue;
    cl_program program; /* of svo_i_work_launch */
    cl_uint wait_count; /* events that the first command waits for; the caller may set both */
    const cl_event *wait;
    cl_event last; /* the newest command; NULL at first */
    cl_mem partials; /* of scans; NULL before the first */
    cl_mem buffers[SVO_I_WORK_BUFFERS_MAX]; /* scratch, owned */
    uint64_t buffer_bytes[SVO_I_WORK_BUFFERS_MAX];
    size_t buffer_count;
    uint64_t live_bytes, peak_bytes; /* of scratch: now, and the most so far */
} svo_i_device_work;

/* Begins a work. queue: NULL for the device's own. */
svo_status svo_i_work_begin(svo_device *device, const char *function, cl_command_queue queue, svo_i_device_work *out);
/* The same for a work of an enqueued call, whose first command waits for events. */
svo_status svo_i_work_begin_after(svo_device *device, const char *function, cl_command_queue queue, cl_uint num_wait,
                                  const cl_event *wait, svo_i_device_work *out);
/* Waits for the newest command, also after a failure, and releases what the work owns. */
void svo_i_work_end(svo_i_device_work *work);
/* Releases what the work owns without waiting: OpenCL keeps it until the commands are done. event: receives that of the
   newest command; NULL allowed. */
void svo_i_work_leave(svo_i_device_work *work, cl_event *event);

/* Waits for the newest command. */
svo_status svo_i_work_wait(svo_i_device_work *work);

/* Selects the program of the launches that follow. */
svo_status svo_i_work_use(svo_i_device_work *work, const svo_i_program *program, const char *defines);

/* A scratch buffer, which the work owns. */
svo_status svo_i_work_alloc(svo_i_device_work *work, const char *name, uint64_t bytes, cl_mem *out);
/* A scratch buffer that kernels only read, with its content; no command is enqueued. */
svo_status svo_i_work_constants(svo_i_device_work *work, const char *name, const void *content, uint64_t bytes,
                                cl_mem *out);
/* Releases a scratch buffer early. */
void svo_i_work_free(svo_i_device_work *work, cl_mem *buffer);
/* A buffer that the caller owns. */
svo_status svo_i_work_result(svo_i_device_work *work, const char *name, uint64_t bytes, cl_mem *out);
/* The same, with bytes from the host, for kernels to read. A CPU uses the host's memory, which has to outlive
   it; others read it before the work ends. */
svo_status svo_i_work_input(svo_i_device_work *work, const char *name, const void *data, uint64_t bytes, cl_mem *out);

svo_status svo_i_work_write(svo_i_device_work *work, cl_mem buffer, const void *data, uint64_t bytes);
/* Does not wait: data must stay until the launch that follows has ended. */
svo_status svo_i_work_write_later(svo_i_device_work *work, cl_mem buffer, const void *data, uint64_t bytes);
svo_status svo_i_work_fill_zero(svo_i_device_work *work, cl_mem buffer, uint64_t bytes);
/* Fills whole words. */
svo_status svo_i_work_fill(svo_i_device_work *work, cl_mem buffer, cl_uint word, uint64_t bytes);
/* Fills whole patterns, whose size OpenCL allows. */
svo_status svo_i_work_fill_pattern(svo_i_device_work *work, cl_mem buffer, const void *pattern, size_t pattern_bytes,
                                   uint64_t bytes);
svo_status svo_i_work_copy(svo_i_device_work *work, cl_mem from, uint64_t from_offset, cl_mem to, uint64_t to_offset,
                           uint64_t bytes);
/* Reads bytes from an offset of a buffer, and does not wait: to must stay until a later command has ended. */
svo_status svo_i_work_read_later(svo_i_device_work *work, cl_mem buffer, uint64_t offset, void *to, size_t bytes);
/* The same, and waits. */
svo_status svo_i_work_read(svo_i_device_work *work, cl_mem buffer, uint64_t offset, void *to, size_t bytes);

/* Launches a kernel of the program for so many work-items, in whole groups. Launches nothing if items is 0. */
svo_status svo_i_work_launch(svo_i_device_work *work, const char *name, const svo_i_argument *arguments,
                             cl_uint argument_count, uint64_t items);
/* The same in groups of so many. */
svo_status svo_i_work_launch_groups(svo_i_device_work *work, const char *name, const svo_i_argument *arguments,
                                    cl_uint argument_count, uint64_t items, size_t group_items);
/* Takes the event of a command that the caller enqueued after work->last, which becomes the newest. */
void svo_i_work_follow(svo_i_device_work *work, cl_event event);
/* Groups of a scan of at most that many numbers: one for each tile, 1 .. device->scan_groups. */
uint32_t svo_i_scan_groups(const svo_device *device, uint64_t numbers);
/* Exclusive sums of count numbers, u32 each, into sums, which has an element more: the total. */
svo_status svo_i_work_scan(svo_i_device_work *work, cl_mem numbers, cl_mem sums, uint64_t count);

#endif
