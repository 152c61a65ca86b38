/* SPDX-License-Identifier: MIT */
/* Creates and destroys the builder, and reports whether a context can build. */
#ifndef SVO_GLINTEROP_COMPUTE_BUILDER_H
#define SVO_GLINTEROP_COMPUTE_BUILDER_H

#include "compute/compute.h"

/* Compiles nothing yet. Returns SVO_GL_ERROR or SVO_OUT_OF_HOST_MEMORY on failure. */
svo_status svo_i_compute_create(svo_device *device, svo_gl_context *context, svo_i_compute **out);
void svo_i_compute_destroy(svo_i_compute **compute);
/* Writes to reason why this context cannot build a tree with these needs (svo_need bits), or "" if it can. no_int64: as
   if the context had no 64-bit integers. */
void svo_i_compute_reason(const svo_gl_context *context, bool no_int64, uint32_t need, char *reason,
                          size_t reason_bytes);

#endif
