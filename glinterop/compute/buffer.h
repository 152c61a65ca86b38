/* SPDX-License-Identifier: MIT */
/* Storage blocks. All functions expect the context current. */
#ifndef SVO_GLINTEROP_COMPUTE_BUFFER_H
#define SVO_GLINTEROP_COMPUTE_BUFFER_H

#include "compute/compute.h"
#include "stages/build_state.h"

/* SVO_OK, or the first OpenGL error since the last check, with the step in the message. */
svo_status svo_i_compute_check(svo_i_compute *compute, const char *step);

/* Create a storage block: undefined, all zero, or filled from the host. SVO_UNSUPPORTED naming the block when it is
   above the context's limit, SVO_OUT_OF_DEVICE_MEMORY when OpenGL has no memory left. */
svo_status svo_i_compute_alloc(svo_i_compute *compute, const char *name, uint64_t bytes, GLuint *out);
svo_status svo_i_compute_alloc_zero(svo_i_compute *compute, const char *name, uint64_t bytes, GLuint *out);
svo_status svo_i_compute_upload(svo_i_compute *compute, const char *name, const void *data, uint64_t bytes,
                                GLuint *out);
void svo_i_compute_fill_zero(const svo_i_compute *compute, GLuint buffer);
/* *buffer: 0 allowed; set to 0. */
void svo_i_compute_free(const svo_i_compute *compute, GLuint *buffer);
/* Waits, then reads bytes from the start of the buffer. */
svo_status svo_i_compute_read(svo_i_compute *compute, GLuint buffer, void *to, size_t bytes);
/* Waits, then copies bytes from an offset of the buffer to a new OpenCL buffer, which the plan lists. */
svo_status svo_i_compute_to_cl(svo_i_compute *compute, svo_i_build *build, GLuint buffer, const char *name,
                               uint64_t offset, uint64_t bytes, cl_mem *out);

#endif
