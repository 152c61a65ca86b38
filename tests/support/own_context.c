/* SPDX-License-Identifier: MIT */
/* Uses EGL on Mesa's surfaceless platform. */
#include "own_context.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#define EGL_NO_X11
#include <EGL/egl.h>
#include <EGL/eglext.h>

void own_context_make_or_skip(bool compatibility, own_context *out)
{
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 4,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 3,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 compatibility ? EGL_CONTEXT_OPENGL_COMPATIBILITY_PROFILE_BIT
                                               : EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 EGL_NONE};
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_display =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)eglGetProcAddress("eglGetPlatformDisplayEXT");
    *out = (own_context){0};
    if (get_display != NULL) {
        out->display = get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL);
    }
    if (out->display == EGL_NO_DISPLAY || !eglInitialize(out->display, NULL, NULL) || !eglBindAPI(EGL_OPENGL_API)) {
        print_message("skipped: no surfaceless EGL display\n");
        skip();
    }
    out->context = eglCreateContext(out->display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
    if (out->context == EGL_NO_CONTEXT) {
        print_message("skipped: no OpenGL 4.3 %s context\n", compatibility ? "compatibility" : "core");
        skip();
    }
    own_context_bind(out, true);
}

void own_context_bind(const own_context *own, bool current)
{
    assert_true(eglMakeCurrent(own->display, EGL_NO_SURFACE, EGL_NO_SURFACE, current ? own->context : EGL_NO_CONTEXT));
}

void own_context_destroy(own_context *own)
{
    own_context_bind(own, false);
    assert_true(eglDestroyContext(own->display, own->context));
    *own = (own_context){0};
}

svo_gl_function own_context_function(void *user, const char *name)
{
    (void)user;
    return (svo_gl_function)eglGetProcAddress(name);
}
