/* SPDX-License-Identifier: MIT */
/*
 * svo_surface_create: a closed mesh out of a field, in steps: bricks of its numbers (field.h), vertices, triangles, and
 * what vertices have from leaves. All on the host, in one order. And what callers ask of a surface.
 */
#include "svocl/surface.h"

#include <math.h>
#include <string.h>

#include "core/device.h"
#include "core/struct_size.h"
#include "sdf/handle.h"
#include "surface/leaves.h"
#include "surface/triangles.h"
#include "surface/vertices.h"

#define ALL_PARTS (SVO_SURFACE_NORMALS | SVO_SURFACE_COLORS | SVO_SURFACE_LEAF_NORMALS)

static const char create_name[] = "svo_surface_create";

/* ---- creation ---- */

static svo_status read_arguments(const svo_surface_field *field, const svo_surface_options *options, svo_surface **out,
                                 svo_message *message, svo_surface_options *asked)
{
    if (field == NULL || out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s is NULL", create_name,
                          field == NULL ? "field" : "out");
    }
    SVO_I_TRY(svo_i_struct_read(message, create_name, "options", options, asked,
                                SVO_I_STRUCT_SIZES(svo_surface_options, memory)));
    if (!isfinite(asked->level)) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: options.level %g is not finite", create_name,
                          (double)asked->level);
    }
    if ((asked->parts & ~(uint32_t)ALL_PARTS) != 0) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: options.parts %u has bits besides %u", create_name,
                          asked->parts, (unsigned)ALL_PARTS);
    }
    return svo_i_surface_check_tree(asked, message);
}

/* Gives back what the array has too much. */
static void trim(void **array, size_t bytes)
{
    void *less = *array != NULL && bytes > 0 ? svo_i_grow(NULL, *array, bytes) : NULL;
    *array = less != NULL ? less : *array;
}

static void finish(svo_i_surface_work *work)
{
    svo_surface *surface = work->surface;
    const size_t vertices = work->vertex_count;
    trim((void **)&surface->positions, vertices * 3 * sizeof *surface->positions);
    trim((void **)&surface->indices, work->triangle_count * 3 * sizeof *surface->indices);
    if (work->with_normals) {
        trim((void **)&surface->normals, vertices * 3 * sizeof *surface->normals);
    }
    surface->mesh = (svo_mesh){.struct_size = sizeof surface->mesh,
                               .positions = surface->positions,
                               .vertex_count = vertices,
                               .indices = surface->indices,
                               .triangle_count = work->triangle_count,
                               .normals = surface->normals,
                               .colors = surface->colors};
    surface->info.vertex_count = vertices;
    surface->info.triangle_count = work->triangle_count;
    surface->info.bytes =
        work->triangle_count * 3 * sizeof *surface->indices +
        vertices * (3 * sizeof *surface->positions + (surface->normals != NULL ? 3 * sizeof *surface->normals : 0) +
                    (surface->colors != NULL ? 4 : 0));
}

static svo_status make(const svo_surface_field *field, const svo_surface_options *asked, svo_message *message,
                       svo_surface *surface)
{
    svo_i_surface_work work = {.surface = surface,
                               .message = message,
                               .with_normals = (asked->parts & SVO_SURFACE_NORMALS) != 0 &&
                                               (asked->parts & SVO_SURFACE_LEAF_NORMALS) == 0};
    svo_status status = SVO_OK;
    svo_i_surface_make_cases(&work.cases);
    SVO_I_TRY_CLEANUP(svo_i_surface_open(field, asked->level, &surface->memory, message, &work.reader));
    SVO_I_TRY_CLEANUP(svo_i_surface_find_vertices(&work));
    SVO_I_TRY_CLEANUP(svo_i_surface_find_triangles(&work));
    SVO_I_TRY_CLEANUP(svo_i_surface_take_leaves(&work, asked));
    finish(&work);

cleanup:
    svo_i_surface_close(&work.reader);
    svo_i_free(work.bricks);
    svo_i_free(work.cubes);
    return status;
}

svo_status svo_surface_create(const svo_surface_field *field, const svo_surface_options *options, svo_surface **out,
                              svo_message *message)
{
    svo_surface_field given;
    svo_surface_options asked;
    svo_i_memory memory;
    SVO_I_TRY(read_arguments(field, options, out, message, &asked));
    SVO_I_TRY(svo_i_struct_read(message, create_name, "field", field, &given,
                                SVO_I_STRUCT_SIZES(svo_surface_field, spacing)));
    SVO_I_TRY(svo_i_memory_read(message, create_name, "options.memory", asked.memory, &memory));
    svo_surface *surface = svo_i_alloc_zeroed(&memory, 1, sizeof *surface);
    if (surface == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a surface", create_name);
    }
    surface->memory = memory;
    const svo_status status = make(&given, &asked, message, surface);
    if (status != SVO_OK) {
        svo_surface_destroy(&surface);
        return status;
    }
    *out = surface;
    return SVO_OK;
}

void svo_surface_destroy(svo_surface **surface)
{
    if (surface == NULL || *surface == NULL) {
        return;
    }
    svo_i_free((*surface)->positions);
    svo_i_free((*surface)->indices);
    svo_i_free((*surface)->normals);
    svo_i_free((*surface)->colors);
    svo_i_free(*surface);
    *surface = NULL;
}

/* ---- what callers ask ---- */

svo_status svo_surface_field_of(const svo_sdf *sdf, svo_surface_field *field)
{
    static const char function[] = "svo_surface_field_of";
    if (sdf == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (!sdf->downloaded) {
        return svo_i_device_fail(sdf->device, SVO_INVALID_ARGUMENT,
                                 "%s: the field has no host arrays; call svo_sdf_download first", function);
    }
    svo_surface_field held = {.distances = sdf->host[SVO_SDF_DISTANCES],
                              .codes = sdf->host[SVO_SDF_CODES],
                              .voxel_count = sdf->info.voxel_count,
                              .spacing = sdf->info.spacing};
    for (int axis = 0; axis < 3; ++axis) {
        held.size[axis] = UINT32_C(1) << sdf->info.depth;
        held.first[axis] = sdf->info.first[axis];
    }
    return svo_i_struct_write(svo_i_device_message(sdf->device), function, "field", &held, field,
                              SVO_I_STRUCT_SIZES(svo_surface_field, spacing));
}

svo_status svo_surface_get_info(const svo_surface *surface, svo_surface_info *info)
{
    return surface == NULL ? SVO_INVALID_ARGUMENT
                           : svo_i_struct_write(NULL, "svo_surface_get_info", "info", &surface->info, info,
                                                SVO_I_STRUCT_SIZES(svo_surface_info, bytes));
}

const svo_mesh *svo_surface_get_mesh(const svo_surface *surface)
{
    return &surface->mesh;
}
