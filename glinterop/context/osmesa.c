/* SPDX-License-Identifier: MIT */
/*
 * Off-screen contexts by OSMesa, Mesa's software renderer without a window system or EGL.
 *
 * OSMesa requires a color buffer, so each context carries a tiny one. Nothing draws to it: the front end uses
 * framebuffers of its own.
 */
#include "context/osmesa.h"

#include <GL/osmesa.h>

#include "core/message.h"

enum { PICTURE_SIDE = 4, PICTURE_BYTES = PICTURE_SIDE * PICTURE_SIDE * 4 };

/* X(member, type): the functions of libOSMesa that svocl uses, looked up as "OSMesa" + member. */
#define OSMESA_FUNCTION_LIST(X)                        \
    X(CreateContextAttribs, create_context_function)   \
    X(DestroyContext, destroy_context_function)        \
    X(MakeCurrent, make_current_function)              \
    X(GetCurrentContext, get_current_context_function) \
    X(GetColorBuffer, get_color_buffer_function)       \
    X(GetIntegerv, get_integer_function)               \
    X(GetProcAddress, get_proc_address_function)

typedef OSMesaContext (*create_context_function)(const int *attributes, OSMesaContext shared);
typedef void (*destroy_context_function)(OSMesaContext context);
typedef GLboolean (*make_current_function)(OSMesaContext context, void *pixels, GLenum type, GLsizei width,
                                           GLsizei height);
typedef OSMesaContext (*get_current_context_function)(void);
typedef GLboolean (*get_color_buffer_function)(OSMesaContext context, GLint *width, GLint *height, GLint *format,
                                               void **pixels);
typedef void (*get_integer_function)(GLint name, GLint *value);
typedef svo_i_function (*get_proc_address_function)(const char *name);

typedef struct osmesa_library {
    void *library;
#define OSMESA_MEMBER(member, type) type member;
    OSMESA_FUNCTION_LIST(OSMESA_MEMBER)
#undef OSMESA_MEMBER
} osmesa_library;

typedef struct osmesa_context {
    osmesa_library osmesa;
    OSMesaContext context;
    unsigned char picture[PICTURE_BYTES];
} osmesa_context;

/* Fills the table from an open library. The message names the first missing function. */
static svo_status osmesa_library_fill(osmesa_library *osmesa, svo_message *message)
{
    const char *missing = NULL;
#define OSMESA_FILL(member, type)                                                     \
    osmesa->member = (type)svo_i_library_function(osmesa->library, "OSMesa" #member); \
    if (osmesa->member == NULL && missing == NULL) {                                  \
        missing = "OSMesa" #member;                                                   \
    }
    OSMESA_FUNCTION_LIST(OSMESA_FILL)
#undef OSMESA_FILL
    if (missing != NULL) {
        return svo_i_fail(message, SVO_NO_GL, "svo_gl_context_create: " SVO_I_OSMESA_LIBRARY " has no function %s",
                          missing);
    }
    return SVO_OK;
}

/* The newest core profile available, at least 4.3. */
static svo_status create_core_context(osmesa_context *native, svo_message *message)
{
    for (int minor = 6; minor >= 3; --minor) {
        const int attributes[] = {OSMESA_FORMAT,
                                  OSMESA_RGBA,
                                  OSMESA_PROFILE,
                                  OSMESA_CORE_PROFILE,
                                  OSMESA_CONTEXT_MAJOR_VERSION,
                                  4,
                                  OSMESA_CONTEXT_MINOR_VERSION,
                                  minor,
                                  0};
        native->context = native->osmesa.CreateContextAttribs(attributes, NULL);
        if (native->context != NULL) {
            return SVO_OK;
        }
    }
    return svo_i_fail(message, SVO_NO_GL, "svo_gl_context_create: OSMesaCreateContextAttribs (OpenGL 4.3 core) failed");
}

static void osmesa_destroy(void *pointer)
{
    osmesa_context *native = pointer;
    if (native->context != NULL) {
        native->osmesa.DestroyContext(native->context);
    }
    svo_i_library_close(native->osmesa.library);
    svo_i_free(native);
}

static svo_status osmesa_create(svo_gl_context_kind kind, uint32_t device_index, const svo_i_memory *memory, void **out,
                                svo_message *message)
{
    (void)kind;
    (void)device_index;
    osmesa_context *native = svo_i_alloc_zeroed(memory, 1, sizeof *native);
    if (native == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "svo_gl_context_create: no %zu bytes", sizeof *native);
    }
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(svo_i_library_open(SVO_I_OSMESA_LIBRARY, &native->osmesa.library, message));
    SVO_I_TRY_CLEANUP(osmesa_library_fill(&native->osmesa, message));
    SVO_I_TRY_CLEANUP(create_core_context(native, message));
    *out = native;
    return SVO_OK;
cleanup:
    osmesa_destroy(native);
    return status;
}

static bool osmesa_is_current(void *pointer)
{
    const osmesa_context *native = pointer;
    return native->osmesa.GetCurrentContext() == native->context;
}

/* GLX and OSMesa share Mesa's current context unknown to each other, and GLX's cannot be restored from here. */
static bool glx_is_current(void)
{
    return svo_i_library_ask(SVO_I_GLX_LIBRARY, "glXGetCurrentContext") != NULL;
}

static svo_status osmesa_make_current(void *pointer, svo_message *message)
{
    osmesa_context *native = pointer;
    if (glx_is_current()) {
        return svo_i_fail(message, SVO_NO_GL,
                          "svo_gl_context_create: a GLX context is current on this thread; OSMesa would break it");
    }
    if (!native->osmesa.MakeCurrent(native->context, native->picture, GL_UNSIGNED_BYTE, PICTURE_SIDE, PICTURE_SIDE)) {
        return svo_i_fail(message, SVO_NO_GL, "svo_gl_context_create: OSMesaMakeCurrent failed");
    }
    return SVO_OK;
}

static svo_i_function osmesa_get_proc_address(void *pointer, const char *name)
{
    const osmesa_context *native = pointer;
    return native->osmesa.GetProcAddress(name);
}

/* OpenCL has no context property for OSMesa. */
static svo_i_gl_handles osmesa_handles(void *pointer)
{
    (void)pointer;
    return (svo_i_gl_handles){.system = SVO_I_GL_SYSTEM_OTHER};
}

const svo_i_gl_platform svo_i_osmesa_platform = {
    .create = osmesa_create,
    .destroy = osmesa_destroy,
    .is_current = osmesa_is_current,
    .make_current = osmesa_make_current,
    .get_proc_address = osmesa_get_proc_address,
    .handles = osmesa_handles,
};

void svo_i_osmesa_binding_take(svo_i_osmesa_binding *binding)
{
    *binding = (svo_i_osmesa_binding){0};
    osmesa_library osmesa = {.library = svo_i_library_if_loaded(SVO_I_OSMESA_LIBRARY)};
    if (osmesa.library != NULL && osmesa_library_fill(&osmesa, NULL) == SVO_OK && !glx_is_current()) {
        OSMesaContext current = osmesa.GetCurrentContext();
        GLint format = 0, type = 0;
        if (current != NULL &&
            osmesa.GetColorBuffer(current, &binding->width, &binding->height, &format, &binding->pixels)) {
            osmesa.GetIntegerv(OSMESA_TYPE, &type);
            binding->pixel_type = (unsigned)type;
            binding->context = current;
            (void)osmesa.MakeCurrent(NULL, NULL, 0, 0, 0);
        }
    }
    svo_i_library_close(osmesa.library);
}

void svo_i_osmesa_binding_restore(const svo_i_osmesa_binding *binding)
{
    if (binding->context == NULL) {
        return;
    }
    osmesa_library osmesa = {.library = svo_i_library_if_loaded(SVO_I_OSMESA_LIBRARY)};
    if (osmesa.library != NULL && osmesa_library_fill(&osmesa, NULL) == SVO_OK) {
        (void)osmesa.MakeCurrent(binding->context, binding->pixels, binding->pixel_type, binding->width,
                                 binding->height);
    }
    svo_i_library_close(osmesa.library);
}
