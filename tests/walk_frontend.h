/* SPDX-License-Identifier: MIT */
/*
 * A front end for tests, in place of a rasterizer: the exact references walk the plan's snapped mesh on the host, and
 * the fragments go to OpenCL in an order as odd as a GPU's. It obeys the plan's layout as a real front end does (draws,
 * tiles, capacities, counting on when a chunk is full), so that the builder and its kernels can be tested without
 * OpenGL.
 */
#ifndef SVOCL_TESTS_WALK_FRONTEND_H
#define SVOCL_TESTS_WALK_FRONTEND_H

#include "commands/frontend.h"

typedef struct walk_frontend {
    svo_frontend frontend; /* for svo_build */
    uint64_t seed; /* of the order inside the chunks */
} walk_frontend;

/* *out must stay where it is while it is used; it owns nothing. */
void walk_frontend_init(svo_device *device, uint64_t seed, walk_frontend *out);

#endif
