/* SPDX-License-Identifier: MIT */
/*
 * Uploads the mesh's attributes to storage blocks, for the stages that compute payload (material.c, filter.c);
 * shaders/attribute.glsl reads them. Uploads only what the plan has. All vertex attributes share one block, since a
 * shader may have few.
 */
#include "compute/surface.h"

#include "compute/buffer.h"
#include "core/message.h"

/* Uploads an array if the plan has it. data: NULL allowed. */
static svo_status upload(svo_i_gl_build *gl_build, const char *name, const void *data, uint64_t bytes, GLuint *out)
{
    return data != NULL ? svo_i_compute_upload(gl_build->compute, name, data, bytes, out) : SVO_OK;
}

/* Appends an attribute at *end, and advances *end. */
static void put_attribute(svo_i_gl_build *gl_build, const void *data, uint64_t bytes, uint64_t *end)
{
    const svo_i_gl_functions *gl = gl_build->compute->gl;
    if (data != NULL && bytes > 0) {
        gl->BufferSubData(GL_COPY_READ_BUFFER, (GLintptr)*end, (GLsizeiptr)bytes, data);
        *end += bytes;
    }
}

/* Colors, then normals, then texture coordinates. */
static svo_status upload_attributes(svo_i_gl_build *gl_build, GLuint *out)
{
    const svo_plan *plan = gl_build->build->commands.plan;
    const uint64_t vertices = plan->vertex_count;
    const uint64_t bytes = vertices * ((plan->colors != NULL ? 4u : 0u) + (plan->normals != NULL ? 8u : 0u) +
                                       (plan->uvs != NULL ? 8u : 0u));
    if (bytes == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_compute_alloc(gl_build->compute, "vertex_attributes", bytes, out));
    uint64_t end = 0;
    gl_build->compute->gl->BindBuffer(GL_COPY_READ_BUFFER, *out);
    put_attribute(gl_build, plan->colors, vertices * 4, &end);
    put_attribute(gl_build, plan->normals, vertices * 8, &end);
    put_attribute(gl_build, plan->uvs, vertices * 8, &end);
    gl_build->compute->gl->BindBuffer(GL_COPY_READ_BUFFER, 0);
    return SVO_OK;
}

/* The arrays that locate a triangle in a voxel. Uniform weights alone do not need vertices. */
static svo_status upload_triangles(svo_i_gl_build *gl_build, svo_i_gl_surface *out)
{
    const svo_plan *plan = gl_build->build->commands.plan;
    const uint64_t triangles = plan->triangle_count;
    const uint64_t vertices = plan->vertex_count;
    if (plan->work.positions) {
        SVO_I_TRY(upload(gl_build, "vertices", plan->vertices, vertices * 12, &out->vertices));
    }
    SVO_I_TRY(upload(gl_build, "indices", plan->indices, triangles * 12, &out->indices));
    return upload(gl_build, "records", plan->records, triangles * sizeof(svo_triangle_record), &out->records);
}

svo_status svo_i_gl_surface_upload(svo_i_gl_build *gl_build, svo_i_gl_surface *out)
{
    const svo_plan *plan = gl_build->build->commands.plan;
    svo_i_compute_stage_begin(gl_build->compute);
    const uint64_t material_bytes = plan->material_count * sizeof(svo_material_record);
    SVO_I_TRY(upload_triangles(gl_build, out));
    SVO_I_TRY(upload_attributes(gl_build, &out->attributes));
    SVO_I_TRY(upload(gl_build, "material_records", plan->materials, material_bytes, &out->materials));
    SVO_I_TRY(upload(gl_build, "texels", plan->texels, plan->texel_count * 4, &out->texels));
    return svo_i_compute_stage_end(gl_build->compute, gl_build->build, SVO_STAGE_TRANSFER);
}

void svo_i_gl_surface_free(svo_i_gl_build *gl_build, svo_i_gl_surface *surface)
{
    GLuint *buffers[] = {&surface->vertices,   &surface->indices,   &surface->records,
                         &surface->attributes, &surface->materials, &surface->texels};
    for (unsigned i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        svo_i_compute_free(gl_build->compute, buffers[i]);
    }
}
