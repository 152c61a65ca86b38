/* SPDX-License-Identifier: MIT */
/*
 * Uploads the attributes that the plan has, for material.c and filter.c. Vertices and indices are those of the snapped
 * mesh, which the tree may have taken for rays.
 */
#include "stages/surface.h"

#include "plan/arrays.h"
#include "stages/snapped_mesh.h"

/* Uploads an array if the plan has it, on the host or on the device. */
static svo_status upload(svo_i_build *build, const char *name, const void *host, cl_mem memory, uint64_t bytes,
                         cl_mem *out)
{
    return svo_i_plan_has(host, memory) ? svo_i_commands_take(&build->commands, name, host, memory, bytes, out)
                                        : SVO_OK;
}

/* Uniform weights alone need no vertices: they do not depend on where in its voxel a triangle is. */
static svo_status get_geometry(svo_i_build *build, svo_i_surface *out)
{
    if (build->tree->buffers[SVO_TREE_VERTICES] != NULL) {
        out->vertices = build->tree->buffers[SVO_TREE_VERTICES];
        out->indices = build->tree->buffers[SVO_TREE_INDICES];
        return SVO_OK;
    }
    SVO_I_TRY(build->commands.plan->work.positions ? svo_i_snapped_vertices(&build->commands, &out->vertices) : SVO_OK);
    return svo_i_snapped_indices(&build->commands, &out->indices);
}

svo_status svo_i_surface_upload(svo_i_build *build)
{
    svo_i_surface *out = &build->surface;
    const svo_plan *plan = build->commands.plan;
    const uint64_t vertices = plan->vertex_count;
    svo_i_stage_begin(&build->commands);
    SVO_I_TRY(get_geometry(build, out));
    SVO_I_TRY(upload(build, "records", plan->records, plan->memory.records,
                     (uint64_t)plan->triangle_count * sizeof(svo_triangle_record), &out->records));
    SVO_I_TRY(upload(build, "vertex_colors", plan->colors, plan->memory.colors, vertices * 4, &out->colors));
    SVO_I_TRY(upload(build, "vertex_normals", plan->normals, plan->memory.normals, vertices * 8, &out->normals));
    SVO_I_TRY(upload(build, "uvs", plan->uvs, plan->memory.uvs, vertices * 8, &out->uvs));
    SVO_I_TRY(upload(build, "material_records", plan->materials, NULL,
                     plan->material_count * sizeof(svo_material_record), &out->materials));
    SVO_I_TRY(upload(build, "texels", plan->texels, NULL, plan->texel_count * 4, &out->texels));
    return svo_i_stage_end(&build->commands, SVO_STAGE_TRANSFER);
}

void svo_i_surface_free(svo_i_build *build)
{
    svo_i_surface *surface = &build->surface;
    cl_mem *buffers[] = {&surface->records, &surface->colors,    &surface->normals,
                         &surface->uvs,     &surface->materials, &surface->texels};
    for (unsigned i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        svo_i_commands_free(&build->commands, buffers[i]);
    }
    svo_i_snapped_mesh_free(&build->commands);
    *surface = (svo_i_surface){0};
}
