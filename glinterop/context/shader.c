/* SPDX-License-Identifier: MIT */
/* Compiles and links shaders. A failure carries the driver's log. */
#include "context/shader.h"

#include <string.h>

#define LOG_BYTES 4096

/* Puts the first line of a log into the message and passes all of it to the log callback. */
static svo_status fail_log(const svo_i_shader_maker *maker, const char *step, const char *log)
{
    svo_i_device_log(maker->device, SVO_LOG_ERROR, log);
    return svo_i_device_fail(maker->device, SVO_COMPILE_FAILED, "%s: %s %s on %s: %.*s", maker->function, step,
                             maker->name, maker->gl->renderer, (int)strcspn(log, "\n"), log);
}

svo_status svo_i_shader_compile(const svo_i_shader_maker *maker, GLenum stage, const char *const *texts,
                                GLsizei text_count, GLuint *out)
{
    const svo_i_gl_functions *gl = maker->gl;
    const GLuint shader = gl->CreateShader(stage);
    gl->ShaderSource(shader, text_count, texts, NULL);
    gl->CompileShader(shader);
    GLint compiled = GL_FALSE;
    gl->GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled != GL_TRUE) {
        char log[LOG_BYTES] = "";
        gl->GetShaderInfoLog(shader, sizeof log, NULL, log);
        gl->DeleteShader(shader);
        return fail_log(maker, "compiling", log);
    }
    *out = shader;
    return SVO_OK;
}

svo_status svo_i_shader_link(const svo_i_shader_maker *maker, const GLuint *shaders, unsigned shader_count, GLuint *out)
{
    const svo_i_gl_functions *gl = maker->gl;
    const GLuint program = gl->CreateProgram();
    for (unsigned i = 0; i < shader_count; ++i) {
        gl->AttachShader(program, shaders[i]);
    }
    gl->LinkProgram(program);
    GLint linked = GL_FALSE;
    gl->GetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked != GL_TRUE) {
        char log[LOG_BYTES] = "";
        gl->GetProgramInfoLog(program, sizeof log, NULL, log);
        gl->DeleteProgram(program);
        return fail_log(maker, "linking", log);
    }
    *out = program;
    return SVO_OK;
}
