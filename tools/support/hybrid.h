/* SPDX-License-Identifier: MIT */
/*
 * Which triangles the front end gl-hybrid rasterizes, measured for a pair of device and renderer and kept in the user's
 * folder. A line of the file "hybrid" there is a pair: columns, device, driver, renderer, divided by tabs.
 */
#ifndef SVOCL_TOOLS_SUPPORT_HYBRID_H
#define SVOCL_TOOLS_SUPPORT_HYBRID_H

#include "support/session.h"

/* Builds the plan with several thresholds, keeps the one of the least time, and uses its front end. */
int hybrid_tune(program *state, session *opened, svo_plan *plan);

/* The front end of the threshold that is kept for the pair, and why; NULL: none is. */
svo_frontend *hybrid_recall(session *opened, svo_message *reason);

#endif
