/* SPDX-License-Identifier: MIT */
/*
 * Libraries loaded at run time, their entry points, and extension lists: what contexts need before OpenGL is loaded.
 * Includes no OpenGL header, since <GL/osmesa.h> and <GL/glcorearb.h> exclude each other.
 */
#ifndef SVO_GLINTEROP_CONTEXT_LIBRARY_H
#define SVO_GLINTEROP_CONTEXT_LIBRARY_H

#include <stdbool.h>

#include "svocl/status.h"

/* Any entry point. Convert it to its real type before the call. */
typedef void (*svo_i_function)(void);

/* A context's loader. name includes the "gl". Returns NULL when there is no such function. */
typedef svo_i_function (*svo_i_get_proc_address)(void *user, const char *name);

/* The file names of the libraries that create contexts. */
#define SVO_I_EGL_LIBRARY    "libEGL.so.1"
#define SVO_I_OSMESA_LIBRARY "libOSMesa.so.8"
#define SVO_I_GLX_LIBRARY    "libGLX.so.0"

/*
 * Opens a shared library by its file name. Returns SVO_NO_GL with the loader's message. The library stays in the
 * process after svo_i_library_close, since drivers leave threads and thread-local destructors behind.
 */
svo_status svo_i_library_open(const char *file_name, void **library, svo_message *message);
/* The library if the process has loaded it, else NULL. Close it like an opened one. */
void *svo_i_library_if_loaded(const char *file_name);
void svo_i_library_close(void *library); /* NULL allowed */
/* NULL when the library has no such function. */
svo_i_function svo_i_library_function(void *library, const char *name);
/* The result of a function void *(void) of a library; NULL when the process has not loaded the library or the library
   has no such function. */
void *svo_i_library_ask(const char *file_name, const char *function_name);

/* Whether a space-separated list has the token as a whole word: "GL_NV_x_y" does not contain "GL_NV_x". list: NULL
   counts as empty. An empty token is in no list. */
bool svo_i_list_has_token(const char *list, const char *token);
/* Whether text contains part, in letters of either case. */
bool svo_i_text_contains(const char *text, const char *part);

#endif
