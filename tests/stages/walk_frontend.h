/* SPDX-License-Identifier: MIT */
/*
 * A front end for tests that replaces the rasterizer: the exact reference walks the plan's mesh on the host, and the
 * fragments go to OpenCL in an order as irregular as a GPU's. It follows the plan's layout like a real front end
 * (draws, tiles, capacities, counting beyond a full chunk), so that the builder and its kernels can be tested without
 * OpenGL.
 */
#ifndef SVOCL_TESTS_WALK_FRONTEND_H
#define SVOCL_TESTS_WALK_FRONTEND_H

#include "commands/frontend.h"

typedef struct walk_frontend {
    svo_frontend frontend; /* for svo_build */
    uint64_t seed; /* for the order inside the chunks */
} walk_frontend;

/* *out must not move while it is used; it owns nothing. */
void walk_frontend_init(svo_device *device, uint64_t seed, walk_frontend *out);

#endif
