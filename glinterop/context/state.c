/* SPDX-License-Identifier: MIT */
/* Saves, sets and restores OpenGL state. */
#include "context/state.h"

#include <stddef.h>

/* Of the compatibility profile. */
#define POLYGON_STIPPLE 0x0B42

/* Which contexts have a capability. */
typedef enum known { ALWAYS = 0, COMPATIBILITY, NV, INTEL } known;

/* Capabilities that drop, move or add fragments, or write elsewhere. All are off while svocl draws; raster.c toggles
   the last two. Blending and logic operations need no entry: there is no color attachment. */
static const struct {
    GLenum name;
    known known;
} capabilities[] = {
    {GL_CULL_FACE, ALWAYS},
    {GL_DEPTH_TEST, ALWAYS},
    {GL_STENCIL_TEST, ALWAYS},
    {GL_MULTISAMPLE, ALWAYS},
    {GL_RASTERIZER_DISCARD, ALWAYS},
    {GL_PROGRAM_POINT_SIZE, ALWAYS},
    {GL_POLYGON_SMOOTH, ALWAYS},
    {GL_PRIMITIVE_RESTART, ALWAYS},
    {GL_PRIMITIVE_RESTART_FIXED_INDEX, ALWAYS},
    {GL_CLIP_DISTANCE0, ALWAYS},
    {GL_CLIP_DISTANCE1, ALWAYS},
    {GL_CLIP_DISTANCE2, ALWAYS},
    {GL_CLIP_DISTANCE3, ALWAYS},
    {GL_CLIP_DISTANCE4, ALWAYS},
    {GL_CLIP_DISTANCE5, ALWAYS},
    {GL_CLIP_DISTANCE6, ALWAYS},
    {GL_CLIP_DISTANCE7, ALWAYS},
    {POLYGON_STIPPLE, COMPATIBILITY},
    {GL_CONSERVATIVE_RASTERIZATION_NV, NV},
    {GL_CONSERVATIVE_RASTERIZATION_INTEL, INTEL},
};
enum { CAPABILITY_COUNT = sizeof capabilities / sizeof capabilities[0] };
_Static_assert(CAPABILITY_COUNT <= SVO_I_GL_STATE_CAPABILITIES_MAX, "svo_i_gl_state has room for all capabilities");

/* Generic buffer bindings and their queries. */
static const struct {
    GLenum target, binding;
} buffers[SVO_I_GL_STATE_BUFFERS] = {
    {GL_COPY_READ_BUFFER, GL_COPY_READ_BUFFER_BINDING},
    {GL_COPY_WRITE_BUFFER, GL_COPY_WRITE_BUFFER_BINDING},
    {GL_SHADER_STORAGE_BUFFER, GL_SHADER_STORAGE_BUFFER_BINDING},
    {GL_DISPATCH_INDIRECT_BUFFER, GL_DISPATCH_INDIRECT_BUFFER_BINDING},
};

static bool is_known(const svo_i_gl_functions *gl, known what)
{
    GLint profile = 0;
    switch (what) {
    case ALWAYS:
        return true;
    case COMPATIBILITY:
        gl->GetIntegerv(GL_CONTEXT_PROFILE_MASK, &profile);
        return ((GLuint)profile & GL_CONTEXT_COMPATIBILITY_PROFILE_BIT) != 0;
    case NV:
        return svo_i_gl_has_extension(gl, "GL_NV_conservative_raster");
    case INTEL:
        return svo_i_gl_has_extension(gl, "GL_INTEL_conservative_rasterization");
    }
    return false;
}

static bool has_conservative_mode(const svo_i_gl_functions *gl)
{
    return gl->ConservativeRasterParameteriNV != NULL &&
           svo_i_gl_has_extension(gl, "GL_NV_conservative_raster_pre_snap_triangles");
}

static void set_capability(const svo_i_gl_functions *gl, GLenum name, bool on)
{
    if (on) {
        gl->Enable(name);
    } else {
        gl->Disable(name);
    }
}

static GLuint storage_bindings(const svo_i_gl_functions *gl)
{
    const GLint has = gl->limits.storage_bindings;
    return has > 0 && has < SVO_I_GL_STATE_STORAGE_BINDINGS ? (GLuint)has : SVO_I_GL_STATE_STORAGE_BINDINGS;
}

static void save_buffers(const svo_i_gl_functions *gl, svo_i_gl_state *out)
{
    for (unsigned i = 0; i < SVO_I_GL_STATE_BUFFERS; ++i) {
        gl->GetIntegerv(buffers[i].binding, &out->buffers[i]);
    }
    for (GLuint i = 0; i < storage_bindings(gl); ++i) {
        gl->GetIntegeri_v(GL_SHADER_STORAGE_BUFFER_BINDING, i, &out->storage[i].name);
        gl->GetInteger64i_v(GL_SHADER_STORAGE_BUFFER_START, i, &out->storage[i].offset);
        gl->GetInteger64i_v(GL_SHADER_STORAGE_BUFFER_SIZE, i, &out->storage[i].bytes);
    }
}

void svo_i_gl_state_save(const svo_i_gl_functions *gl, svo_i_gl_state *out)
{
    *out = (svo_i_gl_state){0};
    save_buffers(gl, out);
    gl->GetIntegerv(GL_CURRENT_PROGRAM, &out->program);
    gl->GetIntegerv(GL_VERTEX_ARRAY_BINDING, &out->vertex_array);
    gl->GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &out->draw_framebuffer);
    gl->GetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &out->read_framebuffer);
    gl->GetFloati_v(GL_VIEWPORT, 0, out->viewport);
    gl->GetIntegeri_v(GL_SCISSOR_BOX, 0, out->scissor);
    out->scissor_test = gl->IsEnabledi(GL_SCISSOR_TEST, 0);
    for (unsigned i = 0; i < CAPABILITY_COUNT; ++i) {
        if (is_known(gl, capabilities[i].known)) {
            out->capabilities[i] = gl->IsEnabled(capabilities[i].name);
        }
    }
    gl->GetIntegerv(GL_POLYGON_MODE, out->polygon_mode);
    gl->GetFloatv(GL_POINT_SIZE, &out->point_size);
    if (gl->ClipControl != NULL) {
        gl->GetIntegerv(GL_CLIP_ORIGIN, &out->clip_origin);
        gl->GetIntegerv(GL_CLIP_DEPTH_MODE, &out->clip_depth);
    }
    if (has_conservative_mode(gl)) {
        gl->GetIntegerv(GL_CONSERVATIVE_RASTER_MODE_NV, &out->conservative_mode);
    }
}

/* Indexed bindings first: setting one sets the generic binding too. */
static void restore_buffers(const svo_i_gl_functions *gl, const svo_i_gl_state *state)
{
    for (GLuint i = 0; i < storage_bindings(gl); ++i) {
        const GLuint name = (GLuint)state->storage[i].name;
        if (name != 0 && state->storage[i].bytes > 0) {
            gl->BindBufferRange(GL_SHADER_STORAGE_BUFFER, i, name, (GLintptr)state->storage[i].offset,
                                (GLsizeiptr)state->storage[i].bytes);
        } else {
            gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, i, name);
        }
    }
    for (unsigned i = 0; i < SVO_I_GL_STATE_BUFFERS; ++i) {
        gl->BindBuffer(buffers[i].target, (GLuint)state->buffers[i]);
    }
}

/* A core profile has one mode for both faces and rejects a mode for one face. Drivers report it once or twice. */
static void restore_polygon_mode(const svo_i_gl_functions *gl, const svo_i_gl_state *state)
{
    const GLenum front = (GLenum)state->polygon_mode[0], back = (GLenum)state->polygon_mode[1];
    if (front == back || !is_known(gl, COMPATIBILITY)) {
        gl->PolygonMode(GL_FRONT_AND_BACK, front);
        return;
    }
    gl->PolygonMode(GL_FRONT, front);
    gl->PolygonMode(GL_BACK, back);
}

void svo_i_gl_state_restore(const svo_i_gl_functions *gl, const svo_i_gl_state *state)
{
    restore_buffers(gl, state);
    gl->UseProgram((GLuint)state->program);
    gl->BindVertexArray((GLuint)state->vertex_array);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, (GLuint)state->draw_framebuffer);
    gl->BindFramebuffer(GL_READ_FRAMEBUFFER, (GLuint)state->read_framebuffer);
    gl->ViewportIndexedf(0, state->viewport[0], state->viewport[1], state->viewport[2], state->viewport[3]);
    gl->ScissorIndexed(0, state->scissor[0], state->scissor[1], state->scissor[2], state->scissor[3]);
    if (state->scissor_test) {
        gl->Enablei(GL_SCISSOR_TEST, 0);
    } else {
        gl->Disablei(GL_SCISSOR_TEST, 0);
    }
    for (unsigned i = 0; i < CAPABILITY_COUNT; ++i) {
        if (is_known(gl, capabilities[i].known)) {
            set_capability(gl, capabilities[i].name, state->capabilities[i] == GL_TRUE);
        }
    }
    restore_polygon_mode(gl, state);
    gl->PointSize(state->point_size);
    if (gl->ClipControl != NULL) {
        gl->ClipControl((GLenum)state->clip_origin, (GLenum)state->clip_depth);
    }
    if (has_conservative_mode(gl)) {
        gl->ConservativeRasterParameteriNV(GL_CONSERVATIVE_RASTER_MODE_NV, state->conservative_mode);
    }
    svo_i_gl_clear_errors(gl);
}

void svo_i_gl_state_set_plain(const svo_i_gl_functions *gl)
{
    for (unsigned i = 0; i < CAPABILITY_COUNT; ++i) {
        if (is_known(gl, capabilities[i].known)) {
            gl->Disable(capabilities[i].name);
        }
    }
    gl->PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    gl->PointSize(1.0f);
    if (gl->ClipControl != NULL) {
        gl->ClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    }
    gl->Enablei(GL_SCISSOR_TEST, 0);
}
