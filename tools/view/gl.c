/* SPDX-License-Identifier: MIT */
/* Functions of OpenGL, its errors, and programs of shaders. */
#include "view/gl.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

/* More errors than a context keeps: a context that is lost may report one forever. */
#define ERRORS_MAX 16

/* A function's name and where its pointer is in view_gl. */
typedef struct gl_function {
    const char *name;
    size_t offset;
} gl_function;

#define ROW(name, type) {"gl" #name, offsetof(view_gl, name)},
static const gl_function functions[] = {VIEW_GL_FUNCTIONS(ROW)};
#undef ROW

const char *view_gl_load(view_gl *gl, void *(*find)(const char *name))
{
    for (size_t i = 0; i < sizeof functions / sizeof functions[0]; ++i) {
        void *const found = find(functions[i].name);
        if (found == NULL) {
            return functions[i].name;
        }
        memcpy((char *)gl + functions[i].offset, &found, sizeof found);
    }
    return NULL;
}

static const char *name_of_error(GLenum error)
{
    switch (error) {
    case GL_INVALID_ENUM:
        return "GL_INVALID_ENUM";
    case GL_INVALID_VALUE:
        return "GL_INVALID_VALUE";
    case GL_INVALID_OPERATION:
        return "GL_INVALID_OPERATION";
    case GL_INVALID_FRAMEBUFFER_OPERATION:
        return "GL_INVALID_FRAMEBUFFER_OPERATION";
    case GL_OUT_OF_MEMORY:
        return "GL_OUT_OF_MEMORY";
    case GL_CONTEXT_LOST:
        return "GL_CONTEXT_LOST";
    default:
        return "an unknown error";
    }
}

bool view_gl_check(const view_gl *gl, const char *what, svo_message *why)
{
    const GLenum first = gl->GetError();
    for (int i = 0; i < ERRORS_MAX && gl->GetError() != GL_NO_ERROR; ++i) {
    }
    if (first != GL_NO_ERROR) {
        (void)snprintf(why->text, sizeof why->text, "OpenGL: %s while %s", name_of_error(first), what);
    }
    return first == GL_NO_ERROR;
}

static GLuint compile(const view_gl *gl, GLenum kind, const char *source, char *log, int log_bytes)
{
    GLint is_compiled = GL_FALSE;
    const GLuint shader = gl->CreateShader(kind);
    if (shader == 0) {
        (void)snprintf(log, (size_t)log_bytes, "glCreateShader failed");
        return 0;
    }
    gl->ShaderSource(shader, 1, &source, NULL);
    gl->CompileShader(shader);
    gl->GetShaderiv(shader, GL_COMPILE_STATUS, &is_compiled);
    if (is_compiled == GL_FALSE) {
        gl->GetShaderInfoLog(shader, log_bytes, NULL, log);
        gl->DeleteShader(shader);
        return 0;
    }
    return shader;
}

static GLuint link(const view_gl *gl, GLuint vertex, GLuint fragment, char *log, int log_bytes)
{
    GLint is_linked = GL_FALSE;
    const GLuint program = gl->CreateProgram();
    if (program == 0) {
        (void)snprintf(log, (size_t)log_bytes, "glCreateProgram failed");
        return 0;
    }
    gl->AttachShader(program, vertex);
    gl->AttachShader(program, fragment);
    gl->LinkProgram(program);
    gl->GetProgramiv(program, GL_LINK_STATUS, &is_linked);
    if (is_linked == GL_FALSE) {
        gl->GetProgramInfoLog(program, log_bytes, NULL, log);
        gl->DeleteProgram(program);
        return 0;
    }
    return program;
}

bool view_gl_program(const view_gl *gl, const char *vertex, const char *fragment, GLuint *out, svo_message *why)
{
    char log[SVO_MESSAGE_BYTES - 64] = "no reason is given";
    const GLuint first = compile(gl, GL_VERTEX_SHADER, vertex, log, sizeof log);
    const GLuint second = first != 0 ? compile(gl, GL_FRAGMENT_SHADER, fragment, log, sizeof log) : 0;
    *out = second != 0 ? link(gl, first, second, log, sizeof log) : 0;
    gl->DeleteShader(second);
    gl->DeleteShader(first);
    if (*out == 0) {
        (void)snprintf(why->text, sizeof why->text, "OpenGL: a shader was refused: %s", log);
    }
    return *out != 0;
}
