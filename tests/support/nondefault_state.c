/* SPDX-License-Identifier: MIT */
/* Sets, records and compares OpenGL state. */
#include "nondefault_state.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <GL/glcorearb.h>

#include "own_context.h"

#define POLYGON_STIPPLE 0x0B42

/* X(member, type): entry points, looked up as "gl" + member. */
#define FUNCTION_LIST(X)                                         \
    X(ActiveTexture, PFNGLACTIVETEXTUREPROC)                     \
    X(AttachShader, PFNGLATTACHSHADERPROC)                       \
    X(BindBuffer, PFNGLBINDBUFFERPROC)                           \
    X(BindBufferBase, PFNGLBINDBUFFERBASEPROC)                   \
    X(BindBufferRange, PFNGLBINDBUFFERRANGEPROC)                 \
    X(BindFramebuffer, PFNGLBINDFRAMEBUFFERPROC)                 \
    X(BindRenderbuffer, PFNGLBINDRENDERBUFFERPROC)               \
    X(BindSampler, PFNGLBINDSAMPLERPROC)                         \
    X(BindTexture, PFNGLBINDTEXTUREPROC)                         \
    X(BindVertexArray, PFNGLBINDVERTEXARRAYPROC)                 \
    X(BufferData, PFNGLBUFFERDATAPROC)                           \
    X(ClipControl, PFNGLCLIPCONTROLPROC)                         \
    X(ColorMask, PFNGLCOLORMASKPROC)                             \
    X(CompileShader, PFNGLCOMPILESHADERPROC)                     \
    X(CreateProgram, PFNGLCREATEPROGRAMPROC)                     \
    X(CreateShader, PFNGLCREATESHADERPROC)                       \
    X(CullFace, PFNGLCULLFACEPROC)                               \
    X(DeleteBuffers, PFNGLDELETEBUFFERSPROC)                     \
    X(DeleteProgram, PFNGLDELETEPROGRAMPROC)                     \
    X(DepthFunc, PFNGLDEPTHFUNCPROC)                             \
    X(DepthMask, PFNGLDEPTHMASKPROC)                             \
    X(DepthRange, PFNGLDEPTHRANGEPROC)                           \
    X(Disable, PFNGLDISABLEPROC)                                 \
    X(Enable, PFNGLENABLEPROC)                                   \
    X(Enablei, PFNGLENABLEIPROC)                                 \
    X(EnableVertexAttribArray, PFNGLENABLEVERTEXATTRIBARRAYPROC) \
    X(FramebufferTexture2D, PFNGLFRAMEBUFFERTEXTURE2DPROC)       \
    X(FrontFace, PFNGLFRONTFACEPROC)                             \
    X(GenBuffers, PFNGLGENBUFFERSPROC)                           \
    X(GenFramebuffers, PFNGLGENFRAMEBUFFERSPROC)                 \
    X(GenProgramPipelines, PFNGLGENPROGRAMPIPELINESPROC)         \
    X(BindProgramPipeline, PFNGLBINDPROGRAMPIPELINEPROC)         \
    X(GenRenderbuffers, PFNGLGENRENDERBUFFERSPROC)               \
    X(GenSamplers, PFNGLGENSAMPLERSPROC)                         \
    X(GenTextures, PFNGLGENTEXTURESPROC)                         \
    X(GenVertexArrays, PFNGLGENVERTEXARRAYSPROC)                 \
    X(GetError, PFNGLGETERRORPROC)                               \
    X(GetBooleani_v, PFNGLGETBOOLEANI_VPROC)                     \
    X(GetDoublev, PFNGLGETDOUBLEVPROC)                           \
    X(GetDoublei_v, PFNGLGETDOUBLEI_VPROC)                       \
    X(GetInteger64i_v, PFNGLGETINTEGER64I_VPROC)                 \
    X(GetIntegeri_v, PFNGLGETINTEGERI_VPROC)                     \
    X(IsEnabled, PFNGLISENABLEDPROC)                             \
    X(IsEnabledi, PFNGLISENABLEDIPROC)                           \
    X(LinkProgram, PFNGLLINKPROGRAMPROC)                         \
    X(LogicOp, PFNGLLOGICOPPROC)                                 \
    X(PixelStorei, PFNGLPIXELSTOREIPROC)                         \
    X(PointSize, PFNGLPOINTSIZEPROC)                             \
    X(PolygonMode, PFNGLPOLYGONMODEPROC)                         \
    X(PrimitiveRestartIndex, PFNGLPRIMITIVERESTARTINDEXPROC)     \
    X(ProvokingVertex, PFNGLPROVOKINGVERTEXPROC)                 \
    X(ScissorIndexed, PFNGLSCISSORINDEXEDPROC)                   \
    X(ShaderSource, PFNGLSHADERSOURCEPROC)                       \
    X(StencilFunc, PFNGLSTENCILFUNCPROC)                         \
    X(StencilMask, PFNGLSTENCILMASKPROC)                         \
    X(TexImage2D, PFNGLTEXIMAGE2DPROC)                           \
    X(UseProgram, PFNGLUSEPROGRAMPROC)                           \
    X(ViewportIndexedf, PFNGLVIEWPORTINDEXEDFPROC)

typedef struct functions {
#define MEMBER(member, type) type member;
    FUNCTION_LIST(MEMBER)
#undef MEMBER
} functions;

#define NAMED(name) \
    {               \
#name, name \
    }
typedef struct named {
    const char *text;
    GLenum name;
} named;

/* State values of one to four numbers. */
static const named values[] = {
    NAMED(GL_ARRAY_BUFFER_BINDING),
    NAMED(GL_ELEMENT_ARRAY_BUFFER_BINDING),
    NAMED(GL_COPY_READ_BUFFER_BINDING),
    NAMED(GL_COPY_WRITE_BUFFER_BINDING),
    NAMED(GL_PIXEL_PACK_BUFFER_BINDING),
    NAMED(GL_PIXEL_UNPACK_BUFFER_BINDING),
    NAMED(GL_TRANSFORM_FEEDBACK_BUFFER_BINDING),
    NAMED(GL_UNIFORM_BUFFER_BINDING),
    NAMED(GL_SHADER_STORAGE_BUFFER_BINDING),
    NAMED(GL_ATOMIC_COUNTER_BUFFER_BINDING),
    NAMED(GL_DRAW_INDIRECT_BUFFER_BINDING),
    NAMED(GL_DISPATCH_INDIRECT_BUFFER_BINDING),
    NAMED(GL_CURRENT_PROGRAM),
    NAMED(GL_PROGRAM_PIPELINE_BINDING),
    NAMED(GL_VERTEX_ARRAY_BINDING),
    NAMED(GL_DRAW_FRAMEBUFFER_BINDING),
    NAMED(GL_READ_FRAMEBUFFER_BINDING),
    NAMED(GL_RENDERBUFFER_BINDING),
    NAMED(GL_ACTIVE_TEXTURE),
    NAMED(GL_TEXTURE_BINDING_2D),
    NAMED(GL_SAMPLER_BINDING),
    NAMED(GL_CULL_FACE_MODE),
    NAMED(GL_FRONT_FACE),
    NAMED(GL_PROVOKING_VERTEX),
    NAMED(GL_DEPTH_FUNC),
    NAMED(GL_DEPTH_WRITEMASK),
    NAMED(GL_DEPTH_RANGE),
    NAMED(GL_STENCIL_FUNC),
    NAMED(GL_STENCIL_REF),
    NAMED(GL_STENCIL_WRITEMASK),
    NAMED(GL_STENCIL_BACK_WRITEMASK),
    NAMED(GL_COLOR_WRITEMASK),
    NAMED(GL_LOGIC_OP_MODE),
    NAMED(GL_POLYGON_MODE),
    NAMED(GL_POINT_SIZE),
    NAMED(GL_PRIMITIVE_RESTART_INDEX),
    NAMED(GL_UNPACK_ALIGNMENT),
    NAMED(GL_UNPACK_SKIP_PIXELS),
    NAMED(GL_UNPACK_SWAP_BYTES),
    NAMED(GL_PACK_ALIGNMENT),
    NAMED(GL_CLIP_ORIGIN),
    NAMED(GL_CLIP_DEPTH_MODE),
};

static const named capabilities[] = {
    NAMED(GL_BLEND),
    NAMED(GL_CULL_FACE),
    NAMED(GL_DEPTH_TEST),
    NAMED(GL_DEPTH_CLAMP),
    NAMED(GL_STENCIL_TEST),
    NAMED(GL_SCISSOR_TEST),
    NAMED(GL_MULTISAMPLE),
    NAMED(GL_COLOR_LOGIC_OP),
    NAMED(GL_RASTERIZER_DISCARD),
    NAMED(GL_PROGRAM_POINT_SIZE),
    NAMED(GL_POLYGON_SMOOTH),
    NAMED(GL_POLYGON_OFFSET_FILL),
    NAMED(GL_PRIMITIVE_RESTART),
    NAMED(GL_PRIMITIVE_RESTART_FIXED_INDEX),
    NAMED(GL_SAMPLE_ALPHA_TO_COVERAGE),
    NAMED(GL_SAMPLE_COVERAGE),
    NAMED(GL_SAMPLE_MASK),
    NAMED(GL_FRAMEBUFFER_SRGB),
    NAMED(GL_DITHER),
    NAMED(GL_CLIP_DISTANCE0),
    NAMED(GL_CLIP_DISTANCE3),
    NAMED(GL_CLIP_DISTANCE5),
};

/* Indexed buffer bindings: name, offset and length. */
static const struct {
    GLenum target;
    named binding, start, size;
    GLuint count;
} indexed[] = {
    {GL_SHADER_STORAGE_BUFFER, NAMED(GL_SHADER_STORAGE_BUFFER_BINDING), NAMED(GL_SHADER_STORAGE_BUFFER_START),
     NAMED(GL_SHADER_STORAGE_BUFFER_SIZE), 16},
    {GL_UNIFORM_BUFFER, NAMED(GL_UNIFORM_BUFFER_BINDING), NAMED(GL_UNIFORM_BUFFER_START), NAMED(GL_UNIFORM_BUFFER_SIZE),
     6},
    {GL_ATOMIC_COUNTER_BUFFER, NAMED(GL_ATOMIC_COUNTER_BUFFER_BINDING), NAMED(GL_ATOMIC_COUNTER_BUFFER_START),
     NAMED(GL_ATOMIC_COUNTER_BUFFER_SIZE), 1},
    {GL_TRANSFORM_FEEDBACK_BUFFER, NAMED(GL_TRANSFORM_FEEDBACK_BUFFER_BINDING),
     NAMED(GL_TRANSFORM_FEEDBACK_BUFFER_START), NAMED(GL_TRANSFORM_FEEDBACK_BUFFER_SIZE), 2},
};

enum {
    VALUE_COUNT = sizeof values / sizeof values[0],
    CAPABILITY_COUNT = sizeof capabilities / sizeof capabilities[0],
    INDEXED_KINDS = sizeof indexed / sizeof indexed[0],
    INDEXED_MAX = 16,
    VIEWPORTS = 4,
    BUFFER_COUNT = 16,
    BUFFER_BYTES = 8192
};

typedef struct record {
    GLdouble values[VALUE_COUNT][4];
    GLboolean capabilities[CAPABILITY_COUNT];
    GLint64 indexed[INDEXED_KINDS][INDEXED_MAX][3];
    GLdouble viewports[VIEWPORTS][4];
    GLint scissors[VIEWPORTS][4];
    GLboolean scissor_tests[VIEWPORTS];
    GLboolean polygon_stipple;
} record;

struct nondefault_state {
    functions gl;
    bool compatibility;
    GLuint program, buffers[BUFFER_COUNT];
    record expected;
};

static void load_functions(functions *gl)
{
#define LOAD(member, type)                                       \
    gl->member = (type)own_context_function(NULL, "gl" #member); \
    assert_non_null(gl->member);
    FUNCTION_LIST(LOAD)
#undef LOAD
}

static void take_record(const nondefault_state *odd, record *out)
{
    const functions *gl = &odd->gl;
    memset(out, 0, sizeof *out);
    for (int i = 0; i < VALUE_COUNT; ++i) {
        gl->GetDoublev(values[i].name, out->values[i]);
    }
    for (int i = 0; i < CAPABILITY_COUNT; ++i) {
        out->capabilities[i] = gl->IsEnabled(capabilities[i].name);
    }
    for (int kind = 0; kind < INDEXED_KINDS; ++kind) {
        for (GLuint i = 0; i < indexed[kind].count; ++i) {
            gl->GetInteger64i_v(indexed[kind].binding.name, i, &out->indexed[kind][i][0]);
            gl->GetInteger64i_v(indexed[kind].start.name, i, &out->indexed[kind][i][1]);
            gl->GetInteger64i_v(indexed[kind].size.name, i, &out->indexed[kind][i][2]);
        }
    }
    for (GLuint i = 0; i < VIEWPORTS; ++i) {
        gl->GetDoublei_v(GL_VIEWPORT, i, out->viewports[i]);
        gl->GetIntegeri_v(GL_SCISSOR_BOX, i, out->scissors[i]);
        out->scissor_tests[i] = gl->IsEnabledi(GL_SCISSOR_TEST, i);
    }
    out->polygon_stipple = odd->compatibility ? gl->IsEnabled(POLYGON_STIPPLE) : GL_FALSE;
    assert_int_equal(gl->GetError(), GL_NO_ERROR);
}

static GLuint make_program(const functions *gl)
{
    static const char *const sources[2] = {"#version 430\nvoid main() { gl_Position = vec4(0.0); }\n",
                                           "#version 430\nout vec4 color;\nvoid main() { color = vec4(1.0); }\n"};
    const GLuint program = gl->CreateProgram();
    for (int i = 0; i < 2; ++i) {
        const GLuint shader = gl->CreateShader(i == 0 ? GL_VERTEX_SHADER : GL_FRAGMENT_SHADER);
        gl->ShaderSource(shader, 1, &sources[i], NULL);
        gl->CompileShader(shader);
        gl->AttachShader(program, shader);
    }
    gl->LinkProgram(program);
    return program;
}

static void set_buffers(nondefault_state *odd)
{
    static const GLenum generic[] = {
        GL_ARRAY_BUFFER,          GL_ELEMENT_ARRAY_BUFFER,  GL_COPY_READ_BUFFER,     GL_COPY_WRITE_BUFFER,
        GL_PIXEL_PACK_BUFFER,     GL_PIXEL_UNPACK_BUFFER,   GL_UNIFORM_BUFFER,       GL_TRANSFORM_FEEDBACK_BUFFER,
        GL_SHADER_STORAGE_BUFFER, GL_ATOMIC_COUNTER_BUFFER, GL_DRAW_INDIRECT_BUFFER, GL_DISPATCH_INDIRECT_BUFFER};
    const functions *gl = &odd->gl;
    gl->GenBuffers(BUFFER_COUNT, odd->buffers);
    for (int i = 0; i < BUFFER_COUNT; ++i) {
        gl->BindBuffer(GL_ARRAY_BUFFER, odd->buffers[i]);
        gl->BufferData(GL_ARRAY_BUFFER, BUFFER_BYTES, NULL, GL_STATIC_DRAW);
    }
    for (int kind = 0; kind < INDEXED_KINDS; ++kind) {
        for (GLuint i = 0; i < indexed[kind].count; ++i) {
            const GLuint name = odd->buffers[(i * 3 + (GLuint)kind) % BUFFER_COUNT];
            if (i % 3 == 0) {
                gl->BindBufferBase(indexed[kind].target, i, name);
            } else if (i != 4 && i != 14) { /* some without a buffer */
                gl->BindBufferRange(indexed[kind].target, i, name, 256 * (GLintptr)i, 64 + 16 * (GLsizeiptr)i);
            }
        }
    }
    for (size_t i = 0; i < sizeof generic / sizeof generic[0]; ++i) {
        gl->BindBuffer(generic[i], odd->buffers[(i + 5) % BUFFER_COUNT]);
    }
}

static void set_objects(nondefault_state *odd)
{
    const functions *gl = &odd->gl;
    GLuint vertex_array = 0, framebuffers[2] = {0, 0}, texture = 0, sampler = 0, renderbuffer = 0, pipeline = 0;
    gl->GenVertexArrays(1, &vertex_array);
    gl->BindVertexArray(vertex_array);
    gl->EnableVertexAttribArray(2);
    odd->program = make_program(gl);
    gl->UseProgram(odd->program);
    gl->GenProgramPipelines(1, &pipeline);
    gl->BindProgramPipeline(pipeline);
    gl->ActiveTexture(GL_TEXTURE3);
    gl->GenTextures(1, &texture);
    gl->BindTexture(GL_TEXTURE_2D, texture);
    gl->TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, 16, 16, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
    gl->GenSamplers(1, &sampler);
    gl->BindSampler(3, sampler);
    gl->GenRenderbuffers(1, &renderbuffer);
    gl->BindRenderbuffer(GL_RENDERBUFFER, renderbuffer);
    gl->GenFramebuffers(2, framebuffers);
    gl->BindFramebuffer(GL_READ_FRAMEBUFFER, framebuffers[0]);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffers[1]);
    gl->FramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
}

static void set_rasterization(const nondefault_state *odd)
{
    const functions *gl = &odd->gl;
    for (GLuint i = 0; i < VIEWPORTS; ++i) {
        gl->ViewportIndexedf(i, 1.5f + (GLfloat)i, 2.25f, 30.0f + (GLfloat)i, 17.5f);
        gl->ScissorIndexed(i, 1 + (GLint)i, 2, 3, 4 + (GLint)i);
    }
    gl->Enablei(GL_SCISSOR_TEST, 1);
    gl->CullFace(GL_FRONT_AND_BACK);
    gl->FrontFace(GL_CW);
    gl->PolygonMode(GL_FRONT_AND_BACK, GL_POINT);
    if (odd->compatibility) {
        gl->PolygonMode(GL_BACK, GL_LINE);
        gl->Enable(POLYGON_STIPPLE);
    }
    gl->PointSize(5.0f);
    gl->PrimitiveRestartIndex(3);
    gl->ProvokingVertex(GL_FIRST_VERTEX_CONVENTION);
    gl->ClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
}

static void set_output(const nondefault_state *odd)
{
    const functions *gl = &odd->gl;
    gl->DepthFunc(GL_NEVER);
    gl->DepthMask(GL_FALSE);
    gl->DepthRange(0.75, 0.25);
    gl->StencilFunc(GL_NEVER, 5, 0x33);
    gl->StencilMask(0x5a);
    gl->ColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
    gl->LogicOp(GL_XOR);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 8);
    gl->PixelStorei(GL_UNPACK_SKIP_PIXELS, 3);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 2);
    for (int i = 0; i < CAPABILITY_COUNT; ++i) {
        if (capabilities[i].name != GL_SCISSOR_TEST && capabilities[i].name != GL_MULTISAMPLE &&
            capabilities[i].name != GL_DITHER) {
            gl->Enable(capabilities[i].name);
        }
    }
    gl->Disable(GL_MULTISAMPLE);
    gl->Disable(GL_DITHER);
}

nondefault_state *nondefault_state_set(bool compatibility)
{
    nondefault_state *odd = calloc(1, sizeof *odd);
    assert_non_null(odd);
    odd->compatibility = compatibility;
    load_functions(&odd->gl);
    set_objects(odd);
    set_buffers(odd);
    set_rasterization(odd);
    set_output(odd);
    assert_int_equal(odd->gl.GetError(), GL_NO_ERROR);
    take_record(odd, &odd->expected);
    return odd;
}

/* Counts and prints a difference. */
static int differs(bool different, const char *what, unsigned index)
{
    if (different) {
        print_message("%s, %u, has changed\n", what, index);
    }
    return different;
}

static bool same_numbers(const GLdouble a[4], const GLdouble b[4])
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2] && a[3] == b[3];
}

static int count_differences(const record *a, const record *b)
{
    int count = 0;
    for (int i = 0; i < VALUE_COUNT; ++i) {
        count += differs(!same_numbers(a->values[i], b->values[i]), values[i].text, 0);
    }
    for (int i = 0; i < CAPABILITY_COUNT; ++i) {
        count += differs(a->capabilities[i] != b->capabilities[i], capabilities[i].text, 0);
    }
    for (int kind = 0; kind < INDEXED_KINDS; ++kind) {
        for (unsigned i = 0; i < indexed[kind].count; ++i) {
            count += differs(memcmp(a->indexed[kind][i], b->indexed[kind][i], sizeof a->indexed[kind][i]) != 0,
                             indexed[kind].binding.text, i);
        }
    }
    for (unsigned i = 0; i < VIEWPORTS; ++i) {
        count += differs(!same_numbers(a->viewports[i], b->viewports[i]), "GL_VIEWPORT", i);
        count += differs(memcmp(a->scissors[i], b->scissors[i], sizeof a->scissors[i]) != 0, "GL_SCISSOR_BOX", i);
        count += differs(a->scissor_tests[i] != b->scissor_tests[i], "GL_SCISSOR_TEST", i);
    }
    return count + differs(a->polygon_stipple != b->polygon_stipple, "GL_POLYGON_STIPPLE", 0);
}

void nondefault_state_assert(const nondefault_state *odd, const char *after)
{
    record actual;
    take_record(odd, &actual);
    if (count_differences(&actual, &odd->expected) != 0) {
        fail_msg("after %s", after);
    }
}

void nondefault_state_destroy(nondefault_state **odd)
{
    (*odd)->gl.UseProgram(0);
    (*odd)->gl.DeleteProgram((*odd)->program);
    (*odd)->gl.DeleteBuffers(BUFFER_COUNT, (*odd)->buffers);
    free(*odd);
    *odd = NULL;
}
