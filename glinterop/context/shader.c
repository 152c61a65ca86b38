/* SPDX-License-Identifier: MIT */
/* Compiles and links shaders. A failure carries the driver's log. */
#include "context/shader.h"

#include <stdio.h>
#include <string.h>

/* SVO_OK, or the first OpenGL error with what was being made. */
static svo_status check(const svo_i_shader_maker *maker, const char *step, svo_message *message)
{
    char text[128];
    (void)snprintf(text, sizeof text, "%s %s", step, maker->name);
    return svo_i_gl_check(maker->gl, maker->function, text, message);
}

/* What has a log: a shader or a program, with the two functions that read it. 0: it could not be created. */
typedef struct logged {
    GLuint name;
    PFNGLGETSHADERIVPROC get;
    PFNGLGETSHADERINFOLOGPROC get_log;
} logged;

static logged of_shader(const svo_i_gl_functions *gl, GLuint shader)
{
    return (logged){shader, gl->GetShaderiv, gl->GetShaderInfoLog};
}

static logged of_program(const svo_i_gl_functions *gl, GLuint program)
{
    return (logged){program, gl->GetProgramiv, gl->GetProgramInfoLog};
}

/* The whole log; NULL where there is none, or no memory for it. */
static char *read_log(const svo_i_shader_maker *maker, logged made)
{
    GLint bytes = 0;
    if (made.name != 0) {
        made.get(made.name, GL_INFO_LOG_LENGTH, &bytes);
    }
    char *log = bytes > 0 ? svo_i_alloc_zeroed(&maker->device->memory, (size_t)bytes + 1, 1) : NULL;
    if (log != NULL) {
        made.get_log(made.name, bytes, NULL, log);
    }
    return log;
}

/* Puts the first line of a shader's or a program's log into the message and passes all of it to the log callback. */
static svo_status fail_log(const svo_i_shader_maker *maker, const char *step, logged made)
{
    char *text = read_log(maker, made);
    const char *log = text != NULL ? text : "";
    svo_i_device_log(maker->device, SVO_LOG_ERROR, log);
    /* Out of memory is no mistake in the text, and without a log OpenGL's error says the most. */
    svo_message error = {""};
    const svo_status status = check(maker, step, &error);
    if (status == SVO_OUT_OF_DEVICE_MEMORY || (status != SVO_OK && log[0] == '\0')) {
        svo_i_free(text);
        return svo_i_device_fail(maker->device,
                                 status == SVO_OUT_OF_DEVICE_MEMORY ? SVO_OUT_OF_DEVICE_MEMORY : SVO_COMPILE_FAILED,
                                 "%s", error.text);
    }
    (void)svo_i_device_fail(maker->device, SVO_COMPILE_FAILED, "%s: %s %s on %s: %.*s", maker->function, step,
                            maker->name, maker->gl->renderer, (int)strcspn(log, "\n"), log);
    svo_i_free(text);
    return SVO_COMPILE_FAILED;
}

svo_status svo_i_shader_compile(const svo_i_shader_maker *maker, GLenum stage, const char *const *texts,
                                GLsizei text_count, GLuint *out)
{
    const svo_i_gl_functions *gl = maker->gl;
    const GLuint shader = gl->CreateShader(stage);
    if (shader == 0) {
        return fail_log(maker, "creating a shader for", of_shader(gl, 0));
    }
    gl->ShaderSource(shader, text_count, texts, NULL);
    gl->CompileShader(shader);
    GLint compiled = GL_FALSE;
    gl->GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled != GL_TRUE) {
        const svo_status status = fail_log(maker, "compiling", of_shader(gl, shader));
        gl->DeleteShader(shader);
        return status;
    }
    const svo_status status = check(maker, "compiling", &maker->device->message);
    if (status != SVO_OK) {
        gl->DeleteShader(shader);
        return status;
    }
    *out = shader;
    return SVO_OK;
}

svo_status svo_i_shader_link(const svo_i_shader_maker *maker, const GLuint *shaders, unsigned shader_count, GLuint *out)
{
    const svo_i_gl_functions *gl = maker->gl;
    const GLuint program = gl->CreateProgram();
    if (program == 0) {
        return fail_log(maker, "creating a program for", of_program(gl, 0));
    }
    for (unsigned i = 0; i < shader_count; ++i) {
        gl->AttachShader(program, shaders[i]);
    }
    gl->LinkProgram(program);
    GLint linked = GL_FALSE;
    gl->GetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked != GL_TRUE) {
        const svo_status status = fail_log(maker, "linking", of_program(gl, program));
        gl->DeleteProgram(program);
        return status;
    }
    const svo_status status = check(maker, "linking", &maker->device->message);
    if (status != SVO_OK) {
        gl->DeleteProgram(program);
        return status;
    }
    *out = program;
    return SVO_OK;
}
