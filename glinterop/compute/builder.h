/* SPDX-License-Identifier: MIT */
/* Creates and destroys what compute shaders of one context need, and says whether the context can build. */
#ifndef SVO_GLINTEROP_COMPUTE_BUILDER_H
#define SVO_GLINTEROP_COMPUTE_BUILDER_H

#include "compute/compute.h"

/* no_int64: as if the context had no 64-bit integers. Compiles nothing yet. SVO_GL_ERROR, SVO_OUT_OF_HOST_MEMORY. */
svo_status svo_i_compute_create(svo_device *device, svo_gl_context *context, bool no_int64, svo_i_compute **out);
void svo_i_compute_destroy(svo_i_compute **compute);
/* Why a tree with these needs (svo_need bits) cannot be built by this context: "" if it can. */
void svo_i_compute_reason(const svo_gl_context *context, bool no_int64, uint32_t need, char *reason,
                          size_t reason_bytes);

#endif
