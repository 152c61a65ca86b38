/* SPDX-License-Identifier: MIT */
/*
 * What EGL, OSMesa and callers do differently for a context: loading the library, making the context, binding it.
 *
 * A thread has one current context, but EGL and OSMesa know nothing of each other: binding one leaves the other
 * believing that its context is still current. So a binding has both sides, and context.c takes and restores both.
 */
#ifndef SVO_GLINTEROP_CONTEXT_PLATFORM_H
#define SVO_GLINTEROP_CONTEXT_PLATFORM_H

#include <stdbool.h>
#include <stdint.h>

#include "context/library.h"
#include "svocl/gl.h"

/* What EGL has current on this thread. Handles are EGL's, without its types. */
typedef struct svo_i_egl_binding {
    bool loaded; /* libEGL was in the process, so that there is something to restore */
    unsigned api;
    void *display, *context, *draw_surface, *read_surface; /* context: NULL when none is current */
} svo_i_egl_binding;

/* What OSMesa has current on this thread, and the picture it draws to. */
typedef struct svo_i_osmesa_binding {
    void *context, *pixels; /* context: NULL when none is current */
    int width, height;
    unsigned pixel_type;
} svo_i_osmesa_binding;

/* What a context is called by those who made it; OpenCL is told so when it is to share with it. */
typedef enum svo_i_gl_system { SVO_I_GL_SYSTEM_OTHER = 0, SVO_I_GL_SYSTEM_EGL, SVO_I_GL_SYSTEM_GLX } svo_i_gl_system;
typedef struct svo_i_gl_handles {
    svo_i_gl_system system;
    void *context, *display; /* EGLContext and EGLDisplay, GLXContext and Display; NULL otherwise */
} svo_i_gl_handles;

typedef struct svo_i_gl_platform {
    /* Loads the library and makes a context. Does not change what is current. */
    svo_status (*create)(svo_gl_context_kind kind, uint32_t device_index, void **native, svo_message *message);
    void (*destroy)(void *native);
    bool (*is_current)(void *native);
    /* Expects nothing to be current: both sides of the binding have been taken. */
    svo_status (*make_current)(void *native, svo_message *message);
    svo_i_get_proc_address get_proc_address; /* user: native */
    svo_i_gl_handles (*handles)(void *native);
    bool (*promises_gpu)(void *native); /* whether a GPU was asked for; NULL: never */
} svo_i_gl_platform;

extern const svo_i_gl_platform svo_i_egl_platform; /* egl.c */
extern const svo_i_gl_platform svo_i_osmesa_platform; /* osmesa.c */
extern const svo_i_gl_platform svo_i_wrap_platform; /* wrap.c */

/* Taking reads what is current and unbinds it; restoring binds it again. Nothing happens when the library is not in the
   process. EGL is taken before OSMesa and restored after it: Mesa's drivers share one "current context" below both, and
   OSMesa would take EGL's for its own. */
void svo_i_egl_binding_take(svo_i_egl_binding *binding);
void svo_i_egl_binding_restore(const svo_i_egl_binding *binding);
void svo_i_osmesa_binding_take(svo_i_osmesa_binding *binding);
void svo_i_osmesa_binding_restore(const svo_i_osmesa_binding *binding);

#endif
