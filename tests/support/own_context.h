/* SPDX-License-Identifier: MIT */
/* An application's OpenGL context, created by EGL calls without svocl. */
#ifndef SVOCL_TESTS_OWN_CONTEXT_H
#define SVOCL_TESTS_OWN_CONTEXT_H

#include <stdbool.h>

#include "svocl/gl.h"

typedef struct own_context {
    void *display, *context;
} own_context;

/* Creates an off-screen context of the core or the compatibility profile and makes it current. Skips the test where
   that is impossible. */
void own_context_make_or_skip(bool compatibility, own_context *out);
/* Makes the context current, or no context. */
void own_context_bind(const own_context *own, bool current);
void own_context_destroy(own_context *own);

/* The loader for SVO_GL_WRAPPED. user: not used. */
svo_gl_function own_context_function(void *user, const char *name);

#endif
