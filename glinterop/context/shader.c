/* SPDX-License-Identifier: MIT */
/* Compiles and links shaders. A failure carries the driver's log. */
#include "context/shader.h"

#include <stdio.h>
#include <string.h>

#define LOG_BYTES 4096

/* SVO_OK, or the first OpenGL error with what was being made. */
static svo_status check(const svo_i_shader_maker *maker, const char *step, svo_message *message)
{
    char text[128];
    (void)snprintf(text, sizeof text, "%s %s", step, maker->name);
    return svo_i_gl_check(maker->gl, maker->function, text, message);
}

/* Puts the first line of a shader's or a program's log into the message and passes all of it to the log callback. */
static svo_status fail_log(const svo_i_shader_maker *maker, const char *step, PFNGLGETSHADERINFOLOGPROC get_log,
                           GLuint made)
{
    char log[LOG_BYTES] = "";
    get_log(made, sizeof log, NULL, log);
    svo_i_device_log(maker->device, SVO_LOG_ERROR, log);
    /* Out of memory is no mistake in the text, and without a log OpenGL's error says the most. */
    svo_message error = {""};
    const svo_status status = check(maker, step, &error);
    if (status == SVO_OUT_OF_DEVICE_MEMORY || (status != SVO_OK && log[0] == '\0')) {
        return svo_i_device_fail(maker->device,
                                 status == SVO_OUT_OF_DEVICE_MEMORY ? SVO_OUT_OF_DEVICE_MEMORY : SVO_COMPILE_FAILED,
                                 "%.1000s", error.text);
    }
    return svo_i_device_fail(maker->device, SVO_COMPILE_FAILED, "%s: %s %s on %s: %.*s", maker->function, step,
                             maker->name, maker->gl->renderer, (int)strcspn(log, "\n"), log);
}

svo_status svo_i_shader_compile(const svo_i_shader_maker *maker, GLenum stage, const char *const *texts,
                                GLsizei text_count, GLuint *out)
{
    const svo_i_gl_functions *gl = maker->gl;
    const GLuint shader = gl->CreateShader(stage);
    if (shader == 0) {
        return fail_log(maker, "creating a shader for", gl->GetShaderInfoLog, 0);
    }
    gl->ShaderSource(shader, text_count, texts, NULL);
    gl->CompileShader(shader);
    GLint compiled = GL_FALSE;
    gl->GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled != GL_TRUE) {
        const svo_status status = fail_log(maker, "compiling", gl->GetShaderInfoLog, shader);
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
        return fail_log(maker, "creating a program for", gl->GetProgramInfoLog, 0);
    }
    for (unsigned i = 0; i < shader_count; ++i) {
        gl->AttachShader(program, shaders[i]);
    }
    gl->LinkProgram(program);
    GLint linked = GL_FALSE;
    gl->GetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked != GL_TRUE) {
        const svo_status status = fail_log(maker, "linking", gl->GetProgramInfoLog, program);
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
