/* SPDX-License-Identifier: MIT */
/*
 * OpenGL contexts: what all kinds share, how a context is made current and released, contexts that the caller created.
 */
#define _POSIX_C_SOURCE 200809L
#include "context/context.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "context/egl.h"
#include "core/message.h"
#include "core/struct_size.h"

/* The calls of the installed OpenCL loader. */
const svo_i_opencl svo_i_opencl_installed = {
    .GetDeviceInfo = clGetDeviceInfo,
    .GetContextInfo = clGetContextInfo,
    .CreateContext = clCreateContext,
    .GetExtensionFunctionAddressForPlatform = clGetExtensionFunctionAddressForPlatform,
};

/* ---- contexts of the caller ---- */

/*
 * Contexts that the caller created. svocl neither makes them current nor destroys them. It records which context is
 * current when it is wrapped, to check later that it still is, and to name it to OpenCL.
 */

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
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "svo_gl_context_create: no %zu bytes", sizeof *native);
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
    return svo_i_fail(message, SVO_NO_GL, "svo_gl_context_create: the caller's context is not current on this thread");
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

/* is_current compares with the context that was current when create was called; make_current always fails. */
static const svo_i_gl_platform wrap_platform = {
    .create = wrap_create,
    .destroy = wrap_destroy,
    .is_current = wrap_is_current,
    .make_current = wrap_make_current,
    .get_proc_address = wrap_get_proc_address,
    .handles = wrap_handles,
};

/* ---- contexts ---- */

/* EGL and OSMesa know nothing of each other: each believes that its context stays current when the other binds one.
   Mesa's drivers share one current context below both, and OSMesa would take EGL's for its own, so EGL is unbound
   first. */
static void take_binding(svo_i_gl_binding *binding)
{
    binding->taken = true;
    svo_i_egl_binding_take(&binding->egl);
    svo_i_osmesa_binding_take(&binding->osmesa);
}

static void restore_binding(const svo_i_gl_binding *binding)
{
    svo_i_osmesa_binding_restore(&binding->osmesa);
    svo_i_egl_binding_restore(&binding->egl);
}

/* Unbinds the context and restores what was current before, where that was something else. */
static void release_binding(const svo_i_gl_binding *previous)
{
    if (previous->taken) {
        svo_i_gl_binding own;
        take_binding(&own);
        restore_binding(previous);
    }
}

/* A state that could not be read must not be restored. */
static svo_status save_callers_state(svo_gl_context *context, svo_message *message)
{
    svo_i_gl_clear_errors(&context->functions);
    svo_i_gl_state_save(&context->functions, &context->callers_state);
    return svo_i_gl_check_query(&context->functions, "svo_gl_context_create", "reading the caller's state", message);
}

svo_status svo_i_gl_context_make_current(svo_gl_context *context, svo_message *message)
{
    if (context->nesting == SVO_I_GL_NESTING_LIMIT) {
        return svo_i_fail(message, SVO_INTERNAL, "svo_i_gl_context_make_current: nested deeper than %d",
                          SVO_I_GL_NESTING_LIMIT);
    }
    svo_i_gl_binding *previous = &context->previous[context->nesting];
    *previous = (svo_i_gl_binding){0};
    if (!context->platform->is_current(context->native)) {
        take_binding(previous);
        const svo_status status = context->platform->make_current(context->native, message);
        if (status != SVO_OK) {
            restore_binding(previous);
            return status;
        }
    }
    if (context->kind == SVO_GL_WRAPPED && context->nesting == 0) {
        const svo_status status = save_callers_state(context, message);
        if (status != SVO_OK) {
            release_binding(previous);
            return status;
        }
    }
    ++context->nesting;
    return SVO_OK;
}

bool svo_i_gl_context_make_current_to_delete(svo_gl_context *context)
{
    svo_status status = svo_i_gl_context_make_current(context, NULL);
    if (status != SVO_OK) {
        status = svo_i_gl_context_make_current(context, NULL);
    }
    return status == SVO_OK;
}

void svo_i_gl_context_release_current(svo_gl_context *context)
{
    if (context->nesting == 0) {
        return;
    }
    --context->nesting;
    if (context->kind == SVO_GL_WRAPPED && context->nesting == 0) {
        svo_i_gl_state_restore(&context->functions, &context->callers_state);
    }
    release_binding(&context->previous[context->nesting]);
}

const svo_i_gl_functions *svo_i_gl_context_functions(const svo_gl_context *context)
{
    return &context->functions;
}

static svo_status load_functions(svo_gl_context *context, const svo_i_memory *memory, svo_message *message)
{
    SVO_I_TRY(svo_i_gl_context_make_current(context, message));
    const svo_status status =
        svo_i_gl_load(&context->functions, context->platform->get_proc_address, context->native, memory, message);
    svo_i_gl_context_release_current(context);
    return status;
}

svo_status svo_i_gl_context_check_promise(const svo_gl_context *context, svo_message *message)
{
    const bool promised = context->platform->promises_gpu != NULL && context->platform->promises_gpu(context->native);
    if (promised && svo_i_gl_is_software(&context->functions)) {
        return svo_i_fail(message, SVO_NO_GL, "svo_gl_context_create: EGL device %u is a GPU, but %s renders for it",
                          context->device_index, context->functions.renderer);
    }
    return SVO_OK;
}

svo_status svo_i_gl_context_open(svo_gl_context_kind kind, uint32_t device_index, const svo_i_memory *memory,
                                 svo_gl_context **out, svo_message *message)
{
    svo_gl_context *context = svo_i_alloc_zeroed(memory, 1, sizeof *context);
    if (context == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "svo_gl_context_create: no %zu bytes", sizeof *context);
    }
    svo_status status = SVO_OK;
    context->opencl = &svo_i_opencl_installed;
    context->kind = kind;
    context->device_index = device_index;
    context->platform = kind == SVO_GL_OSMESA ? &svo_i_osmesa_platform : &svo_i_egl_platform;
    SVO_I_TRY_CLEANUP(context->platform->create(kind, device_index, memory, &context->native, message));
    SVO_I_TRY_CLEANUP(load_functions(context, memory, message));
    SVO_I_TRY_CLEANUP(svo_i_gl_context_check_promise(context, message));
    *out = context;
    context = NULL;
cleanup:
    svo_gl_context_destroy(&context);
    return status;
}

svo_status svo_i_gl_context_wrap(svo_gl_get_proc_address get_proc_address, void *user, const svo_i_memory *memory,
                                 svo_gl_context **out, svo_message *message)
{
    svo_gl_context *context = svo_i_alloc_zeroed(memory, 1, sizeof *context);
    if (context == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "svo_gl_context_create: no %zu bytes", sizeof *context);
    }
    svo_status status = SVO_OK;
    context->opencl = &svo_i_opencl_installed;
    context->kind = SVO_GL_WRAPPED;
    context->platform = &wrap_platform;
    SVO_I_TRY_CLEANUP(context->platform->create(SVO_GL_WRAPPED, 0, memory, &context->native, message));
    SVO_I_TRY_CLEANUP(svo_i_gl_load(&context->functions, get_proc_address, user, memory, message));
    *out = context;
    context = NULL;
cleanup:
    svo_gl_context_destroy(&context);
    return status;
}

void svo_gl_context_destroy(svo_gl_context **context)
{
    if (context == NULL || *context == NULL) {
        return;
    }
    svo_gl_context *dying = *context;
    if (dying->native != NULL) {
        dying->platform->destroy(dying->native);
    }
    svo_i_gl_unload(&dying->functions);
    svo_i_free(dying);
    *context = NULL;
}

svo_status svo_gl_context_get_info(const svo_gl_context *context, svo_gl_context_info *info)
{
    const svo_gl_context_info found = {.kind = context->kind,
                                       .device_index = context->device_index,
                                       .vendor = context->functions.vendor,
                                       .renderer = context->functions.renderer,
                                       .version = context->functions.version_text,
                                       .is_software = svo_i_gl_is_software(&context->functions)};
    return svo_i_struct_write(NULL, "svo_gl_context_get_info", "info", &found, info,
                              SVO_I_STRUCT_SIZES(svo_gl_context_info, device_index));
}
