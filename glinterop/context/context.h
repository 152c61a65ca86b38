/* SPDX-License-Identifier: MIT */
/*
 * The insides of svo_gl_context: an OpenGL context, how it is made current, and its function table. platform.h hides
 * what differs between EGL, OSMesa and wrapped contexts.
 *
 * The files of this room:
 *
 *   context    contexts of all kinds: svocl's and the caller's
 *   platform   what kinds of contexts do differently
 *   egl        contexts by EGL
 *   osmesa     contexts by OSMesa
 *   library    libraries that are loaded at run time
 *   functions  OpenGL's functions, and shaders
 *   state      the state that calls change, saved and restored
 */
#ifndef SVO_GLINTEROP_CONTEXT_CONTEXT_H
#define SVO_GLINTEROP_CONTEXT_CONTEXT_H

#include "context/egl.h"
#include "context/functions.h"
#include "context/osmesa.h"
#include "context/platform.h"
#include "context/state.h"
#include "svocl/gl.h"

/* The OpenCL calls by which cl_khr_gl_sharing is found: a table per OpenGL context, so that a test can replace them. */
typedef struct svo_i_opencl {
    cl_int(CL_API_CALL *GetDeviceInfo)(cl_device_id device, cl_device_info what, size_t bytes, void *value,
                                       size_t *value_bytes);
    cl_int(CL_API_CALL *GetContextInfo)(cl_context context, cl_context_info what, size_t bytes, void *value,
                                        size_t *value_bytes);
    cl_context(CL_API_CALL *CreateContext)(const cl_context_properties *properties, cl_uint device_count,
                                           const cl_device_id *devices,
                                           void(CL_CALLBACK *notify)(const char *, const void *, size_t, void *),
                                           void *user, cl_int *error);
    void *(CL_API_CALL *GetExtensionFunctionAddressForPlatform)(cl_platform_id platform, const char *name);
} svo_i_opencl;
extern const svo_i_opencl svo_i_opencl_installed;

/* The deepest nesting of svo_i_gl_context_make_current on one context. */
#define SVO_I_GL_NESTING_LIMIT 16

typedef struct svo_i_gl_binding {
    bool taken; /* false: the context was already current, so there is nothing to restore */
    svo_i_egl_binding egl;
    svo_i_osmesa_binding osmesa;
} svo_i_gl_binding;

struct svo_gl_context {
    svo_gl_context_kind kind;
    uint32_t device_index;
    const svo_i_gl_platform *platform;
    void *native; /* the platform's own context */
    svo_i_gl_functions functions;
    const svo_i_opencl *opencl; /* the OpenCL calls that interop uses */
    /* What was current before each make_current that is not yet released, innermost last. */
    svo_i_gl_binding previous[SVO_I_GL_NESTING_LIMIT];
    uint32_t nesting;
    svo_i_gl_state callers_state; /* SVO_GL_WRAPPED: saved by the outermost make_current */
};

/* An off-screen context of a kind below SVO_GL_CONTEXT_KINDS. device_index: 0 but for SVO_GL_EGL_DEVICE. */
svo_status svo_i_gl_context_open(svo_gl_context_kind kind, uint32_t device_index, const svo_i_memory *memory,
                                 svo_gl_context **out, svo_message *message);
/* The caller's context, which is current. */
svo_status svo_i_gl_context_wrap(svo_gl_get_proc_address get_proc_address, void *user, const svo_i_memory *memory,
                                 svo_gl_context **out, svo_message *message);

/*
 * Makes the context current on this thread and remembers what was current before. Cheap when it is already current.
 * Each successful call is undone by one svo_i_gl_context_release_current on the same thread, in reverse order. A
 * wrapped context must already be current; the outermost call saves its state and the outermost release restores it.
 *
 * Returns SVO_NO_GL with the step that failed, for example because the context is current on another thread. A failure
 * changes nothing.
 */
svo_status svo_i_gl_context_make_current(svo_gl_context *context, svo_message *message);
/* The same for a function that deletes objects and returns no status. It tries twice: what is not deleted now stays as
   long as the context. */
bool svo_i_gl_context_make_current_to_delete(svo_gl_context *context);
/* Restores what was current before the matching svo_i_gl_context_make_current. */
void svo_i_gl_context_release_current(svo_gl_context *context);

/* Returns SVO_NO_GL when a GPU was requested and a software renderer answers. */
svo_status svo_i_gl_context_check_promise(const svo_gl_context *context, svo_message *message);

/* The context's function table, valid as long as the context. Calls through it need the context current. */
const svo_i_gl_functions *svo_i_gl_context_functions(const svo_gl_context *context);

#endif
