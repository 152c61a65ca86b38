/* SPDX-License-Identifier: MIT */
/*
 * Contexts that the caller created. svocl neither makes them current nor destroys them. It records which context is
 * current when it is wrapped, to check later that it still is, and to name it to OpenCL.
 */
#include "context/wrap.h"

#include "core/message.h"

/* Has the functions of GLX where there is no SVO_I_GLX_LIBRARY. */
#define OLDER_GLX_LIBRARY "libGL.so.1"

static void *ask_glx(const char *function_name)
{
    void *answer = svo_i_library_ask(SVO_I_GLX_LIBRARY, function_name);
    return answer != NULL ? answer : svo_i_library_ask(OLDER_GLX_LIBRARY, function_name);
}

/* The context that is current on this thread according to EGL, GLX and OSMesa. */
static svo_i_gl_handles find_current(void)
{
    void *context = svo_i_library_ask(SVO_I_EGL_LIBRARY, "eglGetCurrentContext");
    if (context != NULL) {
        return (svo_i_gl_handles){SVO_I_GL_SYSTEM_EGL, context,
                                  svo_i_library_ask(SVO_I_EGL_LIBRARY, "eglGetCurrentDisplay")};
    }
    context = ask_glx("glXGetCurrentContext");
    if (context != NULL) {
        return (svo_i_gl_handles){SVO_I_GL_SYSTEM_GLX, context, ask_glx("glXGetCurrentDisplay")};
    }
    return (svo_i_gl_handles){SVO_I_GL_SYSTEM_OTHER, svo_i_library_ask(SVO_I_OSMESA_LIBRARY, "OSMesaGetCurrentContext"),
                              NULL};
}

static svo_status wrap_create(svo_gl_context_kind kind, uint32_t device_index, const svo_i_memory *memory, void **out,
                              svo_message *message)
{
    (void)kind;
    (void)device_index;
    svo_i_gl_handles *native = svo_i_alloc(memory, sizeof *native);
    if (native == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "svo_gl_context_wrap: no %zu bytes", sizeof *native);
    }
    *native = find_current();
    *out = native;
    return SVO_OK;
}

static void wrap_destroy(void *native)
{
    svo_i_free(native);
}

/* A context that no library knew counts as current whenever no library has a current context. */
static bool wrap_is_current(void *pointer)
{
    const svo_i_gl_handles *native = pointer;
    const svo_i_gl_handles current = find_current();
    return current.system == native->system && current.context == native->context;
}

static svo_status wrap_make_current(void *native, svo_message *message)
{
    (void)native;
    return svo_i_fail(message, SVO_NO_GL, "svo_gl_context_wrap: the caller's context is not current on this thread");
}

static svo_i_function wrap_get_proc_address(void *native, const char *name)
{
    (void)native;
    (void)name;
    return NULL; /* the caller's own function is used, and only while the context is wrapped */
}

static svo_i_gl_handles wrap_handles(void *pointer)
{
    const svo_i_gl_handles *native = pointer;
    return *native;
}

const svo_i_gl_platform svo_i_wrap_platform = {
    .create = wrap_create,
    .destroy = wrap_destroy,
    .is_current = wrap_is_current,
    .make_current = wrap_make_current,
    .get_proc_address = wrap_get_proc_address,
    .handles = wrap_handles,
};
