/* SPDX-License-Identifier: MIT */
/*
 * A part of a tree is what lies under one node of the whole grid. Its plan is that of a smaller grid on the same
 * lattice: vertices are snapped to the whole grid and then count from the part's corner. Overlap tests, clipping and
 * samples compute relative to voxels, so moving by whole voxels changes none of them. What depends on the whole mesh
 * comes from the header: the grid, the unit of weights, constant payload, whether the mesh is closed.
 */
#include <math.h>
#include <string.h>

#include "core/struct_size.h"
#include "plan/estimate.h"
#include "plan/host_copy.h"
#include "plan/part.h"
#include "svocl/nodes.h"

/* The same units for all depths up to 12, so that their trees nest. Above, a voxel has 2^8 units. */
#define SNAP_BITS           20u
#define SNAP_BITS_DEPTH_MAX 12u
#define DEEP_VOXEL_LOG2     8u

/* Limits on the unit of weights in a header; those of attributes.c lie inside. */
#define WEIGHT_LOG2_MAX 48u

uint32_t svo_i_snap_bits(uint32_t depth)
{
    return depth <= SNAP_BITS_DEPTH_MAX ? SNAP_BITS : depth + DEEP_VOXEL_LOG2;
}

bool svo_i_plan_is_part(const svo_plan *plan)
{
    return plan->part.header.depth != 0;
}

/* Why a header cannot be that of a tree of that depth, or NULL. */
static const char *wrong_header(const svo_part_header *header, uint32_t depth)
{
    if (header->depth != depth) {
        return "is of a tree of another depth";
    }
    if (header->snap_bits != svo_i_snap_bits(depth) || header->coverage > SVO_COVERAGE_THIN ||
        header->weights > SVO_WEIGHTS_CENTER || header->payload_level > depth ||
        (header->need & ~(uint32_t)SVO_NEED_ALL) != 0 || (header->constant & ~header->need) != 0 ||
        header->weight_log2 > WEIGHT_LOG2_MAX) {
        return "has values that no plan has";
    }
    const bool has_grid = isfinite(header->origin[0]) && isfinite(header->origin[1]) && isfinite(header->origin[2]) &&
                          isfinite(header->edge) && isfinite(header->scale) && header->scale > 0.0;
    return has_grid ? NULL : "has a grid that is not finite";
}

static svo_status check_place(svo_device *device, const char *function, uint32_t depth, const svo_plan_options *options)
{
    if (options->part_level >= depth) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.part_level %u is not below depth %u",
                                 function, options->part_level, depth);
    }
    if (options->part_code >> (3 * options->part_level) != 0) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.part_code %llu is not below 8^%u", function,
                                 (unsigned long long)options->part_code, options->part_level);
    }
    return options->place != SVO_PLACE_DEVICE
               ? SVO_OK
               : svo_i_device_fail(device, SVO_UNSUPPORTED,
                                   "%s: options.place is device; parts are planned on the host", function);
}

/* The whole's request, as far as it concerns the part. */
static void take_request(const svo_part_header *header, svo_plan_options *options)
{
    const uint32_t level = options->part_level;
    options->need = header->need != 0 ? header->need : (uint32_t)SVO_NEED_NONE;
    options->coverage = (svo_coverage)header->coverage;
    options->weights = (svo_weights)header->weights;
    options->payload_level = header->payload_level > level ? header->payload_level - level : 0;
    options->edge = 0.0;
    memset(options->origin, 0, sizeof options->origin);
}

svo_status svo_i_part_read(svo_device *device, const char *function, uint32_t depth, svo_plan_options *options,
                           svo_i_plan_part *part)
{
    svo_part_header header;
    if (options->part_header == NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_struct_read(&device->message, function, "options.part_header", options->part_header, &header,
                                SVO_I_STRUCT_SIZES(svo_part_header, expected_nodes)));
    const char *wrong = wrong_header(&header, depth);
    if (wrong != NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.part_header %s", function, wrong);
    }
    SVO_I_TRY(check_place(device, function, depth, options));
    take_request(&header, options);
    *part = (svo_i_plan_part){.header = header, .level = options->part_level, .code = options->part_code};
    uint32_t cell[3];
    svo_code_to_cell(part->code, cell);
    for (unsigned axis = 0; axis < 3; ++axis) {
        part->corner[axis] = (int32_t)(cell[axis] << (header.snap_bits - part->level));
    }
    return SVO_OK;
}

void svo_i_part_grid(svo_plan *plan)
{
    const svo_part_header *header = &plan->part.header;
    plan->info.scale = header->scale;
    plan->info.edge = ldexp(1.0, (int)plan->info.snap_bits) / header->scale;
    for (unsigned axis = 0; axis < 3; ++axis) {
        plan->info.origin[axis] = header->origin[axis] + (double)plan->part.corner[axis] / header->scale;
    }
}

svo_status svo_i_part_alloc(svo_plan *plan, size_t triangles)
{
    if (!svo_i_plan_is_part(plan)) {
        return SVO_OK;
    }
    plan->part.positions = svo_i_alloc(&plan->device->memory, (triangles + 1) * sizeof(uint32_t));
    return plan->part.positions != NULL
               ? SVO_OK
               : svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu triangles",
                                   plan->progress.function, triangles);
}

void svo_i_part_counts(svo_plan *plan)
{
    const svo_part_header *header = &plan->part.header;
    if (svo_i_plan_is_part(plan)) {
        plan->info.triangles = header->triangles;
        plan->info.refused_triangles = header->refused_triangles;
        plan->info.outside_triangles = header->triangles - header->refused_triangles - header->kept_triangles;
        plan->info.snap_error = header->snap_error;
        plan->work.both_sides = (header->flags & SVO_PART_BOTH_SIDES) != 0;
    }
}

void svo_i_plan_take_constants(svo_plan *plan)
{
    const svo_part_header *header = &plan->part.header;
    svo_i_work *work = &plan->work;
    work->constant = header->constant;
    memcpy(&work->constant_color, header->constant_color, sizeof work->constant_color);
    memcpy(work->constant_normal, header->constant_normal, sizeof work->constant_normal);
    work->constant_material = header->constant_material;
    plan->info.constant = header->constant;
    plan->weight_log2 = header->weight_log2;
}

void svo_i_part_name_triangles(svo_plan *plan)
{
    if (svo_i_plan_is_part(plan)) {
        svo_i_free(plan->triangle_ids);
        plan->triangle_ids = plan->part.positions;
        plan->part.positions = NULL;
    }
}

bool svo_i_part_sums_root(const svo_plan *plan)
{
    return svo_i_plan_is_part(plan) && plan->part.header.payload_level < plan->part.level;
}

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
    if (svo_i_plan_has(plan->positions, plan->memory.positions)) {
        return SVO_POSITIONS_FLOAT;
    }
    return svo_i_plan_has(plan->positions_double, plan->memory.positions_double) ? SVO_POSITIONS_DOUBLE
                                                                                 : SVO_POSITIONS_SNAPPED;
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
                              .edge = info->edge,
                              .scale = info->scale,
                              .snap_error = info->snap_error,
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
    const svo_part_header made = header_of(plan);
    return svo_i_struct_write(&plan->device->message, function, "header", &made, header,
                              SVO_I_STRUCT_SIZES(svo_part_header, expected_nodes));
}
