/* SPDX-License-Identifier: MIT */
/* What EGL, OSMesa and wrapped contexts do differently: load the library, create the context, make it current. */
#ifndef SVO_GLINTEROP_CONTEXT_PLATFORM_H
#define SVO_GLINTEROP_CONTEXT_PLATFORM_H

#include <stdbool.h>
#include <stdint.h>

#include "context/library.h"
#include "core/memory.h"
#include "svocl/gl.h"

/* The names of a context in the system that created it, for the properties of an OpenCL context. */
typedef enum svo_i_gl_system { SVO_I_GL_SYSTEM_OTHER = 0, SVO_I_GL_SYSTEM_EGL, SVO_I_GL_SYSTEM_GLX } svo_i_gl_system;
typedef struct svo_i_gl_handles {
    svo_i_gl_system system;
    void *context, *display; /* EGLContext and EGLDisplay, GLXContext and Display; NULL otherwise */
} svo_i_gl_handles;

typedef struct svo_i_gl_platform {
    /* Loads the library and creates a context. Does not change what is current. */
    svo_status (*create)(svo_gl_context_kind kind, uint32_t device_index, const svo_i_memory *memory, void **native,
                         svo_message *message);
    void (*destroy)(void *native);
    bool (*is_current)(void *native);
    /* Expects that no context is current: the bindings of EGL and OSMesa have been taken. */
    svo_status (*make_current)(void *native, svo_message *message);
    svo_i_get_proc_address get_proc_address; /* user: native */
    svo_i_gl_handles (*handles)(void *native);
    bool (*promises_gpu)(void *native); /* whether the context should run on a GPU; NULL: never */
} svo_i_gl_platform;

#endif
