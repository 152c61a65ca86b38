/* SPDX-License-Identifier: MIT */
/* Storage blocks of the builder by compute shaders. All expect the context current. */
#ifndef SVO_GLINTEROP_COMPUTE_BUFFER_H
#define SVO_GLINTEROP_COMPUTE_BUFFER_H

#include "compute/compute.h"
#include "stages/build_state.h"

/* SVO_OK, or the first OpenGL error since the last look, with step in the message. */
svo_status svo_i_compute_check(svo_i_compute *compute, const char *step);

/* A storage block of bytes, undefined or all zero. SVO_UNSUPPORTED naming it where it is above the context's limit,
   SVO_OUT_OF_DEVICE_MEMORY where OpenGL has no memory left. */
svo_status svo_i_compute_alloc(svo_i_compute *compute, const char *name, uint64_t bytes, GLuint *out);
svo_status svo_i_compute_alloc_zero(svo_i_compute *compute, const char *name, uint64_t bytes, GLuint *out);
svo_status svo_i_compute_upload(svo_i_compute *compute, const char *name, const void *data, uint64_t bytes,
                                GLuint *out);
void svo_i_compute_fill_zero(const svo_i_compute *compute, GLuint buffer);
/* 0 is allowed. */
void svo_i_compute_free(const svo_i_compute *compute, GLuint *buffer);
/* Waits, and reads bytes from the start of the buffer. */
svo_status svo_i_compute_read(svo_i_compute *compute, GLuint buffer, void *to, size_t bytes);
/* Waits, and copies bytes from the start of the buffer into a new buffer of OpenCL, which the plan lists. */
svo_status svo_i_compute_to_cl(svo_i_compute *compute, svo_i_build *build, GLuint buffer, const char *name,
                               uint64_t offset, uint64_t bytes, cl_mem *out);

#endif
