/* SPDX-License-Identifier: MIT */
/* Compiling and linking shaders, for those that rasterize (raster.c) and those that build (compute_program.c). */
#ifndef SVO_GLINTEROP_CONTEXT_SHADER_H
#define SVO_GLINTEROP_CONTEXT_SHADER_H

#include "context/functions.h"
#include "core/device.h"

/* Who compiles, and what the messages say of it. */
typedef struct svo_i_shader_maker {
    svo_device *device;
    const svo_i_gl_functions *gl; /* of the context that is current */
    const char *function; /* that was called */
    const char *name; /* of what is compiled or linked */
} svo_i_shader_maker;

/* The texts one after the other as a shader of that stage, to be deleted by the caller. SVO_COMPILE_FAILED with the
   first line of the driver's log; all of it goes to the device's log. */
svo_status svo_i_shader_compile(const svo_i_shader_maker *maker, GLenum stage, const char *const *texts,
                                GLsizei text_count, GLuint *out);
/* The shaders, which stay the caller's, as a program. SVO_COMPILE_FAILED in the same way. */
svo_status svo_i_shader_link(const svo_i_shader_maker *maker, const GLuint *shaders, unsigned shader_count,
                             GLuint *out);

#endif
