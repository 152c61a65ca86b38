/* SPDX-License-Identifier: MIT */
#include "core/in_flight.h"

/* Below 0: the command has failed. */
static cl_int status_of(cl_event event)
{
    cl_int status = CL_QUEUED;
    const cl_int error = clGetEventInfo(event, CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof status, &status, NULL);
    return error == CL_SUCCESS ? status : CL_QUEUED;
}

/* Forgets what has failed, and what completed before another one did. Waiting for the newest one that has completed
   costs nothing, and makes what it wrote visible, which its status alone does not. */
static void prune(svo_i_in_flight *commands)
{
    size_t kept = 0;
    for (size_t i = 0; i < commands->count; ++i) {
        cl_event event = commands->events[i];
        const cl_int status = status_of(event);
        if (status < CL_COMPLETE) {
            clReleaseEvent(event);
            continue;
        }
        if (status == CL_COMPLETE) { /* and so have all before it */
            for (size_t k = 0; k < kept; ++k) {
                clReleaseEvent(commands->events[k]);
            }
            kept = 0;
        }
        commands->events[kept++] = event;
    }
    commands->count = kept;
}

cl_event svo_i_in_flight_newest(svo_i_in_flight *commands)
{
    prune(commands);
    return commands->count > 0 ? commands->events[commands->count - 1] : NULL;
}

svo_status svo_i_in_flight_reserve(svo_i_in_flight *commands, svo_device *device, const char *function)
{
    enum { FIRST_CAPACITY = 8 };
    prune(commands);
    if (commands->count < commands->capacity) {
        return SVO_OK;
    }
    const size_t capacity = commands->capacity > 0 ? commands->capacity * 2 : FIRST_CAPACITY;
    cl_event *events = svo_i_grow(&device->memory, commands->events, capacity * sizeof(cl_event));
    if (events == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu events", function, capacity);
    }
    commands->events = events;
    commands->capacity = capacity;
    return SVO_OK;
}

svo_status svo_i_in_flight_add(svo_i_in_flight *commands, svo_device *device, const char *function, cl_event event)
{
    const cl_int error = clRetainEvent(event);
    if (error != CL_SUCCESS) {
        (void)svo_i_event_settle(event); /* so that nothing need wait for it */
        return svo_i_device_fail_cl(device, function, "clRetainEvent", error);
    }
    commands->events[commands->count++] = event;
    return SVO_OK;
}

void svo_i_in_flight_end(svo_i_in_flight *commands)
{
    for (size_t i = 0; i < commands->count; ++i) {
        (void)svo_i_event_settle(commands->events[i]);
        clReleaseEvent(commands->events[i]);
    }
    svo_i_free(commands->events);
    *commands = (svo_i_in_flight){.events = NULL};
}
