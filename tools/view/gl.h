/* SPDX-License-Identifier: MIT */
/* The functions of OpenGL 4.3 core that the viewer calls, found in the context of its window. */
#ifndef SVOCL_TOOLS_VIEW_GL_H
#define SVOCL_TOOLS_VIEW_GL_H

#include <GL/glcorearb.h>
#include <stdbool.h>

#include "svocl/status.h"

#define VIEW_GL_FUNCTIONS(X)                                     \
    X(ActiveTexture, PFNGLACTIVETEXTUREPROC)                     \
    X(AttachShader, PFNGLATTACHSHADERPROC)                       \
    X(BindBuffer, PFNGLBINDBUFFERPROC)                           \
    X(BindFramebuffer, PFNGLBINDFRAMEBUFFERPROC)                 \
    X(BindTexture, PFNGLBINDTEXTUREPROC)                         \
    X(BindVertexArray, PFNGLBINDVERTEXARRAYPROC)                 \
    X(BindVertexBuffer, PFNGLBINDVERTEXBUFFERPROC)               \
    X(BlitFramebuffer, PFNGLBLITFRAMEBUFFERPROC)                 \
    X(BlendFunc, PFNGLBLENDFUNCPROC)                             \
    X(BufferData, PFNGLBUFFERDATAPROC)                           \
    X(Clear, PFNGLCLEARPROC)                                     \
    X(ClearColor, PFNGLCLEARCOLORPROC)                           \
    X(CheckFramebufferStatus, PFNGLCHECKFRAMEBUFFERSTATUSPROC)   \
    X(CompileShader, PFNGLCOMPILESHADERPROC)                     \
    X(CreateProgram, PFNGLCREATEPROGRAMPROC)                     \
    X(CreateShader, PFNGLCREATESHADERPROC)                       \
    X(DeleteBuffers, PFNGLDELETEBUFFERSPROC)                     \
    X(DeleteFramebuffers, PFNGLDELETEFRAMEBUFFERSPROC)           \
    X(DeleteProgram, PFNGLDELETEPROGRAMPROC)                     \
    X(DeleteShader, PFNGLDELETESHADERPROC)                       \
    X(DeleteTextures, PFNGLDELETETEXTURESPROC)                   \
    X(DeleteVertexArrays, PFNGLDELETEVERTEXARRAYSPROC)           \
    X(Disable, PFNGLDISABLEPROC)                                 \
    X(DrawArrays, PFNGLDRAWARRAYSPROC)                           \
    X(DrawElements, PFNGLDRAWELEMENTSPROC)                       \
    X(Enable, PFNGLENABLEPROC)                                   \
    X(EnableVertexAttribArray, PFNGLENABLEVERTEXATTRIBARRAYPROC) \
    X(Finish, PFNGLFINISHPROC)                                   \
    X(FramebufferTexture2D, PFNGLFRAMEBUFFERTEXTURE2DPROC)       \
    X(GenBuffers, PFNGLGENBUFFERSPROC)                           \
    X(GenFramebuffers, PFNGLGENFRAMEBUFFERSPROC)                 \
    X(GenTextures, PFNGLGENTEXTURESPROC)                         \
    X(GenVertexArrays, PFNGLGENVERTEXARRAYSPROC)                 \
    X(GetError, PFNGLGETERRORPROC)                               \
    X(GetIntegerv, PFNGLGETINTEGERVPROC)                         \
    X(GetProgramInfoLog, PFNGLGETPROGRAMINFOLOGPROC)             \
    X(GetProgramiv, PFNGLGETPROGRAMIVPROC)                       \
    X(GetShaderInfoLog, PFNGLGETSHADERINFOLOGPROC)               \
    X(GetShaderiv, PFNGLGETSHADERIVPROC)                         \
    X(GetString, PFNGLGETSTRINGPROC)                             \
    X(LinkProgram, PFNGLLINKPROGRAMPROC)                         \
    X(PixelStorei, PFNGLPIXELSTOREIPROC)                         \
    X(ReadPixels, PFNGLREADPIXELSPROC)                           \
    X(Scissor, PFNGLSCISSORPROC)                                 \
    X(ShaderSource, PFNGLSHADERSOURCEPROC)                       \
    X(TexImage2D, PFNGLTEXIMAGE2DPROC)                           \
    X(TexParameteri, PFNGLTEXPARAMETERIPROC)                     \
    X(TexSubImage2D, PFNGLTEXSUBIMAGE2DPROC)                     \
    X(Uniform2f, PFNGLUNIFORM2FPROC)                             \
    X(UseProgram, PFNGLUSEPROGRAMPROC)                           \
    X(VertexAttribBinding, PFNGLVERTEXATTRIBBINDINGPROC)         \
    X(VertexAttribFormat, PFNGLVERTEXATTRIBFORMATPROC)           \
    X(Viewport, PFNGLVIEWPORTPROC)

#define VIEW_GL_FIELD(name, type) type name;
typedef struct view_gl {
    VIEW_GL_FUNCTIONS(VIEW_GL_FIELD)
} view_gl;
#undef VIEW_GL_FIELD

/* Fills the table. Returns the name of a function that the context lacks, or NULL. */
const char *view_gl_load(view_gl *gl, void *(*find)(const char *name));

/* Whether there was no error since the last call; else the first one, while doing what. */
bool view_gl_check(const view_gl *gl, const char *what, svo_message *why);

/* Compiles and links. */
bool view_gl_program(const view_gl *gl, const char *vertex, const char *fragment, GLuint *out, svo_message *why);

#endif
