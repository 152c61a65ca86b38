/* SPDX-License-Identifier: MIT */
/*
 * Draws triangles into chunks of fragments: one program per class of triangles, one draw call per class and chunk. The
 * framebuffer has no attachments; all output goes to storage blocks.
 */
#include "raster/raster.h"

#include "context/functions.h"
#include "context/state.h"
#include "core/message.h"

#define FUNCTION         "svo_build"
#define BINDING_VERTICES 0
#define BINDING_INDICES  1
#define BINDING_ITEMS    2
#define BINDING_COUNTERS 3
/* The smallest storage block limit that allows chunks of a useful size. */
#define STORAGE_BLOCK_BYTES_MIN 16384

/* Made by cmake/embed.cmake. */
extern const char svo_i_source_raster_common[];
extern const char svo_i_source_raster_vertex[];
extern const char svo_i_source_raster_fragment[];

typedef struct raster_program {
    GLuint name; /* 0: not compiled */
    bool points; /* drawn as points, else as triangles */
    GLint depth, voxel_log2, open, view_origin, view_log2, first_item, chunk, capacity;
} raster_program;

/* The properties of a plan that select a program, besides the class of triangles. */
typedef struct variant {
    bool code48, thin;
} variant;

static variant variant_of(const svo_plan *plan)
{
    return (variant){.code48 = plan->info.depth > SVO_CODE30_DEPTH_MAX,
                     .thin = plan->info.coverage == SVO_COVERAGE_THIN};
}

struct svo_i_raster {
    svo_device *device;
    svo_gl_context *context;
    const svo_i_gl_functions *gl;
    svo_i_conservative conservative;
    bool int64;
    raster_program programs[SVO_I_CLASS_COUNT][2][2]; /* by class; codes of 30 and 48 bits; thin */
    GLuint vertex_array, framebuffer;
    GLuint buffers[4]; /* by binding */
};

svo_i_conservative svo_i_raster_hardware(const svo_i_gl_functions *gl, const char **reason)
{
    const bool nv = svo_i_gl_has_extension(gl, "GL_NV_conservative_raster");
    *reason = "";
    if (nv && svo_i_gl_has_extension(gl, "GL_NV_conservative_raster_pre_snap_triangles") &&
        gl->ConservativeRasterParameteriNV != NULL) {
        return SVO_I_CONSERVATIVE_NV;
    }
    if (svo_i_gl_has_extension(gl, "GL_INTEL_conservative_rasterization")) {
        return SVO_I_CONSERVATIVE_INTEL;
    }
    *reason = nv ? "GL_NV_conservative_raster without GL_NV_conservative_raster_pre_snap_triangles"
                 : "the context lists neither GL_NV_conservative_raster nor GL_INTEL_conservative_rasterization";
    return SVO_I_CONSERVATIVE_EXPAND;
}

/* SVO_OK, or the first OpenGL error with the step in the device's message. */
static svo_status check(const svo_i_raster *raster, const char *step)
{
    return svo_i_gl_check(raster->gl, FUNCTION, step, &raster->device->message);
}

static svo_status check_limits(svo_device *device, const svo_i_gl_functions *gl)
{
    if (gl->limits.vertex_storage_blocks < 3 || gl->limits.fragment_storage_blocks < 2) {
        return svo_i_device_fail(
            device, SVO_UNSUPPORTED,
            "svo_gl_create: %s has %d storage blocks for vertices and %d for fragments, below 3 and 2", gl->renderer,
            gl->limits.vertex_storage_blocks, gl->limits.fragment_storage_blocks);
    }
    if (gl->limits.storage_block_bytes < STORAGE_BLOCK_BYTES_MIN) {
        return svo_i_device_fail(device, SVO_UNSUPPORTED,
                                 "svo_gl_create: %s has a storage block limit of %lld bytes, below %d", gl->renderer,
                                 (long long)gl->limits.storage_block_bytes, STORAGE_BLOCK_BYTES_MIN);
    }
    return SVO_OK;
}

static svo_status create_objects(svo_i_raster *raster)
{
    const svo_i_gl_functions *gl = raster->gl;
    SVO_I_TRY(svo_i_gl_context_make_current(raster->context, &raster->device->message));
    svo_i_gl_clear_errors(gl);
    gl->GenVertexArrays(1, &raster->vertex_array);
    gl->GenFramebuffers(1, &raster->framebuffer);
    gl->GenBuffers(4, raster->buffers);
    const svo_status status = check(raster, "creating objects");
    svo_i_gl_context_release_current(raster->context);
    return status;
}

svo_status svo_i_raster_create(svo_device *device, svo_gl_context *context, svo_i_conservative conservative,
                               bool no_int64, svo_i_raster **out)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(context);
    svo_status status = SVO_OK;
    SVO_I_TRY(check_limits(device, gl));
    svo_i_raster *raster = svo_i_alloc_zeroed(&device->memory, 1, sizeof *raster);
    if (raster == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "svo_gl_create: no memory for the front end");
    }
    raster->device = device;
    raster->context = context;
    raster->gl = gl;
    raster->conservative = conservative;
    raster->int64 = !no_int64 && svo_i_gl_has_extension(gl, "GL_ARB_gpu_shader_int64");
    SVO_I_TRY_CLEANUP(create_objects(raster));
    *out = raster;
    return SVO_OK;
cleanup:
    svo_i_raster_destroy(&raster);
    return status;
}

void svo_i_raster_destroy(svo_i_raster **raster)
{
    svo_i_raster *r = *raster;
    if (r == NULL) {
        return;
    }
    if (svo_i_gl_context_make_current_to_delete(r->context)) {
        for (unsigned i = 0; i < SVO_I_CLASS_COUNT * 4u; ++i) {
            r->gl->DeleteProgram(r->programs[i / 4][i / 2 % 2][i % 2].name);
        }
        r->gl->DeleteVertexArrays(1, &r->vertex_array);
        r->gl->DeleteFramebuffers(1, &r->framebuffer);
        r->gl->DeleteBuffers(4, r->buffers);
        svo_i_gl_context_release_current(r->context);
    }
    svo_i_free(r);
    *raster = NULL;
}

static const char *reach_of(svo_i_conservative conservative)
{
    return conservative == SVO_I_CONSERVATIVE_EXPAND ? "#define SVO_REACH 0.5625\n" : "#define SVO_REACH 0.0625\n";
}

static svo_status compile_shader(svo_i_raster *raster, GLenum stage, svo_i_class class_id, variant v, GLuint *out)
{
    static const char *const class_defines[SVO_I_CLASS_COUNT] = {"#define SVO_POINT\n", "#define SVO_NARROW\n", "",
                                                                 "#define SVO_WIDE\n"};
    const bool is_vertex = stage == GL_VERTEX_SHADER;
    const svo_i_shader_maker maker = {raster->device, raster->gl, FUNCTION,
                                      is_vertex ? "the vertex shader" : "the fragment shader"};
    const char *sources[] = {
        "#version 430 core\n",
        raster->int64 ? "#extension GL_ARB_gpu_shader_int64 : require\n#define SVO_INT64\n" : "",
        class_defines[class_id],
        v.code48 ? "#define SVO_CODE48\n" : "",
        v.thin ? "#define SVO_THIN\n" : "",
        reach_of(raster->conservative),
        svo_i_source_raster_common,
        is_vertex ? svo_i_source_raster_vertex : svo_i_source_raster_fragment,
    };
    return svo_i_shader_compile(&maker, stage, sources, sizeof sources / sizeof sources[0], out);
}

static svo_status link_program(svo_i_raster *raster, const GLuint shaders[2], raster_program *program)
{
    const svo_i_gl_functions *gl = raster->gl;
    const svo_i_shader_maker maker = {raster->device, gl, FUNCTION, "the shaders"};
    SVO_I_TRY(svo_i_shader_link(&maker, shaders, 2, &program->name));
    const GLuint name = program->name;
    program->depth = gl->GetUniformLocation(name, "depth");
    program->voxel_log2 = gl->GetUniformLocation(name, "voxel_log2");
    program->open = gl->GetUniformLocation(name, "open");
    program->view_origin = gl->GetUniformLocation(name, "view_origin");
    program->view_log2 = gl->GetUniformLocation(name, "view_log2");
    program->first_item = gl->GetUniformLocation(name, "first_item");
    program->chunk = gl->GetUniformLocation(name, "chunk");
    program->capacity = gl->GetUniformLocation(name, "capacity");
    return SVO_OK;
}

/* Drivers compile a shader at its first draw: draws one item of zeros, of which nothing is rasterized. */
static svo_status warm_program(svo_i_raster *raster, const raster_program *program)
{
    static const unsigned char zeros[256] = {0};
    const svo_i_gl_functions *gl = raster->gl;
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, raster->buffers[BINDING_VERTICES]);
    gl->BufferData(GL_SHADER_STORAGE_BUFFER, sizeof zeros, zeros, GL_STATIC_DRAW);
    for (GLuint binding = 0; binding <= SVO_I_RASTER_FRAGMENTS; ++binding) {
        gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, raster->buffers[BINDING_VERTICES]);
    }
    gl->UseProgram(program->name);
    gl->Uniform1i(program->depth, 1);
    gl->Uniform1i(program->view_log2, 1);
    gl->Uniform1ui(program->first_item, 0);
    gl->ScissorIndexed(0, 0, 0, 0, 0);
    gl->DrawArrays(program->points ? GL_POINTS : GL_TRIANGLES, 0, program->points ? 1 : 3);
    gl->Finish();
    return check(raster, "drawing nothing");
}

static svo_status build_program(svo_i_raster *raster, svo_i_class class_id, variant v, raster_program *program)
{
    svo_status status = SVO_OK;
    GLuint shaders[2] = {0, 0}; /* vertex, fragment */
    SVO_I_TRY_CLEANUP(compile_shader(raster, GL_VERTEX_SHADER, class_id, v, &shaders[0]));
    SVO_I_TRY_CLEANUP(compile_shader(raster, GL_FRAGMENT_SHADER, class_id, v, &shaders[1]));
    SVO_I_TRY_CLEANUP(link_program(raster, shaders, program));
    program->points = class_id == SVO_I_CLASS_POINT;
    SVO_I_TRY_CLEANUP(warm_program(raster, program));
cleanup:
    raster->gl->DeleteShader(shaders[0]);
    raster->gl->DeleteShader(shaders[1]);
    if (status != SVO_OK && program->name != 0) {
        raster->gl->DeleteProgram(program->name);
        *program = (raster_program){0};
    }
    return status;
}

static svo_status compile_program(svo_i_raster *raster, svo_i_class class_id, variant v, raster_program *program)
{
    const double start_ms = svo_i_now_ms();
    const svo_status status = build_program(raster, class_id, v, program);
    raster->device->compile_ms += svo_i_now_ms() - start_ms;
    return status;
}

static GLuint view_log2_of(const svo_plan *plan)
{
    return plan->info.depth < SVO_I_VIEW_LOG2 ? plan->info.depth : SVO_I_VIEW_LOG2;
}

/* All state but the storage blocks: one viewport over the grid or a part of it, a framebuffer without attachments. */
static svo_status set_state(svo_i_raster *raster, const svo_plan *plan)
{
    const svo_i_gl_functions *gl = raster->gl;
    const GLint pixels = 1 << view_log2_of(plan);
    if (pixels > gl->limits.framebuffer_width || pixels > gl->limits.framebuffer_height ||
        pixels > gl->limits.viewport_width || pixels > gl->limits.viewport_height) {
        return svo_i_device_fail(raster->device, SVO_UNSUPPORTED,
                                 "%s: depth %u needs %d x %d pixels, above the %d x %d of %s", FUNCTION,
                                 plan->info.depth, pixels, pixels, gl->limits.framebuffer_width,
                                 gl->limits.framebuffer_height, gl->renderer);
    }
    svo_i_gl_state_set_plain(gl);
    gl->BindFramebuffer(GL_FRAMEBUFFER, raster->framebuffer);
    gl->FramebufferParameteri(GL_FRAMEBUFFER, GL_FRAMEBUFFER_DEFAULT_WIDTH, pixels);
    gl->FramebufferParameteri(GL_FRAMEBUFFER, GL_FRAMEBUFFER_DEFAULT_HEIGHT, pixels);
    gl->FramebufferParameteri(GL_FRAMEBUFFER, GL_FRAMEBUFFER_DEFAULT_SAMPLES, 0);
    gl->ViewportIndexedf(0, 0.0f, 0.0f, (GLfloat)pixels, (GLfloat)pixels);
    gl->BindVertexArray(raster->vertex_array);
    const GLenum completeness = gl->CheckFramebufferStatus(GL_FRAMEBUFFER);
    SVO_I_TRY(check(raster, "setting up the framebuffer"));
    if (completeness != GL_FRAMEBUFFER_COMPLETE) {
        return svo_i_device_fail(raster->device, SVO_GL_ERROR,
                                 "%s: a framebuffer of %d x %d pixels without attachments is not complete", FUNCTION,
                                 pixels, pixels);
    }
    return SVO_OK;
}

svo_status svo_i_raster_prepare(svo_i_raster *raster, const svo_plan *plan)
{
    const variant v = variant_of(plan);
    svo_i_gl_clear_errors(raster->gl);
    SVO_I_TRY(set_state(raster, plan));
    for (svo_i_class class_id = 0; class_id < SVO_I_CLASS_COUNT; ++class_id) {
        raster_program *program = &raster->programs[class_id][v.code48][v.thin];
        if (plan->class_begin[class_id] == plan->class_begin[class_id + 1] || program->name != 0) {
            continue;
        }
        SVO_I_TRY(compile_program(raster, class_id, v, program));
    }
    return SVO_OK;
}

/* Fills one storage block. */
static svo_status upload_block(svo_i_raster *raster, GLuint binding, const char *name, const void *data, uint64_t bytes)
{
    const svo_i_gl_functions *gl = raster->gl;
    if (bytes > (uint64_t)gl->limits.storage_block_bytes) {
        return svo_i_device_fail(raster->device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "%s: %s need %llu bytes, above the storage block limit of %lld of %s", FUNCTION, name,
                                 (unsigned long long)bytes, (long long)gl->limits.storage_block_bytes, gl->renderer);
    }
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, raster->buffers[binding]);
    gl->BufferData(GL_SHADER_STORAGE_BUFFER, bytes > 0 ? (GLsizeiptr)bytes : 4, bytes > 0 ? data : NULL,
                   GL_STATIC_DRAW);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, raster->buffers[binding]);
    return check(raster, name);
}

/* The counters of each chunk, all zero. */
static svo_status upload_counters(svo_i_raster *raster, uint32_t chunk_count)
{
    svo_i_raster_count *zeros = svo_i_alloc_zeroed(&raster->device->memory, chunk_count + 1u, sizeof *zeros);
    if (zeros == NULL) {
        return svo_i_device_fail(raster->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u counters", FUNCTION,
                                 chunk_count);
    }
    const svo_status status =
        upload_block(raster, BINDING_COUNTERS, "counters", zeros, (chunk_count + 1u) * sizeof *zeros);
    svo_i_free(zeros);
    return status;
}

svo_status svo_i_raster_upload(svo_i_raster *raster, const svo_plan *plan, const svo_draw_item *items,
                               uint32_t item_count, uint32_t chunk_count)
{
    const uint64_t triangles = plan->triangle_count;
    const uint64_t vertices = plan->vertex_count;
    svo_i_gl_clear_errors(raster->gl);
    SVO_I_TRY(upload_block(raster, BINDING_VERTICES, "vertices", plan->vertices, vertices * 12));
    SVO_I_TRY(upload_block(raster, BINDING_INDICES, "indices", plan->indices, triangles * 12));
    SVO_I_TRY(upload_block(raster, BINDING_ITEMS, "items", items, item_count * sizeof *items));
    SVO_I_TRY(upload_counters(raster, chunk_count));
    return set_state(raster, plan);
}

/* Triangles alone are drawn conservatively. A point is one pixel: GL_INTEL_conservative_rasterization refuses to draw
   points in its mode, and GL_NV_conservative_raster gives them the pixels around theirs as well. */
static void set_conservative(const svo_i_raster *raster, bool on, bool *is_on)
{
    const svo_i_gl_functions *gl = raster->gl;
    if (raster->conservative == SVO_I_CONSERVATIVE_EXPAND || on == *is_on) {
        return;
    }
    *is_on = on;
    const GLenum capability = raster->conservative == SVO_I_CONSERVATIVE_NV ? GL_CONSERVATIVE_RASTERIZATION_NV
                                                                            : GL_CONSERVATIVE_RASTERIZATION_INTEL;
    if (!on) {
        gl->Disable(capability);
        return;
    }
    gl->Enable(capability);
    if (raster->conservative == SVO_I_CONSERVATIVE_NV) {
        gl->ConservativeRasterParameteriNV(GL_CONSERVATIVE_RASTER_MODE_NV,
                                           GL_CONSERVATIVE_RASTER_MODE_PRE_SNAP_TRIANGLES_NV);
    }
}

/* The most items of one draw call: vertex numbers must stay below 2^31. */
#define ITEMS_PER_CALL (1u << 28)

static const raster_program *program_of(const svo_i_raster *raster, const svo_plan *plan, svo_i_class class_id)
{
    const variant v = variant_of(plan);
    return &raster->programs[class_id][v.code48][v.thin];
}

static void draw_items(const svo_i_raster *raster, const svo_plan *plan, const svo_i_draw *draw)
{
    const svo_i_gl_functions *gl = raster->gl;
    const raster_program *program = program_of(raster, plan, draw->class_id);
    for (uint32_t done = 0; done < draw->item_count; done += ITEMS_PER_CALL) {
        const uint32_t left = draw->item_count - done;
        const GLsizei items = (GLsizei)(left < ITEMS_PER_CALL ? left : ITEMS_PER_CALL);
        gl->Uniform1ui(program->first_item, draw->first_item + done);
        gl->DrawArrays(program->points ? GL_POINTS : GL_TRIANGLES, 0, program->points ? items : items * 3);
    }
}

svo_status svo_i_raster_draw(svo_i_raster *raster, const svo_plan *plan, const svo_i_chunking *layout, uint32_t chunk)
{
    const svo_i_gl_functions *gl = raster->gl;
    const svo_i_chunk *target = &layout->chunks[chunk];
    const GLuint view_log2 = view_log2_of(plan);
    bool is_conservative = false;
    for (uint32_t i = 0; i < target->draw_count; ++i) {
        const svo_i_draw *draw = &layout->draws[target->first_draw + i];
        const raster_program *program = program_of(raster, plan, draw->class_id);
        set_conservative(raster, !program->points, &is_conservative);
        gl->UseProgram(program->name);
        gl->Uniform1i(program->depth, (GLint)plan->info.depth);
        gl->Uniform1i(program->voxel_log2, (GLint)plan->voxel_log2);
        const GLint view_x = (GLint)(draw->tile_x >> view_log2 << view_log2);
        const GLint view_y = (GLint)(draw->tile_y >> view_log2 << view_log2);
        gl->Uniform1i(program->open, plan->info.coverage == SVO_COVERAGE_CLOSED ? 0 : 1);
        gl->Uniform1i(program->view_log2, (GLint)view_log2);
        gl->Uniform2i(program->view_origin, view_x, view_y);
        gl->Uniform1ui(program->chunk, chunk);
        gl->Uniform1ui(program->capacity, (GLuint)target->capacity);
        gl->ScissorIndexed(0, (GLint)draw->tile_x - view_x, (GLint)draw->tile_y - view_y, (GLsizei)draw->tile_width,
                           (GLsizei)draw->tile_height);
        draw_items(raster, plan, draw);
    }
    set_conservative(raster, false, &is_conservative);
    return check(raster, "drawing");
}

svo_status svo_i_raster_finish(svo_i_raster *raster, uint32_t chunk_count, svo_i_raster_count *counts)
{
    const svo_i_gl_functions *gl = raster->gl;
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT | GL_CLIENT_MAPPED_BUFFER_BARRIER_BIT);
    gl->Finish();
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, raster->buffers[BINDING_COUNTERS]);
    gl->GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, (GLsizeiptr)(chunk_count * sizeof *counts), counts);
    return check(raster, "reading the counters");
}

void svo_i_raster_drop(svo_i_raster *raster)
{
    for (unsigned i = 0; i < 4; ++i) {
        raster->gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, raster->buffers[i]);
        raster->gl->BufferData(GL_SHADER_STORAGE_BUFFER, 4, NULL, GL_STATIC_DRAW);
    }
}
