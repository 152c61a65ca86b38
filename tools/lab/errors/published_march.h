/* SPDX-License-Identifier: MIT */
/* Light gathered at points as older systems do, by five cones that march from node to node: the kernel of
   published.cl. */
#ifndef SVOCL_TOOLS_ERRORS_PUBLISHED_MARCH_H
#define SVOCL_TOOLS_ERRORS_PUBLISHED_MARCH_H

#include <stdbool.h>
#include <stddef.h>

#include "svocl/device.h"
#include "svocl/light.h"

typedef struct published_march {
    svo_light *light; /* the caller's */
    cl_command_queue queue; /* the caller's */
    size_t count; /* of points */
    cl_program program;
    cl_kernel kernel;
    cl_mem points, results;
} published_march;

/* light: of the form bricks, with its sources, on the device; queue: on its context. False on failure; what was made
   then is still released by published_march_free. */
bool published_march_make(svo_device *device, svo_light *light, size_t count, cl_command_queue queue,
                          published_march *out);
void published_march_free(published_march *made);

/* svo_gather by this march, of count points: within a range of world units, 0 to the end of the grid; or occlusion
   alone. */
bool published_march_gather(published_march *made, const svo_gather_point *points, svo_gather_result *results,
                            float range, bool with_light);

#endif
