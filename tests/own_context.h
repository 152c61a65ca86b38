/* SPDX-License-Identifier: MIT */
/* An integrator's OpenGL context: made with EGL's own calls, without svocl. */
#ifndef SVOCL_TESTS_OWN_CONTEXT_H
#define SVOCL_TESTS_OWN_CONTEXT_H

#include <stdbool.h>

#include "svocl/gl.h"

typedef struct own_context {
    void *display, *context;
} own_context;

/* Off-screen, of the core or the compatibility profile, current on this thread. Skips the test where there is none. */
void own_context_make_or_skip(bool compatibility, own_context *out);
/* Makes it current, or nothing. */
void own_context_bind(const own_context *own, bool current);
void own_context_destroy(own_context *own);

/* For svo_gl_context_wrap. user: not used. */
svo_gl_function own_context_function(void *user, const char *name);

#endif
