/* SPDX-License-Identifier: MIT */
/*
 * A part of a tree is what lies under one node of the whole grid. Its plan is that of a smaller grid on the same
 * lattice: vertices are snapped to the whole grid and then count from the part's corner. Overlap tests, clipping and
 * samples compute relative to voxels, so moving by whole voxels changes none of them. What depends on the whole mesh
 * comes from the header: the grid, the unit of weights, constant payload, whether the mesh is closed.
 */
#include "plan/part.h"

#include <math.h>
#include <string.h>

#include "core/device.h"
#include "core/struct_size.h"
#include "plan/arrays.h"
#include "plan/attributes.h"
#include "plan/estimate.h"

/* ---- headers ---- */

/* So many faces are too many above the parts: their weights, 2^SVO_I_WEIGHT_LOG2_MIN each or more, are multiplied by
   2^17 there. */
#define FACES_MAX 0x1p34

/* Nodes that the mesh's area accounts for: on a level no more than its fragments of whole surfaces, or its cells. */
static double expected_nodes(const svo_plan *plan)
{
    double nodes = 0.0;
    for (uint32_t level = 0; level <= plan->info.depth; ++level) {
        const double voxel = ldexp(1.0, (int)(plan->info.snap_bits - level));
        nodes += fmax(1.0, fmin(ldexp(1.0, 3 * (int)level), plan->estimate[2] / (voxel * voxel)));
    }
    return nodes;
}

static uint32_t positions_of(const svo_plan *plan)
{
    if (!svo_i_plan_stores_positions(plan)) {
        return SVO_POSITIONS_ROUNDED;
    }
    if (svo_i_plan_has(plan->positions, plan->memory.positions)) {
        return SVO_POSITIONS_FLOAT;
    }
    return svo_i_plan_has(plan->positions_double, plan->memory.positions_double) ? SVO_POSITIONS_DOUBLE
                                                                                 : SVO_POSITIONS_ROUNDED;
}

static svo_part_header header_of(const svo_plan *plan)
{
    const svo_plan_info *info = &plan->info;
    const svo_i_work *work = &plan->work;
    svo_part_header header = {.depth = info->depth,
                              .snap_bits = info->snap_bits,
                              .coverage = info->coverage,
                              .need = info->need,
                              .constant = info->constant,
                              .weights = plan->options.weights,
                              .payload_level = plan->options.payload_level,
                              .weight_log2 = plan->weight_log2,
                              .flags = work->both_sides ? (uint32_t)SVO_PART_BOTH_SIDES : 0,
                              .positions = positions_of(plan),
                              .constant_material = work->constant_material,
                              .least_alpha = plan->least_alpha,
                              .edge = info->edge,
                              .scale = info->scale,
                              .triangles = info->triangles,
                              .refused_triangles = info->refused_triangles,
                              .kept_triangles = plan->triangle_count,
                              .vertex_count = plan->vertex_count,
                              .expected_fragments = info->expected_fragments,
                              .expected_nodes = expected_nodes(plan)};
    memcpy(header.constant_color, &work->constant_color, sizeof header.constant_color);
    memcpy(header.constant_normal, work->constant_normal, sizeof header.constant_normal);
    memcpy(header.origin, info->origin, sizeof header.origin);
    return header;
}

svo_status svo_plan_get_part_header(const svo_plan *plan, svo_part_header *header)
{
    static const char function[] = "svo_plan_get_part_header";
    if (plan == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (svo_i_plan_is_part(plan)) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, "%s: the plan is that of a part", function);
    }
    /* What lies between closed voxels is in both. */
    const int times_log2 = plan->info.coverage == SVO_COVERAGE_CLOSED ? 1 : 0;
    const double faces = ldexp(plan->estimate[2], times_log2 - 2 * (int)plan->voxel_log2);
    if (faces >= FACES_MAX && (plan->info.need & SVO_I_NEED_PAYLOAD) != 0) {
        return svo_i_device_fail(
            plan->device, SVO_CAPACITY_EXCEEDED,
            "%s: the surface is %.3g faces of voxels large, and the payload of 2^34 no longer adds "
            "up in 64 bits; lower the depth, or need none",
            function, faces);
    }
    const svo_part_header made = header_of(plan);
    return svo_i_struct_write(&plan->device->message, function, "header", &made, header,
                              SVO_I_STRUCT_SIZES(svo_part_header, expected_nodes));
}

/* ---- surveys ---- */

/* Each block is planned by itself on the grid of the whole; counts, sums and findings add up in the plan of the whole,
   which has no arrays. */

#define NAME "svo_parts_create_from_file"

/* Whether a mesh must be whole for them: the vertices that rays meet, and whether it is closed. */
#define WHOLE_NEEDS ((uint32_t)SVO_NEED_RAYS | (uint32_t)SVO_NEED_PROJECTED_AREA)

svo_status svo_i_survey_begin(svo_plan *empty, svo_i_survey *survey)
{
    *survey = (svo_i_survey){.whole = empty, .bounds = svo_i_survey_no_bounds()};
    const uint32_t need = empty->options.need & WHOLE_NEEDS;
    if (svo_i_plan_is_part(empty)) {
        return svo_i_device_fail(empty->device, SVO_INVALID_ARGUMENT, NAME ": options.part_header is not NULL");
    }
    if (need != 0) {
        return svo_i_device_fail(
            empty->device, SVO_UNSUPPORTED, "%s needs the whole mesh",
            svo_name(SVO_NAME_NEED, (need & SVO_NEED_RAYS) != 0 ? SVO_NEED_RAYS : SVO_NEED_PROJECTED_AREA));
    }
    empty->progress = (svo_i_progress){.function = NAME};
    /* Without triangles all payload is constant. */
    svo_i_free(empty->materials);
    empty->materials = NULL;
    empty->one_normal = false;
    empty->work = (svo_i_work){.made = 0};
    return SVO_OK;
}

static bool is_finite(const float *corners)
{
    bool finite = true;
    for (unsigned i = 0; i < 9; ++i) {
        finite = finite && isfinite(corners[i]);
    }
    return finite;
}

void svo_i_survey_bounds(svo_i_survey *survey, const svo_mesh *block)
{
    svo_i_bounds *bounds = &survey->bounds;
    for (size_t t = 0; t < block->triangle_count; ++t) {
        const float *corners = block->positions + t * 9;
        if (!is_finite(corners)) {
            continue;
        }
        bounds->any = true;
        for (unsigned i = 0; i < 9; ++i) {
            const double x = (double)corners[i];
            const unsigned axis = i % 3;
            bounds->low[axis] = x < bounds->low[axis] ? x : bounds->low[axis];
            bounds->high[axis] = x > bounds->high[axis] ? x : bounds->high[axis];
        }
    }
}

svo_status svo_i_survey_fit(svo_i_survey *survey)
{
    return svo_i_plan_make_grid(survey->whole, &survey->bounds);
}

/* ---- blocks ---- */

static svo_plan *new_block(const svo_plan *whole)
{
    svo_plan *block = svo_i_alloc_zeroed(&whole->device->memory, 1, sizeof *block);
    if (block != NULL) {
        block->device = whole->device;
        block->options = whole->options;
        block->info = whole->info;
        block->voxel_log2 = whole->voxel_log2;
        block->progress.function = NAME;
        block->has_grid = true;
    }
    return block;
}

static void add_counts(svo_i_survey *survey, const svo_plan *block)
{
    svo_plan *whole = survey->whole;
    whole->info.triangles += block->info.triangles;
    whole->info.refused_triangles += block->info.refused_triangles;
    whole->info.outside_triangles += block->info.outside_triangles;
    whole->sums.widths += block->sums.widths;
    whole->sums.areas_high += block->sums.areas_high;
    whole->sums.areas_low += block->sums.areas_low;
    survey->kept += block->triangle_count;
}

/* Adds the findings of a block with triangles, before its counts. */
static void add_findings(svo_i_survey *survey, const svo_i_findings *block)
{
    svo_i_findings *found = &survey->found;
    if (survey->kept == 0) {
        *found = *block;
        return;
    }
    found->largest_area = fmax(found->largest_area, block->largest_area);
    found->colors_vary = found->colors_vary || block->colors_vary || block->first_color != found->first_color;
    found->normals_vary = found->normals_vary || block->normals_vary ||
                          memcmp(block->first_normal, found->first_normal, sizeof found->first_normal) != 0;
    found->own_normals_vary = found->own_normals_vary || block->own_normals_vary ||
                              !svo_i_same_own_normal(&block->first_record, &found->first_record);
}

static svo_status find(svo_i_survey *survey, svo_plan *block, const svo_mesh *mesh)
{
    svo_i_findings found = {.material_used = survey->material_used};
    svo_i_plan_resolve_need(block, mesh, mesh->colors != NULL);
    survey->whole->info.need = block->info.need;
    survey->has_colors = mesh->colors != NULL;
    survey->has_normals = mesh->normals != NULL;
    if ((block->info.need & SVO_I_NEED_PAYLOAD) != 0 && block->triangle_count > 0) {
        SVO_I_TRY(svo_i_plan_find(block, mesh, &found));
        add_findings(survey, &found);
    }
    return SVO_OK;
}

svo_status svo_i_survey_add(svo_i_survey *survey, const svo_mesh *block, uint32_t *kept, int32_t (*corners)[3][3],
                            uint32_t *kept_count)
{
    svo_device *device = survey->whole->device;
    svo_status status = SVO_OK;
    svo_plan *plan = new_block(survey->whole);
    if (plan == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, NAME ": no memory for a block");
    }
    SVO_I_TRY_CLEANUP(svo_i_plan_grid(plan, block));
    SVO_I_TRY_CLEANUP(find(survey, plan, block));
    add_counts(survey, plan);
    if (survey->whole->info.triangles >= UINT32_MAX) {
        status = svo_i_device_fail(device, SVO_INVALID_ARGUMENT, NAME ": the mesh has 2^32 - 1 triangles or more");
        goto cleanup;
    }
    *kept_count = plan->triangle_count;
    memcpy(kept, plan->triangle_ids, plan->triangle_count * sizeof *kept);
    for (uint32_t i = 0; i < 3 * plan->triangle_count; ++i) {
        memcpy(corners[i / 3][i % 3], plan->vertices + (size_t)plan->indices[i] * 3, sizeof corners[0][0]);
    }
cleanup:
    svo_plan_destroy(&plan);
    return status;
}

void svo_i_survey_get(const svo_i_survey *survey, svo_i_survey_sums *sums)
{
    const svo_plan *whole = survey->whole;
    *sums = (svo_i_survey_sums){.bounds = survey->bounds,
                                .found = survey->found,
                                .sums = whole->sums,
                                .triangles = whole->info.triangles,
                                .refused_triangles = whole->info.refused_triangles,
                                .outside_triangles = whole->info.outside_triangles,
                                .kept = survey->kept,
                                .need = whole->info.need,
                                .has_colors = survey->has_colors,
                                .has_normals = survey->has_normals,
                                .has_material = survey->material_used[0] != 0};
    sums->found.material_used = NULL;
}

void svo_i_survey_append(svo_i_survey *survey, const svo_i_survey_sums *next)
{
    svo_plan *whole = survey->whole;
    if (next->kept > 0) {
        add_findings(survey, &next->found);
    }
    for (unsigned axis = 0; axis < 3; ++axis) {
        svo_i_bounds *bounds = &survey->bounds;
        bounds->any = bounds->any || next->bounds.any;
        bounds->low[axis] = fmin(bounds->low[axis], next->bounds.low[axis]);
        bounds->high[axis] = fmax(bounds->high[axis], next->bounds.high[axis]);
    }
    whole->info.triangles += next->triangles;
    whole->info.refused_triangles += next->refused_triangles;
    whole->info.outside_triangles += next->outside_triangles;
    whole->sums.widths += next->sums.widths;
    whole->sums.areas_high += next->sums.areas_high;
    whole->sums.areas_low += next->sums.areas_low;
    whole->info.need = next->need;
    survey->kept += next->kept;
    survey->has_colors = next->has_colors;
    survey->has_normals = next->has_normals;
    survey->material_used[0] |= next->has_material ? 1 : 0;
}

bool svo_i_survey_places(const svo_part_header *header, const svo_snap *snap, const svo_mesh *block, size_t triangle,
                         int32_t corners[3][3])
{
    const float *from = block->positions + triangle * 9;
    const int32_t units = (int32_t)(1u << header->snap_bits);
    const int32_t closed = header->coverage == SVO_COVERAGE_CLOSED ? 1 : 0;
    if (!is_finite(from)) {
        return false;
    }
    for (unsigned axis = 0; axis < 3; ++axis) {
        int32_t low = INT32_MAX;
        int32_t high = INT32_MIN;
        for (unsigned corner = 0; corner < 3; ++corner) {
            const int32_t q = svo_snap_coordinate(snap, (double)from[3 * (size_t)corner + axis], header->origin[axis]);
            corners[corner][axis] = q;
            low = q < low ? q : low;
            high = q > high ? q : high;
        }
        if (low <= -SVO_UNITS_FAR || high >= SVO_UNITS_FAR || high < 0 || low >= units + closed) {
            return false;
        }
    }
    return true;
}

/* ---- the whole ---- */

/* Stands for an attribute of all vertices, which the whole has but the survey has not. */
static svo_status stand_in(svo_plan *whole, bool is_needed, size_t bytes, void **out)
{
    *out = is_needed ? svo_i_alloc_zeroed(&whole->device->memory, 1, bytes) : NULL;
    return *out != NULL || !is_needed ? SVO_OK
                                      : svo_i_device_fail(whole->device, SVO_OUT_OF_HOST_MEMORY, NAME ": no memory");
}

static svo_status conclude(svo_i_survey *survey)
{
    const svo_mesh none = {.struct_size = sizeof none};
    svo_plan *whole = survey->whole;
    void *array = NULL;
    survey->found.material_used = survey->material_used;
    SVO_I_TRY(stand_in(whole, (whole->info.need & SVO_NEED_NORMAL) != 0 && survey->has_normals, 8, &array));
    whole->normals = array;
    SVO_I_TRY(stand_in(whole, (whole->info.need & SVO_NEED_COLOR) != 0 && survey->has_colors, 4, &array));
    whole->colors = array;
    if ((svo_i_plan_reads(whole) & SVO_NEED_COLOR) != 0) {
        SVO_I_TRY(svo_i_plan_copy_materials(whole, &none, false, survey->material_used));
    }
    return svo_i_plan_conclude(whole, &survey->found);
}

svo_status svo_i_survey_header(svo_i_survey *survey, svo_part_header *header)
{
    svo_plan *whole = survey->whole;
    whole->triangle_count = (uint32_t)survey->kept;
    svo_i_estimate_end(whole);
    whole->info.expected_fragments = svo_i_plan_expected(whole, whole->info.depth);
    if ((whole->info.need & SVO_I_NEED_PAYLOAD) != 0) {
        SVO_I_TRY(conclude(survey));
    }
    return svo_plan_get_part_header(whole, header);
}
