/* SPDX-License-Identifier: MIT */
/* Rays through light field probes by the eight around their origin, as published: the kernel of published_probes.cl. */
#ifndef SVOCL_TOOLS_ERRORS_PUBLISHED_PROBES_H
#define SVOCL_TOOLS_ERRORS_PUBLISHED_PROBES_H

#include <stdbool.h>
#include <stddef.h>

#include "svocl/device.h"
#include "svocl/probes.h"

typedef struct published_probes {
    cl_context context; /* the device's */
    cl_command_queue queue; /* the caller's */
    cl_program program;
    cl_kernel kernel;
} published_probes;

/* probes: on the device, and they outlive this; queue: on its context. False on failure; what was made then is still
   released by published_probes_free. */
bool published_probes_make(svo_device *device, svo_probes *probes, cl_command_queue queue, published_probes *out);
void published_probes_free(published_probes *made);

/* svo_probes_trace of this choice, from host to host. */
bool published_probes_trace(const published_probes *made, const svo_ray *rays, svo_probe_hit *hits, size_t count);

#endif
