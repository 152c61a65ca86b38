/* SPDX-License-Identifier: MIT */
/*
 * Commands that follow each other on any queues: each waits for the newest one before it. One that ended with an error,
 * as after an event of the caller's that failed, must not be waited for, or all that come later would fail too. It may
 * have failed while those before it still run, so all that are in flight are kept.
 */
#ifndef SVO_LIB_CORE_IN_FLIGHT_H
#define SVO_LIB_CORE_IN_FLIGHT_H

#include "core/device.h"

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

#endif
