/* SPDX-License-Identifier: MIT */
/*
 * Voxels to a tree. A voxel becomes a point at its center: a triangle whose corners are the same vertex, which touches
 * that voxel alone. So the stages of meshes make nodes and payload, with their budget, progress and messages. Weights
 * are uniform: all voxels count the same in the means above them.
 */
#include "voxels/build.h"

#include <math.h>
#include <string.h>

#include "core/device.h"
#include "core/struct_size.h"
#include "core/voxel_list.h"
#include "pipeline/run.h"
#include "plan/plan.h"

static const char function[] = "svo_voxels_plan";

/* The points as a mesh. All arrays are owned. */
typedef struct points {
    float *positions;
    uint32_t *indices;
    uint8_t *colors; /* NULL without SVO_NEED_COLOR */
    uint16_t *materials; /* NULL without SVO_NEED_MATERIAL */
    int16_t *normals; /* x, y, z, 0 each; NULL without SVO_NEED_NORMAL */
    svo_material *table; /* as many white materials as there are numbers */
} points;

svo_status svo_i_voxels_options(svo_device *device, const svo_voxels_info *info, bool has_normals, unsigned *depth,
                                svo_plan_options *options)
{
    const uint32_t payload =
        (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_MATERIAL | (has_normals ? (uint32_t)SVO_NEED_NORMAL : 0u);
    options->need = options->need == SVO_NEED_DEFAULT ? payload : options->need;
    if (options->need != SVO_NEED_NONE && (options->need & ~payload) != 0) {
        return svo_i_device_fail(
            device, SVO_INVALID_ARGUMENT, "%s: options.need 0x%x is not made of %s, or none%s", function, options->need,
            has_normals ? "color, normal and material" : "color and material",
            (options->need & SVO_NEED_NORMAL) != 0 && !has_normals ? "; the voxels have no normals" : "");
    }
    if (options->updatable != 0 && options->need != SVO_NEED_NONE && (options->need & SVO_NEED_NORMAL) != 0) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "%s: options.need has normal, and options.updatable is "
                                 "not 0",
                                 function);
    }
    if (options->coverage != SVO_COVERAGE_HALF_OPEN || options->edge != 0.0) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.%s is not 0", function,
                                 options->edge != 0.0 ? "edge" : "coverage");
    }
    if (info->depth == 0) {
        return svo_i_device_fail(
            device, SVO_INVALID_ARGUMENT, "%s: the voxels span %d x %d x %d, more than 2^%d along an axis", function,
            info->high[0] - info->low[0], info->high[1] - info->low[1], info->high[2] - info->low[2], SVO_DEPTH_MAX);
    }
    *depth = *depth == 0 ? info->depth : *depth;
    if (*depth < info->depth || *depth > SVO_DEPTH_MAX) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: depth %u is not in %u .. %d, or 0", function,
                                 *depth, info->depth, SVO_DEPTH_MAX);
    }
    options->weights = SVO_WEIGHTS_UNIFORM;
    options->edge = ldexp(1.0, (int)*depth);
    memset(options->origin, 0, sizeof options->origin);
    options->fragment_capacity = options->fragment_capacity == 0 ? info->voxel_count : options->fragment_capacity;
    return SVO_OK;
}

static void free_points(points *p)
{
    svo_i_free(p->positions);
    svo_i_free(p->indices);
    svo_i_free(p->colors);
    svo_i_free(p->materials);
    svo_i_free(p->normals);
    svo_i_free(p->table);
}

/* Allocates the arrays, each with room for one element at least. */
static bool allocate_points(const svo_i_memory *memory, const svo_voxels *voxels, uint32_t need, points *p)
{
    const size_t count = (size_t)voxels->info.voxel_count;
    size_t bytes = 0;
    if (!svo_i_mul_size(count + 1, 3 * sizeof *p->positions, &bytes)) {
        return false;
    }
    const bool color = (need & SVO_NEED_COLOR) != 0;
    const bool material = (need & SVO_NEED_MATERIAL) != 0;
    const bool normal = (need & SVO_NEED_NORMAL) != 0;
    p->positions = svo_i_alloc(memory, bytes);
    p->indices = svo_i_alloc(memory, bytes);
    p->colors = color ? svo_i_alloc(memory, (count + 1) * 4) : NULL;
    p->materials = material ? svo_i_alloc(memory, (count + 1) * sizeof *p->materials) : NULL;
    p->normals = normal ? svo_i_alloc(memory, (count + 1) * 4 * sizeof *p->normals) : NULL;
    p->table = material ? svo_i_alloc(memory, (voxels->info.material_count + 1) * sizeof *p->table) : NULL;
    return p->positions != NULL && p->indices != NULL && (p->colors != NULL || !color) &&
           (p->normals != NULL || !normal) && ((p->materials != NULL && p->table != NULL) || !material);
}

/* Positions count voxels from the least corner on: halves below 2^16, which are exact. */
static void fill_points(const svo_voxels *voxels, points *p)
{
    const int32_t *low = voxels->info.low;
    for (size_t i = 0; i < voxels->info.voxel_count; ++i) {
        const svo_voxel *voxel = &voxels->voxels[i];
        p->positions[3 * i] = (float)(voxel->x - low[0]) + 0.5f;
        p->positions[3 * i + 1] = (float)(voxel->y - low[1]) + 0.5f;
        p->positions[3 * i + 2] = (float)(voxel->z - low[2]) + 0.5f;
        for (size_t corner = 0; corner < 3; ++corner) {
            p->indices[3 * i + corner] = (uint32_t)i;
        }
        if (p->colors != NULL) {
            memcpy(p->colors + 4 * i, voxel->rgba, 4);
        }
        if (p->materials != NULL) {
            p->materials[i] = voxel->material;
        }
        if (p->normals != NULL) {
            memcpy(p->normals + 4 * i, voxels->normals + 3 * i, 3 * sizeof *p->normals);
            p->normals[4 * i + 3] = 0;
        }
    }
    for (uint32_t i = 0; i < voxels->info.material_count && p->table != NULL; ++i) {
        p->table[i] = (svo_material){.rgba = {255, 255, 255, 255}, .texture_index = SVO_NO_TEXTURE};
    }
}

svo_status svo_i_voxels_grid(svo_device *device, const svo_voxels_info *list, unsigned depth, svo_i_voxel_grid *out)
{
    out->snap_bits = svo_i_plan_snap_bits(depth);
    out->edge = ldexp(list->voxel_edge, (int)depth);
    out->scale = ldexp(1.0, (int)out->snap_bits) / out->edge;
    bool finite = isfinite(out->edge) && isfinite(out->scale) && out->scale > 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        out->origin[axis] = list->origin[axis] + (double)list->low[axis] * list->voxel_edge + 0.0;
        finite = finite && isfinite(out->origin[axis]);
    }
    return finite ? SVO_OK
                  : svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                      "%s: a grid from %g, %g, %g on with voxels of edge %g is beyond doubles",
                                      function, out->origin[0], out->origin[1], out->origin[2], list->voxel_edge);
}

/* Replaces the grid of the points by that of the voxels. */
static svo_status place_plan(svo_device *device, const svo_voxels *voxels, svo_plan_info *info)
{
    svo_i_voxel_grid grid;
    SVO_I_TRY(svo_i_voxels_grid(device, &voxels->info, info->depth, &grid));
    memcpy(info->origin, grid.origin, sizeof info->origin);
    info->edge = grid.edge;
    info->scale = grid.scale;
    info->triangles = 0;
    return SVO_OK;
}

svo_status svo_voxels_plan(svo_device *device, const svo_voxels *voxels, unsigned depth,
                           const svo_plan_options *options, svo_plan **out)
{
    svo_status status = SVO_OK;
    svo_plan_options asked;
    svo_plan *plan = NULL;
    points p = {.positions = NULL};
    if (device == NULL || voxels == NULL || out == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                 device == NULL ? "device" : (voxels == NULL ? "voxels" : "out"));
    }
    SVO_I_TRY(svo_i_struct_read(svo_i_device_message(device), function, "options", options, &asked,
                                SVO_I_STRUCT_SIZES(svo_plan_options, coverage)));
    asked.builder = options == NULL ? SVO_BUILDER_SORTED : asked.builder;
    SVO_I_TRY(svo_i_voxels_options(device, &voxels->info, voxels->normals != NULL, &depth, &asked));
    if (!allocate_points(&device->memory, voxels, asked.need, &p)) {
        status = svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %llu voxels", function,
                                   (unsigned long long)voxels->info.voxel_count);
        goto cleanup;
    }
    fill_points(voxels, &p);
    const svo_i_plan_input input = {.mesh = {.struct_size = sizeof input.mesh,
                                             .positions = p.positions,
                                             .vertex_count = (size_t)voxels->info.voxel_count,
                                             .indices = p.indices,
                                             .triangle_count = (size_t)voxels->info.voxel_count,
                                             .colors = p.colors,
                                             .triangle_materials = p.materials,
                                             .materials = p.table,
                                             .material_count = p.table != NULL ? voxels->info.material_count : 0},
                                    .exact_normals = p.normals};
    SVO_I_TRY_CLEANUP(svo_i_plan_create(device, function, &input, depth, &asked, &plan));
    SVO_I_TRY_CLEANUP(place_plan(device, voxels, &plan->info));
    *out = plan;
    plan = NULL;
cleanup:
    svo_plan_destroy(&plan);
    free_points(&p);
    return status;
}

svo_status svo_voxels_build(svo_device *device, const svo_voxels *voxels, unsigned depth,
                            const svo_plan_options *options, cl_command_queue queue, svo_tree **out,
                            svo_build_report *report)
{
    svo_plan *plan = NULL;
    if (out == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "svo_voxels_build: out is NULL");
    }
    svo_status status = svo_voxels_plan(device, voxels, depth, options, &plan);
    if (status == SVO_OK) {
        status = svo_build(plan, NULL, queue, out, report);
        svo_plan_destroy(&plan);
    }
    if (status != SVO_OK) {
        svo_i_message_rename(svo_i_device_message(device), "svo_voxels_build");
    }
    return status;
}
