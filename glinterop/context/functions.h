/* SPDX-License-Identifier: MIT */
/*
 * The OpenGL entry points of one context, its version, extensions and limits.
 *
 * Everything in glinterop/ calls OpenGL through this table and never by name. So contexts of different drivers can
 * coexist in one process, and the program runs on a machine without OpenGL. The context's own loader fills the table:
 * eglGetProcAddress, OSMesaGetProcAddress or the caller's function.
 *
 * A loader may return a pointer for any name, even for a function that the driver lacks. Optional functions are
 * therefore looked up only when the context's version or extensions promise them, and are NULL otherwise.
 */
#ifndef SVO_GLINTEROP_CONTEXT_FUNCTIONS_H
#define SVO_GLINTEROP_CONTEXT_FUNCTIONS_H

#include <GL/glcorearb.h>
#include <stdbool.h>

#include "context/library.h"
#include "core/device.h"
#include "core/memory.h"
#include "svocl/status.h"

/* Versions are major * 10 + minor. The front end requires 4.3 and all its functions. */
#define SVO_I_GL_MINIMUM_VERSION 43
#define SVO_I_GL_NEVER_CORE      1000

/*
 * X(member, type, core version, extension): the list of entry points, looked up as "gl" + member. Required where the
 * core version is at most SVO_I_GL_MINIMUM_VERSION; otherwise NULL unless the context has that version or extension.
 */
#define SVO_I_GL_FUNCTION_LIST(X)                                                                   \
    X(GetError, PFNGLGETERRORPROC, 43, "")                                                          \
    X(GetString, PFNGLGETSTRINGPROC, 43, "")                                                        \
    X(GetStringi, PFNGLGETSTRINGIPROC, 43, "")                                                      \
    X(GetFloatv, PFNGLGETFLOATVPROC, 43, "")                                                        \
    X(GetIntegerv, PFNGLGETINTEGERVPROC, 43, "")                                                    \
    X(GetFloati_v, PFNGLGETFLOATI_VPROC, 43, "")                                                    \
    X(GetIntegeri_v, PFNGLGETINTEGERI_VPROC, 43, "")                                                \
    X(GetInteger64v, PFNGLGETINTEGER64VPROC, 43, "")                                                \
    X(GetInteger64i_v, PFNGLGETINTEGER64I_VPROC, 43, "")                                            \
    X(Finish, PFNGLFINISHPROC, 43, "")                                                              \
    X(Enable, PFNGLENABLEPROC, 43, "")                                                              \
    X(Disable, PFNGLDISABLEPROC, 43, "")                                                            \
    X(IsEnabled, PFNGLISENABLEDPROC, 43, "")                                                        \
    X(Enablei, PFNGLENABLEIPROC, 43, "")                                                            \
    X(Disablei, PFNGLDISABLEIPROC, 43, "")                                                          \
    X(IsEnabledi, PFNGLISENABLEDIPROC, 43, "")                                                      \
    X(PolygonMode, PFNGLPOLYGONMODEPROC, 43, "")                                                    \
    X(ViewportIndexedf, PFNGLVIEWPORTINDEXEDFPROC, 43, "")                                          \
    X(ScissorIndexed, PFNGLSCISSORINDEXEDPROC, 43, "")                                              \
    X(PointSize, PFNGLPOINTSIZEPROC, 43, "")                                                        \
    X(CreateShader, PFNGLCREATESHADERPROC, 43, "")                                                  \
    X(DeleteShader, PFNGLDELETESHADERPROC, 43, "")                                                  \
    X(ShaderSource, PFNGLSHADERSOURCEPROC, 43, "")                                                  \
    X(CompileShader, PFNGLCOMPILESHADERPROC, 43, "")                                                \
    X(GetShaderiv, PFNGLGETSHADERIVPROC, 43, "")                                                    \
    X(GetShaderInfoLog, PFNGLGETSHADERINFOLOGPROC, 43, "")                                          \
    X(CreateProgram, PFNGLCREATEPROGRAMPROC, 43, "")                                                \
    X(DeleteProgram, PFNGLDELETEPROGRAMPROC, 43, "")                                                \
    X(AttachShader, PFNGLATTACHSHADERPROC, 43, "")                                                  \
    X(LinkProgram, PFNGLLINKPROGRAMPROC, 43, "")                                                    \
    X(GetProgramiv, PFNGLGETPROGRAMIVPROC, 43, "")                                                  \
    X(GetProgramInfoLog, PFNGLGETPROGRAMINFOLOGPROC, 43, "")                                        \
    X(UseProgram, PFNGLUSEPROGRAMPROC, 43, "")                                                      \
    X(GetUniformLocation, PFNGLGETUNIFORMLOCATIONPROC, 43, "")                                      \
    X(Uniform1i, PFNGLUNIFORM1IPROC, 43, "")                                                        \
    X(Uniform2i, PFNGLUNIFORM2IPROC, 43, "")                                                        \
    X(Uniform1ui, PFNGLUNIFORM1UIPROC, 43, "")                                                      \
    X(GenBuffers, PFNGLGENBUFFERSPROC, 43, "")                                                      \
    X(DeleteBuffers, PFNGLDELETEBUFFERSPROC, 43, "")                                                \
    X(BindBuffer, PFNGLBINDBUFFERPROC, 43, "")                                                      \
    X(BindBufferBase, PFNGLBINDBUFFERBASEPROC, 43, "")                                              \
    X(BindBufferRange, PFNGLBINDBUFFERRANGEPROC, 43, "")                                            \
    X(IsBuffer, PFNGLISBUFFERPROC, 43, "")                                                          \
    X(GetBufferParameteri64v, PFNGLGETBUFFERPARAMETERI64VPROC, 43, "")                              \
    X(BufferData, PFNGLBUFFERDATAPROC, 43, "")                                                      \
    X(BufferSubData, PFNGLBUFFERSUBDATAPROC, 43, "")                                                \
    X(GetBufferSubData, PFNGLGETBUFFERSUBDATAPROC, 43, "")                                          \
    X(CopyBufferSubData, PFNGLCOPYBUFFERSUBDATAPROC, 43, "")                                        \
    X(ClearBufferData, PFNGLCLEARBUFFERDATAPROC, 43, "")                                            \
    X(ClearBufferSubData, PFNGLCLEARBUFFERSUBDATAPROC, 43, "")                                      \
    X(MapBufferRange, PFNGLMAPBUFFERRANGEPROC, 43, "")                                              \
    X(UnmapBuffer, PFNGLUNMAPBUFFERPROC, 43, "")                                                    \
    X(GenVertexArrays, PFNGLGENVERTEXARRAYSPROC, 43, "")                                            \
    X(DeleteVertexArrays, PFNGLDELETEVERTEXARRAYSPROC, 43, "")                                      \
    X(BindVertexArray, PFNGLBINDVERTEXARRAYPROC, 43, "")                                            \
    X(GenFramebuffers, PFNGLGENFRAMEBUFFERSPROC, 43, "")                                            \
    X(DeleteFramebuffers, PFNGLDELETEFRAMEBUFFERSPROC, 43, "")                                      \
    X(BindFramebuffer, PFNGLBINDFRAMEBUFFERPROC, 43, "")                                            \
    X(FramebufferParameteri, PFNGLFRAMEBUFFERPARAMETERIPROC, 43, "")                                \
    X(CheckFramebufferStatus, PFNGLCHECKFRAMEBUFFERSTATUSPROC, 43, "")                              \
    X(DrawArrays, PFNGLDRAWARRAYSPROC, 43, "")                                                      \
    X(DispatchCompute, PFNGLDISPATCHCOMPUTEPROC, 43, "")                                            \
    X(DispatchComputeIndirect, PFNGLDISPATCHCOMPUTEINDIRECTPROC, 43, "")                            \
    X(MemoryBarrier, PFNGLMEMORYBARRIERPROC, 43, "")                                                \
    X(GenQueries, PFNGLGENQUERIESPROC, 43, "")                                                      \
    X(DeleteQueries, PFNGLDELETEQUERIESPROC, 43, "")                                                \
    X(QueryCounter, PFNGLQUERYCOUNTERPROC, 43, "")                                                  \
    X(GetQueryObjectui64v, PFNGLGETQUERYOBJECTUI64VPROC, 43, "")                                    \
    X(ClipControl, PFNGLCLIPCONTROLPROC, 45, "GL_ARB_clip_control")                                 \
    X(GetGraphicsResetStatus, PFNGLGETGRAPHICSRESETSTATUSPROC, 45, "GL_KHR_robustness")             \
    X(BufferStorage, PFNGLBUFFERSTORAGEPROC, 44, "GL_ARB_buffer_storage")                           \
    X(ConservativeRasterParameteriNV, PFNGLCONSERVATIVERASTERPARAMETERINVPROC, SVO_I_GL_NEVER_CORE, \
      "GL_NV_conservative_raster_pre_snap_triangles")

/* The limits that glinterop/ reads. Counts may be 0: some drivers give the vertex stage no storage blocks. */
typedef struct svo_i_gl_limits {
    GLint64 storage_block_bytes; /* GL_MAX_SHADER_STORAGE_BLOCK_SIZE */
    GLint storage_offset_alignment_bytes;
    GLint storage_bindings;
    GLint vertex_storage_blocks;
    GLint fragment_storage_blocks;
    GLint compute_storage_blocks;
    GLint framebuffer_width, framebuffer_height; /* without attachments */
    GLint viewport_width, viewport_height;
    GLint compute_group_invocations; /* GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS */
} svo_i_gl_limits;

typedef struct svo_i_gl_functions {
#define SVO_I_GL_MEMBER(member, type, core_version, extension) type member;
    SVO_I_GL_FUNCTION_LIST(SVO_I_GL_MEMBER)
#undef SVO_I_GL_MEMBER
    int version; /* major * 10 + minor */
    const char *vendor, *renderer, *version_text; /* the driver's strings, valid as long as the context */
    char *extensions; /* separated by spaces; owned */
    svo_i_gl_limits limits;
} svo_i_gl_functions;

/*
 * Fills the table. Expects the context current. memory: for the extension names; NULL means malloc and free.
 *
 * Returns SVO_NO_GL naming the missing function or version, or SVO_OUT_OF_HOST_MEMORY; *gl is then all zero. Release
 * the table by svo_i_gl_unload, which accepts a zeroed or unloaded one.
 */
svo_status svo_i_gl_load(svo_i_gl_functions *gl, svo_i_get_proc_address get_proc_address, void *user,
                         const svo_i_memory *memory, svo_message *message);
void svo_i_gl_unload(svo_i_gl_functions *gl);

/* Whether the context lists the extension, compared as a whole name. */
bool svo_i_gl_has_extension(const svo_i_gl_functions *gl, const char *extension);

/* Whether a CPU renders, judged by the names of the known software renderers. */
bool svo_i_gl_is_software(const svo_i_gl_functions *gl);

/* Discards errors of earlier calls, so that the next svo_i_gl_check reports only svocl's own. */
void svo_i_gl_clear_errors(const svo_i_gl_functions *gl);
/* SVO_OK, or SVO_GL_ERROR (SVO_OUT_OF_DEVICE_MEMORY for GL_OUT_OF_MEMORY): "function: step: GL_NAME (0x...)". */
svo_status svo_i_gl_check(const svo_i_gl_functions *gl, const char *function, const char *step, svo_message *message);
/* The same after queries, of which the context need not know all names: GL_INVALID_ENUM is no failure. */
svo_status svo_i_gl_check_query(const svo_i_gl_functions *gl, const char *function, const char *step,
                                svo_message *message);

/* Compiles and links shaders, for rasterization (raster.c) and for the builder (compute/compute.c). */

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
