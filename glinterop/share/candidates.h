/* SPDX-License-Identifier: MIT */
/*
 * The order in which contexts are tried for an OpenCL device, and when a better one can no longer come. Knows facts
 * alone, no OpenGL.
 */
#ifndef SVO_GLINTEROP_SHARE_CANDIDATES_H
#define SVO_GLINTEROP_SHARE_CANDIDATES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "context/egl.h"
#include "svocl/gl.h"

/* Where a context may come from. */
typedef struct svo_i_candidate {
    svo_gl_context_kind kind;
    uint32_t device_index; /* of SVO_GL_EGL_DEVICE */
    bool is_software; /* known without a context: a CPU draws */
} svo_i_candidate;

/* How well a context suits an OpenCL device; more is better. */
typedef enum svo_i_fit {
    SVO_I_FIT_NONE = 0, /* there is no context */
    SVO_I_FIT_SOFTWARE, /* a CPU draws */
    SVO_I_FIT_HARDWARE, /* a GPU draws, perhaps another one */
    SVO_I_FIT_NAMED, /* a GPU of the device's name */
    SVO_I_FIT_SHARING /* the GPU that clGetGLContextInfoKHR says is the device */
} svo_i_fit;

#define SVO_I_CANDIDATES_MAX (SVO_I_EGL_DEVICES_MAX + 2u)

/*
 * Lists the candidates in the order to try them. GPUs that EGL lists come first, then Mesa's surfaceless platform,
 * which draws on one of them or on the CPU, and what draws on the CPU last.
 *
 * software: for each EGL device, whether it is known to be software. Returns how many candidates there are.
 */
size_t svo_i_candidates_list(const bool *software, uint32_t egl_device_count, svo_i_candidate *out);

/*
 * Tries candidates in order, until none of the rest can be better. most: the best that a GPU can be. fit: makes a
 * context of a candidate and returns how well it suits. Returns the first of the best, or count where none has a
 * context.
 */
size_t svo_i_candidates_choose(const svo_i_candidate *candidates, size_t count, svo_i_fit most,
                               svo_i_fit (*fit)(void *user, size_t index), void *user);

#endif
