/* SPDX-License-Identifier: MIT */
/*
 * The insides of svo_gl_context: an OpenGL context, how it is made current, and its function table.
 *
 * context.c holds what all kinds have in common; what differs between EGL, OSMesa and the caller's own is behind
 * platform.h.
 */
#ifndef SVO_GLINTEROP_CONTEXT_CONTEXT_H
#define SVO_GLINTEROP_CONTEXT_CONTEXT_H

#include "context/egl.h"
#include "context/functions.h"
#include "context/opencl.h"
#include "context/osmesa.h"
#include "context/state.h"
#include "svocl/gl.h"

/* How deep make_current may nest on one context. */
#define SVO_I_GL_NESTING_LIMIT 16

typedef struct svo_i_gl_binding {
    bool taken; /* false: the context was current already, so that nothing has to be restored */
    svo_i_egl_binding egl;
    svo_i_osmesa_binding osmesa;
} svo_i_gl_binding;

struct svo_gl_context {
    svo_gl_context_kind kind;
    uint32_t device_index;
    const svo_i_gl_platform *platform;
    void *native; /* the platform's own context */
    svo_i_gl_functions functions;
    const svo_i_opencl *opencl; /* the calls that sharing with OpenCL depends on */
    /* What was current before each make_current that has not been released yet, innermost last. */
    svo_i_gl_binding previous[SVO_I_GL_NESTING_LIMIT];
    uint32_t nesting;
    svo_i_gl_state callers_state; /* SVO_GL_WRAPPED: as it was before the outermost make_current */
};

/*
 * Makes the context current on this thread and remembers what was current before; cheap when it already is. Each
 * successful call is undone by one svo_i_gl_context_release_current on the same thread, in the opposite order. A
 * caller's own context must be current already; its state is saved, and restored by the outermost release.
 *
 * Returns SVO_NO_GL with the step that failed (the context is current on another thread, for example); what was current
 * before then still is.
 */
svo_status svo_i_gl_context_make_current(svo_gl_context *context, svo_message *message);
/* Makes current again what was current before the matching svo_i_gl_context_make_current. */
void svo_i_gl_context_release_current(svo_gl_context *context);

/* A software renderer in the place of a GPU that was asked for is SVO_NO_GL. */
svo_status svo_i_gl_context_check_promise(const svo_gl_context *context, svo_message *message);

/* The context's function table; lives as long as the context. Calls through it need the context current. */
const svo_i_gl_functions *svo_i_gl_context_functions(const svo_gl_context *context);

#endif
