/* SPDX-License-Identifier: MIT */
/* Compiles and links shaders, for rasterization (raster.c) and for the builder (compute/program.c). */
#ifndef SVO_GLINTEROP_CONTEXT_SHADER_H
#define SVO_GLINTEROP_CONTEXT_SHADER_H

#include "context/functions.h"
#include "core/device.h"

/* For whom a shader is compiled, and its names in messages. */
typedef struct svo_i_shader_maker {
    svo_device *device;
    const svo_i_gl_functions *gl; /* the current context's */
    const char *function; /* the public function that was called */
    const char *name; /* of the shader or program */
} svo_i_shader_maker;

/* Compiles the concatenated texts as a shader of that stage. The caller deletes it. SVO_COMPILE_FAILED with the first
   line of the driver's log; the whole log goes to the device's log callback. */
svo_status svo_i_shader_compile(const svo_i_shader_maker *maker, GLenum stage, const char *const *texts,
                                GLsizei text_count, GLuint *out);
/* Links the shaders, which the caller keeps, to a program. SVO_COMPILE_FAILED likewise. */
svo_status svo_i_shader_link(const svo_i_shader_maker *maker, const GLuint *shaders, unsigned shader_count,
                             GLuint *out);

#endif
