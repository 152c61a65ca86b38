/* SPDX-License-Identifier: MIT */
/* Draws a source's view, in place of the rays of lib/light/photons.c: shaders/light_view.vert and .frag. */
#include "raster/light_view.h"

#include "context/functions.h"
#include "context/state.h"
#include "core/message.h"
#include "svocl/nodes.h"

#define FUNCTION "svo_gl_light_set_sources"
/* Steps of light_view.frag. */
#define STEPS 3

/* Storage blocks, by binding. */
enum { VERTICES = 0, INDICES, VIEW, TRIANGLE_IDS, WEIGHTS, NEAREST, BLOCK_COUNT, HITS = BLOCK_COUNT };

/* Made by cmake/embed.cmake. */
extern const char svo_i_source_light_view_common[];
extern const char svo_i_source_light_view_vertex[];
extern const char svo_i_source_light_view_fragment[];

/* The block View of light_view.glsl. */
typedef struct view_block {
    float base[4], right[4], up[4], forward[4], axis[4];
    uint32_t view[4], band[4];
} view_block;

struct svo_i_light_raster {
    svo_device *device;
    svo_gl_context *context;
    const svo_i_gl_functions *gl;
    svo_gl_share share;
    GLuint program, vertex_array, framebuffer;
    GLint step_number;
    GLuint blocks[BLOCK_COUNT];

    /* Between begin and end. */
    const svo_tree *tree;
    svo_grid grid;
    bool uploaded; /* the triangles */
    svo_i_share_buffer hits; /* of a band; all zero: not made */
};

static svo_status check(const svo_i_light_raster *raster, const char *step)
{
    return svo_i_gl_check(raster->gl, FUNCTION, step, &raster->device->message);
}

/* ---- the program ---- */

static svo_status compile_shader(svo_i_light_raster *raster, GLenum stage, GLuint *out)
{
    const bool is_vertex = stage == GL_VERTEX_SHADER;
    const svo_i_shader_maker maker = {raster->device, raster->gl, FUNCTION,
                                      is_vertex ? "the vertex shader" : "the fragment shader"};
    const char *sources[] = {"#version 430 core\n", svo_i_source_light_view_common,
                             is_vertex ? svo_i_source_light_view_vertex : svo_i_source_light_view_fragment};
    return svo_i_shader_compile(&maker, stage, sources, sizeof sources / sizeof sources[0], out);
}

static svo_status build_program(svo_i_light_raster *raster)
{
    const svo_i_shader_maker maker = {raster->device, raster->gl, FUNCTION, "the shaders"};
    svo_status status = SVO_OK;
    GLuint shaders[2] = {0, 0}; /* vertex, fragment */
    SVO_I_TRY_CLEANUP(compile_shader(raster, GL_VERTEX_SHADER, &shaders[0]));
    SVO_I_TRY_CLEANUP(compile_shader(raster, GL_FRAGMENT_SHADER, &shaders[1]));
    SVO_I_TRY_CLEANUP(svo_i_shader_link(&maker, shaders, 2, &raster->program));
    raster->step_number = raster->gl->GetUniformLocation(raster->program, "step_number");
    SVO_I_TRY_CLEANUP(check(raster, "finding the uniform"));
cleanup:
    raster->gl->DeleteShader(shaders[0]);
    raster->gl->DeleteShader(shaders[1]);
    return status;
}

static svo_status create_objects(svo_i_light_raster *raster)
{
    const svo_i_gl_functions *gl = raster->gl;
    svo_i_gl_clear_errors(gl);
    gl->GenVertexArrays(1, &raster->vertex_array);
    gl->GenFramebuffers(1, &raster->framebuffer);
    gl->GenBuffers(BLOCK_COUNT, raster->blocks);
    SVO_I_TRY(check(raster, "creating objects"));
    return build_program(raster);
}

static svo_status check_limits(svo_device *device, const svo_i_gl_functions *gl)
{
    if (gl->limits.vertex_storage_blocks < 3 || gl->limits.fragment_storage_blocks < 5) {
        return svo_i_device_fail(device, SVO_UNSUPPORTED,
                                 FUNCTION ": %s has %d storage blocks for vertices and %d for fragments, below 3 and 5",
                                 gl->renderer, gl->limits.vertex_storage_blocks, gl->limits.fragment_storage_blocks);
    }
    return SVO_OK;
}

svo_status svo_i_light_raster_create(svo_device *device, svo_gl_context *context, svo_gl_share share,
                                     svo_i_light_raster **out)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(context);
    SVO_I_TRY(check_limits(device, gl));
    svo_i_light_raster *raster = svo_i_alloc_zeroed(&device->memory, 1, sizeof *raster);
    if (raster == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, FUNCTION ": no memory for the rasterizer");
    }
    raster->device = device;
    raster->context = context;
    raster->gl = gl;
    raster->share = share;
    svo_status status = svo_i_gl_context_make_current(context, &device->message);
    if (status == SVO_OK) {
        status = create_objects(raster);
        svo_i_gl_context_release_current(context);
    }
    if (status != SVO_OK) {
        svo_i_light_raster_destroy(&raster);
        return status;
    }
    *out = raster;
    return SVO_OK;
}

void svo_i_light_raster_destroy(svo_i_light_raster **raster)
{
    svo_i_light_raster *r = *raster;
    if (r == NULL) {
        return;
    }
    if (svo_i_gl_context_make_current_to_delete(r->context)) {
        r->gl->DeleteProgram(r->program);
        r->gl->DeleteVertexArrays(1, &r->vertex_array);
        r->gl->DeleteFramebuffers(1, &r->framebuffer);
        r->gl->DeleteBuffers(BLOCK_COUNT, r->blocks);
        svo_i_gl_context_release_current(r->context);
    }
    svo_i_free(r);
    *raster = NULL;
}

/* ---- buffers ---- */

/* Fills a storage block. data: NULL: of any content. */
static svo_status upload_block(svo_i_light_raster *raster, GLuint binding, const char *name, const void *data,
                               uint64_t bytes)
{
    const svo_i_gl_functions *gl = raster->gl;
    if (bytes > (uint64_t)gl->limits.storage_block_bytes) {
        return svo_i_device_fail(raster->device, SVO_OUT_OF_DEVICE_MEMORY,
                                 FUNCTION ": %s need %llu bytes, above the storage block limit of %lld of %s", name,
                                 (unsigned long long)bytes, (long long)gl->limits.storage_block_bytes, gl->renderer);
    }
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, raster->blocks[binding]);
    gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)bytes, data, GL_STREAM_DRAW);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, raster->blocks[binding]);
    return check(raster, name);
}

static size_t array_bytes(const svo_i_light_raster *raster, svo_tree_buffer array)
{
    return (size_t)svo_i_tree_element_count(&raster->tree->info, array) * svo_i_tree_element_bytes(array);
}

/* An array of the tree, which the caller frees; *copy stays NULL for one that the tree does not hold. */
static svo_status read_array(const svo_i_light_raster *raster, svo_tree_buffer array, cl_command_queue queue,
                             void **copy)
{
    svo_device *device = raster->device;
    const size_t bytes = array_bytes(raster, array);
    if (!svo_i_tree_holds(&raster->tree->info, array)) {
        return SVO_OK;
    }
    *copy = svo_i_alloc(&device->memory, bytes);
    if (*copy == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, FUNCTION ": no memory for %zu bytes of triangles",
                                 bytes);
    }
    const cl_int error =
        clEnqueueReadBuffer(queue, raster->tree->buffers[array], CL_TRUE, 0, bytes, *copy, 0, NULL, NULL);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(device, FUNCTION, "clEnqueueReadBuffer", error);
}

static svo_status upload_array(svo_i_light_raster *raster, GLuint binding, svo_tree_buffer array,
                               cl_command_queue queue)
{
    void *copy = NULL;
    svo_status status = read_array(raster, array, queue, &copy);
    if (status == SVO_OK) {
        status = upload_block(raster, binding, "triangles", copy, array_bytes(raster, array));
    }
    svo_i_free(copy);
    return status;
}

/* What the vertex shader reads of a vertex. */
typedef struct split_vertex {
    int32_t units[3];
    float rest[3];
} split_vertex;

/* positions, positions_double: of the mesh, or both NULL: the snapped ones stand for them. */
static void split_vertices(const svo_tree_info *info, const int32_t *snapped, const float *positions,
                           const double *positions_double, split_vertex *out)
{
    for (size_t i = 0; i < (size_t)info->vertex_count * 3; ++i) {
        out[i / 3].units[i % 3] = snapped[i];
        out[i / 3].rest[i % 3] = 0.0F;
        if (positions != NULL || positions_double != NULL) {
            const double at = positions != NULL ? (double)positions[i] : positions_double[i];
            out[i / 3].rest[i % 3] = (float)((at - info->origin[i % 3]) * info->scale - (double)snapped[i]);
        }
    }
}

/* The vertices of the mesh that rays meet. Floats in grid units would be too coarse for the edges of small
   triangles. */
static svo_status upload_vertices(svo_i_light_raster *raster, cl_command_queue queue)
{
    const svo_tree_info *info = &raster->tree->info;
    const size_t bytes = (size_t)info->vertex_count * sizeof(split_vertex);
    void *arrays[3] = {NULL};
    svo_status status = SVO_OK;
    split_vertex *vertices = svo_i_alloc(&raster->device->memory, bytes);
    if (vertices == NULL) {
        status = svo_i_device_fail(raster->device, SVO_OUT_OF_HOST_MEMORY,
                                   FUNCTION ": no memory for %zu bytes of vertices", bytes);
        goto cleanup;
    }
    SVO_I_TRY_CLEANUP(read_array(raster, SVO_TREE_VERTICES, queue, &arrays[0]));
    SVO_I_TRY_CLEANUP(read_array(raster, SVO_TREE_POSITIONS, queue, &arrays[1]));
    SVO_I_TRY_CLEANUP(read_array(raster, SVO_TREE_POSITIONS_DOUBLE, queue, &arrays[2]));
    split_vertices(info, arrays[0], arrays[1], arrays[2], vertices);
    status = upload_block(raster, VERTICES, "triangles", vertices, bytes);
cleanup:
    for (int i = 0; i < 3; ++i) {
        svo_i_free(arrays[i]);
    }
    svo_i_free(vertices);
    return status;
}

static svo_status upload_triangles(svo_i_light_raster *raster, cl_command_queue queue)
{
    if (!raster->uploaded) {
        SVO_I_TRY(upload_vertices(raster, queue));
        SVO_I_TRY(upload_array(raster, INDICES, SVO_TREE_INDICES, queue));
        SVO_I_TRY(upload_array(raster, TRIANGLE_IDS, SVO_TREE_TRIANGLE_IDS, queue));
        raster->uploaded = true;
    }
    return SVO_OK;
}

/* Makes all bits of a part of a buffer ones: no distance is larger, and it is no triangle. */
static void fill_with_ones(const svo_i_light_raster *raster, GLuint buffer, size_t offset_bytes, size_t bytes)
{
    static const GLuint ones = UINT32_MAX;
    const svo_i_gl_functions *gl = raster->gl;
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
    gl->ClearBufferSubData(GL_SHADER_STORAGE_BUFFER, GL_R32UI, (GLintptr)offset_bytes, (GLsizeiptr)bytes,
                           GL_RED_INTEGER, GL_UNSIGNED_INT, &ones);
}

/* ---- a view ---- */

/* The part of a view that a band draws, in grid units. */
static void describe_band(const svo_i_light_raster *raster, const svo_light_view_params *view, view_block *out)
{
    const float scale = (float)raster->tree->info.scale;
    const float unit = view->parallel != 0 ? scale : 1.0F;
    const uint32_t tile_log2 = SVO_TILE_PIXELS_LOG2;
    const uint32_t first_tile = view->first >> 2 * tile_log2;
    const uint32_t last_tile = (view->first + view->count - 1) >> 2 * tile_log2;
    const uint32_t first_row = first_tile / view->tile_columns << tile_log2;
    const uint32_t end_row = (last_tile / view->tile_columns + 1) << tile_log2;
    float aside[2] = {0, 0};
    *out = (view_block){.view = {view->columns, view->rows, view->tile_columns, view->first},
                        .band = {first_row, (end_row < view->rows ? end_row : view->rows) - first_row, view->count}};
    for (int axis = 0; axis < 3; ++axis) {
        out->base[axis] = (float)(((double)view->base[axis] - raster->grid.origin[axis]) * raster->tree->info.scale);
        out->right[axis] = view->right[axis];
        out->up[axis] = view->up[axis];
        out->forward[axis] = view->forward[axis];
        aside[0] += view->forward[axis] * view->right[axis];
        aside[1] += view->forward[axis] * view->up[axis];
    }
    for (int axis = 0; axis < 3; ++axis) {
        out->axis[axis] = view->forward[axis] - aside[0] * view->right[axis] - aside[1] * view->up[axis];
    }
    out->base[3] = 1 / scale;
    out->right[3] = view->half_x * unit;
    out->up[3] = view->half_y * unit;
    out->forward[3] = view->parallel != 0 ? 1.0F : 0.0F;
}

/* A framebuffer without attachments, of the band's pixels. */
static svo_status set_state(svo_i_light_raster *raster, const view_block *view)
{
    const svo_i_gl_functions *gl = raster->gl;
    const GLint width = (GLint)view->view[0];
    const GLint height = (GLint)view->band[1];
    if (width > gl->limits.framebuffer_width || height > gl->limits.framebuffer_height ||
        width > gl->limits.viewport_width || height > gl->limits.viewport_height) {
        return svo_i_device_fail(raster->device, SVO_UNSUPPORTED,
                                 FUNCTION ": a light's view needs %d x %d pixels, above the %d x %d of %s", width,
                                 height, gl->limits.framebuffer_width, gl->limits.framebuffer_height, gl->renderer);
    }
    svo_i_gl_state_set_plain(gl);
    gl->BindFramebuffer(GL_FRAMEBUFFER, raster->framebuffer);
    gl->FramebufferParameteri(GL_FRAMEBUFFER, GL_FRAMEBUFFER_DEFAULT_WIDTH, width);
    gl->FramebufferParameteri(GL_FRAMEBUFFER, GL_FRAMEBUFFER_DEFAULT_HEIGHT, height);
    gl->FramebufferParameteri(GL_FRAMEBUFFER, GL_FRAMEBUFFER_DEFAULT_SAMPLES, 0);
    gl->ViewportIndexedf(0, 0.0F, 0.0F, (GLfloat)width, (GLfloat)height);
    gl->ScissorIndexed(0, 0, 0, width, height);
    gl->BindVertexArray(raster->vertex_array);
    gl->UseProgram(raster->program);
    return check(raster, "setting up the framebuffer");
}

static svo_status draw_band(svo_i_light_raster *raster, const svo_light_view_params *view,
                            const svo_photon_weight *weights)
{
    const svo_i_gl_functions *gl = raster->gl;
    const GLsizei corners = (GLsizei)(3 * raster->tree->info.list_triangle_count); /* their block limits them */
    const size_t nearest_bytes = (size_t)view->count * 2 * sizeof(GLuint);
    view_block block;
    describe_band(raster, view, &block);
    SVO_I_TRY(upload_block(raster, VIEW, "the view", &block, sizeof block));
    SVO_I_TRY(upload_block(raster, WEIGHTS, "weights", weights, view->count * sizeof *weights));
    SVO_I_TRY(upload_block(raster, NEAREST, "distances", NULL, nearest_bytes));
    fill_with_ones(raster, raster->blocks[NEAREST], 0, nearest_bytes);
    fill_with_ones(raster, raster->hits.name, raster->hits.offset_bytes, raster->hits.bytes);
    svo_i_share_buffer_bind(&raster->hits, HITS);
    SVO_I_TRY(set_state(raster, &block));
    for (GLint step = 0; step < STEPS; ++step) {
        gl->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
        gl->Uniform1i(raster->step_number, step);
        gl->DrawArrays(GL_TRIANGLES, 0, corners);
    }
    return check(raster, "drawing");
}

static svo_status draw(void *self, const svo_light_view_params *view, const svo_photon_weight *weights,
                       cl_command_queue queue, cl_mem hits)
{
    svo_i_light_raster *raster = self;
    const size_t bytes = view->count * sizeof(svo_hit);
    svo_i_gl_clear_errors(raster->gl);
    if (raster->hits.bytes < bytes) {
        svo_i_share_buffer_destroy(&raster->hits);
        SVO_I_TRY(svo_i_share_buffer_create(raster->device, raster->context, raster->share, bytes, &raster->hits));
    }
    SVO_I_TRY(upload_triangles(raster, queue));
    SVO_I_TRY(svo_i_share_buffer_to_gl(&raster->hits, queue));
    SVO_I_TRY(draw_band(raster, view, weights));
    SVO_I_TRY(svo_i_share_buffer_to_cl(&raster->hits, bytes, queue));
    cl_int error = clEnqueueCopyBuffer(queue, raster->hits.memory, hits, 0, 0, bytes, 0, NULL, NULL);
    if (error == CL_SUCCESS) {
        error = clFinish(queue);
    }
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(raster->device, FUNCTION, "clEnqueueCopyBuffer", error);
}

svo_i_photon_caster svo_i_light_raster_begin(svo_i_light_raster *raster, const svo_tree *tree)
{
    raster->tree = tree;
    (void)svo_tree_get_grid(tree, &raster->grid);
    return (svo_i_photon_caster){.self = raster, .cast = draw};
}

void svo_i_light_raster_end(svo_i_light_raster *raster)
{
    for (GLuint i = 0; i < BLOCK_COUNT; ++i) {
        raster->gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, raster->blocks[i]);
        raster->gl->BufferData(GL_SHADER_STORAGE_BUFFER, 4, NULL, GL_STATIC_DRAW);
    }
    svo_i_share_buffer_destroy(&raster->hits);
    raster->uploaded = false;
    raster->tree = NULL;
}
