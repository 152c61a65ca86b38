/* SPDX-License-Identifier: MIT */
/*
 * Which triangles the front end gl-hybrid rasterizes, measured for a pair of device and renderer and kept in the user's
 * folder. A line of the file "hybrid" there is a pair: columns, device, driver, renderer, divided by tabs.
 */
#ifndef SVOCL_TOOLS_SUPPORT_HYBRID_H
#define SVOCL_TOOLS_SUPPORT_HYBRID_H

#include "support/opengl.h"
#include "support/program.h"

/* Builds the plan with several thresholds, and keeps the one of the least time: *best is its front end, and reason says
   which. */
int hybrid_tune(program *state, opengl *opened, svo_plan *plan, cl_command_queue queue, svo_frontend **best,
                svo_message *reason);

/* The front end of the threshold that is kept for the pair, which may be cl, and why; NULL: none is. */
svo_frontend *hybrid_recall(opengl *opened, const svo_device *device, svo_frontend *cl, svo_message *reason);

#endif
