/* SPDX-License-Identifier: MIT */
/*
 * The mesh's attributes in storage blocks, for the stages that compute payload; shaders/attribute.glsl reads them.
 * Uploads only what the plan has. All vertex attributes share one block, since a shader may have few.
 *
 * A mesh that exceeds storage blocks is uploaded in parts of consecutive triangles, each with three vertices for each
 * of its triangles. Stages that add the contributions of fragments launch once for each part.
 */
#include "compute/surface.h"

#include <string.h>

#include "core/message.h"

/* Texels of a block: a power of two, for svo_texel of the shaders. */
static uint32_t texel_block_log2(const svo_i_compute *compute)
{
    const uint64_t most = svo_i_compute_range_max(compute) / 4;
    uint32_t log2 = 0;
    while (log2 < 31 && UINT64_C(2) << log2 <= most) {
        ++log2;
    }
    return log2;
}

uint64_t svo_i_gl_texels_max(const svo_i_compute *compute)
{
    return (uint64_t)SVO_I_TEXEL_BLOCKS << texel_block_log2(compute);
}

/* Where an attribute of a part's vertices comes from. */
typedef struct vertex_source {
    const svo_plan *plan;
    const uint32_t *corners; /* NULL: all vertices in their order, else those of the part's triangles */
    uint64_t count;
} vertex_source;

/* Appends an attribute at *end of the bound buffer, and advances *end. data: NULL allowed. */
static svo_status put_attribute(svo_i_gl_build *gl_build, const vertex_source *source, const void *data, size_t bytes,
                                uint64_t *end)
{
    const svo_i_gl_functions *gl = gl_build->compute->gl;
    char *gathered = NULL;
    if (data == NULL || source->count == 0) {
        return SVO_OK;
    }
    if (source->corners != NULL) {
        gathered = svo_i_alloc(&gl_build->compute->device->memory, source->count * bytes);
        if (gathered == NULL) {
            return svo_i_device_fail(gl_build->compute->device, SVO_OUT_OF_HOST_MEMORY,
                                     SVO_I_GL_BUILD ": no memory for %llu vertices", (unsigned long long)source->count);
        }
        for (uint64_t i = 0; i < source->count; ++i) {
            memcpy(gathered + i * bytes, (const char *)data + source->corners[i] * bytes, bytes);
        }
        data = gathered;
    }
    gl->BufferSubData(GL_COPY_READ_BUFFER, (GLintptr)*end, (GLsizeiptr)(source->count * bytes), data);
    *end += source->count * bytes;
    svo_i_free(gathered);
    return SVO_OK;
}

/* Colors, then normals, then texture coordinates. */
static svo_status put_attributes(svo_i_gl_build *gl_build, const vertex_source *source)
{
    const svo_plan *plan = source->plan;
    uint64_t end = 0;
    SVO_I_TRY(put_attribute(gl_build, source, plan->colors, 4, &end));
    SVO_I_TRY(put_attribute(gl_build, source, plan->normals, 8, &end));
    return put_attribute(gl_build, source, plan->uvs, 8, &end);
}

/* All vertices, then their remainders. */
static svo_status put_vertices(svo_i_gl_build *gl_build, const vertex_source *source)
{
    uint64_t end = 0;
    SVO_I_TRY(put_attribute(gl_build, source, source->plan->vertices, 12, &end));
    return put_attribute(gl_build, source, source->plan->remainders, 8, &end);
}

/* Creates a block of so many bytes for each vertex, which put fills. */
static svo_status upload_vertices(svo_i_gl_build *gl_build, const vertex_source *source, const char *name,
                                  unsigned vertex_bytes,
                                  svo_status (*put)(svo_i_gl_build *gl_build, const vertex_source *source), GLuint *out)
{
    const svo_i_gl_functions *gl = gl_build->compute->gl;
    if (vertex_bytes == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_compute_alloc(gl_build->compute, name, source->count * vertex_bytes, out));
    gl->BindBuffer(GL_COPY_READ_BUFFER, *out);
    const svo_status status = put(gl_build, source);
    gl->BindBuffer(GL_COPY_READ_BUFFER, 0);
    return status;
}

static unsigned attribute_bytes(const svo_plan *plan)
{
    return (plan->colors != NULL ? 4u : 0u) + (plan->normals != NULL ? 8u : 0u) + (plan->uvs != NULL ? 8u : 0u);
}

/* Uniform weights alone do not need vertices. */
static unsigned vertex_bytes(const svo_plan *plan)
{
    return plan->work.positions ? 20u : 0u;
}

/* Uploads an array if the plan has it. data: NULL allowed. */
static svo_status upload(svo_i_gl_build *gl_build, const char *name, const void *data, uint64_t bytes, GLuint *out)
{
    return data != NULL ? svo_i_compute_upload(gl_build->compute, name, data, bytes, out) : SVO_OK;
}

/* indices: of the part's triangles into its vertices. */
static svo_status upload_part(svo_i_gl_build *gl_build, const vertex_source *source, const uint32_t *indices,
                              svo_i_gl_part *part)
{
    const svo_plan *plan = source->plan;
    const svo_i_launch_mesh *mesh = &part->mesh;
    const svo_triangle_record *records = plan->records != NULL ? plan->records + mesh->first_triangle : NULL;
    const uint64_t record_bytes = mesh->triangle_count * sizeof *records;
    SVO_I_TRY(upload_vertices(gl_build, source, "vertices", vertex_bytes(plan), put_vertices, &part->vertices));
    SVO_I_TRY(upload(gl_build, "indices", indices, mesh->triangle_count * UINT64_C(12), &part->indices));
    SVO_I_TRY(upload(gl_build, "records", records, record_bytes, &part->records));
    return upload_vertices(gl_build, source, "vertex_attributes", attribute_bytes(plan), put_attributes,
                           &part->attributes);
}

/* The whole mesh as one part, with the vertices that it has. */
static svo_status upload_whole(svo_i_gl_build *gl_build, svo_i_gl_part *part)
{
    const svo_plan *plan = gl_build->build->commands.plan;
    const vertex_source source = {.plan = plan, .count = plan->vertex_count};
    part->mesh.vertex_count = plan->vertex_count;
    part->mesh.triangle_count = plan->triangle_count;
    return upload_part(gl_build, &source, plan->indices, part);
}

/* counting: 0, 1, 2 ... for the corners of the largest part. */
static svo_status upload_triangles(svo_i_gl_build *gl_build, uint32_t first, uint32_t count, const uint32_t *counting,
                                   svo_i_gl_part *part)
{
    const svo_plan *plan = gl_build->build->commands.plan;
    const vertex_source source = {
        .plan = plan, .corners = plan->indices + (size_t)3 * first, .count = (uint64_t)3 * count};
    part->mesh.vertex_count = 3 * count;
    part->mesh.first_triangle = first;
    part->mesh.triangle_count = count;
    return upload_part(gl_build, &source, counting, part);
}

static svo_status upload_each(svo_i_gl_build *gl_build, uint32_t part_triangles, const uint32_t *counting,
                              svo_i_gl_surface *out)
{
    const uint32_t triangles = gl_build->build->commands.plan->triangle_count;
    for (uint32_t i = 0; i < out->part_count; ++i) {
        const uint32_t first = i * part_triangles;
        const uint32_t count = triangles - first < part_triangles ? triangles - first : part_triangles;
        SVO_I_TRY(upload_triangles(gl_build, first, count, counting, &out->parts[i]));
    }
    return SVO_OK;
}

static svo_status upload_parts(svo_i_gl_build *gl_build, uint32_t part_triangles, svo_i_gl_surface *out)
{
    svo_device *device = gl_build->compute->device;
    uint32_t *counting = svo_i_alloc(&device->memory, (size_t)part_triangles * 3 * sizeof *counting);
    if (counting == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, SVO_I_GL_BUILD ": no memory for %u triangles",
                                 part_triangles);
    }
    for (uint32_t i = 0; i < 3 * part_triangles; ++i) {
        counting[i] = i;
    }
    const svo_status status = upload_each(gl_build, part_triangles, counting, out);
    svo_i_free(counting);
    return status;
}

/* Triangles of a part: all of the mesh, or as many as fit storage blocks with three vertices each. */
static uint32_t count_part_triangles(const svo_i_compute *compute, const svo_plan *plan)
{
    const uint64_t most = svo_i_compute_range_max(compute);
    const uint64_t a = vertex_bytes(plan);
    const uint64_t b = attribute_bytes(plan);
    const uint64_t of_vertex = a > b ? a : b;
    const uint64_t of_triangle = 3 * of_vertex > 16 ? 3 * of_vertex : 16;
    const bool whole = plan->vertex_count * of_vertex <= most && plan->triangle_count * UINT64_C(16) <= most;
    return whole ? plan->triangle_count : (uint32_t)(most / of_triangle);
}

static svo_status upload_mesh(svo_i_gl_build *gl_build, svo_i_gl_surface *out)
{
    svo_i_compute *compute = gl_build->compute;
    const svo_plan *plan = gl_build->build->commands.plan;
    const uint32_t part_triangles = count_part_triangles(compute, plan);
    const uint64_t count =
        part_triangles > 0 ? (plan->triangle_count + part_triangles - UINT64_C(1)) / part_triangles : 1;
    out->parts = svo_i_alloc_zeroed(&compute->device->memory, count, sizeof *out->parts);
    if (out->parts == NULL) {
        return svo_i_device_fail(compute->device, SVO_OUT_OF_HOST_MEMORY,
                                 SVO_I_GL_BUILD ": no memory for %llu parts of the mesh", (unsigned long long)count);
    }
    out->part_count = (uint32_t)count;
    return count == 1 ? upload_whole(gl_build, out->parts) : upload_parts(gl_build, part_triangles, out);
}

static svo_status upload_texels(svo_i_gl_build *gl_build, svo_i_gl_surface *out)
{
    const svo_plan *plan = gl_build->build->commands.plan;
    const uint32_t log2 = texel_block_log2(gl_build->compute);
    for (uint64_t begin = 0; plan->texels != NULL && begin < plan->texel_count; begin += UINT64_C(1) << log2) {
        const uint64_t left = plan->texel_count - begin;
        const uint64_t bytes = (left < UINT64_C(1) << log2 ? left : UINT64_C(1) << log2) * 4;
        SVO_I_TRY(upload(gl_build, "texels", plan->texels + begin, bytes, &out->texels[out->texel_blocks]));
        ++out->texel_blocks;
    }
    for (uint32_t i = 0; i < out->part_count; ++i) {
        out->parts[i].mesh.texel_block_log2 = log2;
    }
    return SVO_OK;
}

svo_status svo_i_gl_surface_upload(svo_i_gl_build *gl_build, svo_i_gl_surface *out)
{
    const svo_plan *plan = gl_build->build->commands.plan;
    svo_i_compute_stage_begin(gl_build->compute);
    const uint64_t material_bytes = plan->material_count * sizeof(svo_material_record);
    SVO_I_TRY(upload_mesh(gl_build, out));
    SVO_I_TRY(upload(gl_build, "material_records", plan->materials, material_bytes, &out->materials));
    SVO_I_TRY(upload_texels(gl_build, out));
    return svo_i_compute_stage_end(gl_build->compute, gl_build->build, SVO_STAGE_TRANSFER);
}

void svo_i_gl_surface_free(svo_i_gl_build *gl_build, svo_i_gl_surface *surface)
{
    svo_i_compute *compute = gl_build->compute;
    for (uint32_t i = 0; i < surface->part_count; ++i) {
        svo_i_gl_part *part = &surface->parts[i];
        svo_i_compute_free(compute, &part->vertices);
        svo_i_compute_free(compute, &part->indices);
        svo_i_compute_free(compute, &part->records);
        svo_i_compute_free(compute, &part->attributes);
    }
    for (unsigned i = 0; i < SVO_I_TEXEL_BLOCKS; ++i) {
        svo_i_compute_free(compute, &surface->texels[i]);
    }
    svo_i_compute_free(compute, &surface->materials);
    svo_i_free(surface->parts);
}

svo_status svo_i_gl_launch_fragments(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface,
                                     svo_filter_params params, svo_i_launch launch)
{
    const svo_i_fragment_list *list = &gl_build->build->list;
    launch.params = &params;
    for (uint32_t k = 0; k < surface->part_count; ++k) {
        const svo_i_gl_part *part = &surface->parts[k];
        launch.mesh = part->mesh;
        launch.buffers[2] = part->vertices;
        launch.buffers[3] = part->indices;
        launch.buffers[4] = part->records;
        launch.buffers[5] = part->attributes;
        for (uint32_t i = 0; i < list->chunk_count; ++i) {
            launch.buffers[0] = svo_i_gl_chunk(gl_build, i);
            launch.buffers[1] = gl_build->cursors[i];
            launch.items = params.fragment_count = (cl_uint)list->chunks[i].needed;
            SVO_I_TRY(svo_i_compute_launch(gl_build->compute, &launch));
        }
    }
    return SVO_OK;
}
