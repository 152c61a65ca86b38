/* SPDX-License-Identifier: MIT */
/*
 * The plan: checks the request, runs the host stages (grid.c, attributes.c), predicts sizes by the count law and keeps
 * the list of buffers. Everything later in the pipeline obeys it.
 */
#include "plan.h"

#include "rays.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Grid units per axis as a power of two: the same for all depths up to 12, so that their trees nest; above, 2^8 units to
   a voxel. */
#define SNAP_BITS           20u
#define SNAP_BITS_DEPTH_MAX 12u
#define DEEP_VOXEL_LOG2     8u
/* A chunk holds at least the fragments of one column of one triangle, with a lot to spare. */
#define CHUNK_BYTES_MIN 16384
#define NEED_BITS       ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_RAYS)

const char *svo_coverage_name(svo_coverage coverage)
{
    static const char *const names[] = {"half-open", "closed", "thin"};
    return (unsigned)coverage <= SVO_COVERAGE_THIN ? names[coverage] : "unknown coverage";
}

static svo_status check_options(svo_device *device, const svo_plan_options *options)
{
    if (options->struct_size != sizeof *options) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "svo_plan_create: options.struct_size is %zu, not %zu",
                                 options->struct_size, sizeof *options);
    }
    if ((options->need & ~(NEED_BITS | (uint32_t)SVO_NEED_NONE)) != 0 ||
        ((options->need & SVO_NEED_NONE) != 0 && options->need != SVO_NEED_NONE)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "svo_plan_create: options.need 0x%x is not a combination of svo_need", options->need);
    }
    if ((unsigned)options->coverage > SVO_COVERAGE_THIN) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "svo_plan_create: options.coverage %d is not in 0 .. %d",
                                 (int)options->coverage, (int)SVO_COVERAGE_THIN);
    }
    if (!isfinite(options->edge) || options->edge < 0.0) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "svo_plan_create: options.edge %g is not finite and at least 0", options->edge);
    }
    if (options->fragment_capacity > SVO_I_FRAGMENTS_MAX) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "svo_plan_create: options.fragment_capacity %llu is above %u",
                                 (unsigned long long)options->fragment_capacity, SVO_I_FRAGMENTS_MAX);
    }
    if (options->chunk_bytes != 0 && options->chunk_bytes < CHUNK_BYTES_MIN) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "svo_plan_create: options.chunk_bytes %llu is below %d",
                                 (unsigned long long)options->chunk_bytes, CHUNK_BYTES_MIN);
    }
    for (unsigned axis = 0; axis < 3; ++axis) {
        if (!isfinite(options->origin[axis])) {
            return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                     "svo_plan_create: options.origin[%u] %g is not finite", axis,
                                     options->origin[axis]);
        }
    }
    return SVO_OK;
}

static svo_status check_textures(svo_device *device, const svo_mesh *mesh)
{
    for (size_t i = 0; i < mesh->texture_count; ++i) {
        const svo_texture *texture = &mesh->textures[i];
        if (texture->rgba == NULL || texture->width < 1 || texture->width > 16384 || texture->height < 1 ||
            texture->height > 16384) {
            return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                     "svo_plan_create: texture %zu is %u x %u texels, not 1 .. 16384 each, or has none",
                                     i, texture->width, texture->height);
        }
    }
    return SVO_OK;
}

static svo_status check_mesh(svo_device *device, const svo_mesh *mesh)
{
    if (mesh->struct_size != sizeof *mesh) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "svo_plan_create: mesh.struct_size is %zu, not %zu",
                                 mesh->struct_size, sizeof *mesh);
    }
    if (mesh->vertex_count > 0 && (mesh->positions == NULL) == (mesh->positions_double == NULL)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "svo_plan_create: mesh has %zu vertices but not exactly one array of positions",
                                 mesh->vertex_count);
    }
    if (mesh->vertex_count >= UINT32_MAX || mesh->triangle_count >= UINT32_MAX) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "svo_plan_create: mesh has %zu vertices and %zu triangles, not below 2^32 - 1",
                                 mesh->vertex_count, mesh->triangle_count);
    }
    if (mesh->material_count > 65535 || (mesh->material_count > 0 && mesh->materials == NULL) ||
        (mesh->texture_count > 0 && mesh->textures == NULL)) {
        return svo_i_device_fail(
            device, SVO_INVALID_ARGUMENT,
            "svo_plan_create: mesh has %zu materials (at most 65535) and %zu textures, or no array",
            mesh->material_count, mesh->texture_count);
    }
    return check_textures(device, mesh);
}

uint32_t svo_i_plan_fragment_bytes(const svo_plan *plan)
{
    return 4u * (plan->info.depth <= SVO_CODE30_DEPTH_MAX ? SVO_FRAGMENT_WORDS_30 : SVO_FRAGMENT_WORDS_48);
}

uint64_t svo_i_plan_inner_nodes(const svo_plan *plan, uint64_t fragments, bool certain)
{
    uint64_t total = 0;
    for (uint32_t level = 0; level < plan->info.depth; ++level) {
        uint64_t nodes = UINT64_C(1) << (3 * level);
        nodes = nodes > fragments && level > 0 ? fragments : nodes;
        const uint64_t likely = svo_i_with_slack(svo_i_plan_expected(plan, level));
        total += !certain && likely < nodes ? likely : nodes;
    }
    return total;
}

void svo_i_plan_buffers_reset(svo_plan *plan)
{
    plan->buffer_count = 0;
    plan->live_bytes = 0;
    plan->peak_bytes = 0;
}

void svo_i_plan_buffer_add(svo_plan *plan, const char *name, uint64_t bytes)
{
    plan->live_bytes += bytes;
    plan->peak_bytes = plan->live_bytes > plan->peak_bytes ? plan->live_bytes : plan->peak_bytes;
    for (size_t i = 0; i < plan->buffer_count; ++i) {
        if (strcmp(plan->buffers[i].name, name) == 0) {
            plan->buffers[i].bytes += bytes;
            ++plan->buffers[i].count;
            return;
        }
    }
    if (plan->buffer_count < SVO_I_BUFFERS_MAX) {
        plan->buffers[plan->buffer_count++] = (svo_buffer_info){name, bytes, 1};
    }
}

void svo_i_plan_buffer_remove(svo_plan *plan, uint64_t bytes)
{
    plan->live_bytes -= bytes;
}

/* What is uploaded of the mesh itself, for the lists and for the filter. */
static void predict_geometry(svo_plan *plan)
{
    svo_i_plan_buffer_add(plan, "vertices", (uint64_t)plan->vertex_count * 12);
    svo_i_plan_buffer_add(plan, "indices", (uint64_t)plan->triangle_count * 12);
}

/* One for every second level, from the leaves' grandparents up. */
static uint64_t predict_ray_nodes(const svo_plan *plan)
{
    uint64_t nodes = 1;
    for (uint32_t level = plan->info.depth; level >= 2; level -= 2) {
        nodes += svo_i_with_slack(svo_i_plan_expected(plan, level - 2));
    }
    return nodes;
}

/* Lists and the geometry they point into, and the scratch that is released when they are sorted. */
static void predict_lists(svo_plan *plan, uint64_t fragments, uint64_t leaves)
{
    const uint64_t long_leaves = fragments / (SVO_SHORT_LIST_MAX + 1) + 1;
    predict_geometry(plan);
    svo_i_plan_buffer_add(plan, "triangle_ids", (uint64_t)plan->triangle_count * 4);
    svo_i_plan_buffer_add(plan, "list_begin", (leaves + 1) * 4);
    svo_i_plan_buffer_add(plan, "list", fragments * 4);
    svo_i_plan_buffer_add(plan, "list_counts", leaves * 4);
    svo_i_plan_buffer_add(plan, "list_spare", fragments * 4);
    svo_i_plan_buffer_add(plan, "long_leaves", long_leaves * 4);
    svo_i_plan_buffer_remove(plan, (leaves + fragments + long_leaves) * 4);
    svo_i_plan_buffer_add(plan, "ray_triangles", fragments * SVO_I_RAY_TRIANGLE_BYTES);
    svo_i_plan_buffer_add(plan, "ray_nodes", predict_ray_nodes(plan) * SVO_I_RAY_NODE_BYTES);
}

/* The attributes this mesh has and this request reads. */
static void predict_attributes(svo_plan *plan)
{
    const uint64_t vertices = plan->vertex_count;
    if ((plan->info.need & SVO_NEED_RAYS) == 0) {
        predict_geometry(plan);
    }
    svo_i_plan_buffer_add(plan, "records", (uint64_t)plan->triangle_count * sizeof(svo_triangle_record));
    if (plan->colors != NULL) {
        svo_i_plan_buffer_add(plan, "vertex_colors", vertices * 4);
    }
    if (plan->normals != NULL) {
        svo_i_plan_buffer_add(plan, "vertex_normals", vertices * 8);
    }
    if (plan->uvs != NULL) {
        svo_i_plan_buffer_add(plan, "uvs", vertices * 8);
    }
    svo_i_plan_buffer_add(plan, "materials", plan->material_count * sizeof(svo_material_record));
    if (plan->texels != NULL) {
        svo_i_plan_buffer_add(plan, "texels", plan->texel_count * 4);
    }
}

/* The sums of the nodes of one level. */
static void predict_sums(svo_plan *plan, uint64_t nodes)
{
    svo_i_plan_buffer_add(plan, "weights", nodes * 4);
    if ((plan->info.need & SVO_NEED_COLOR) != 0) {
        svo_i_plan_buffer_add(plan, "color_sums", nodes * 32);
    }
    if ((plan->info.need & SVO_NEED_NORMAL) != 0) {
        svo_i_plan_buffer_add(plan, "normal_sums", nodes * 24);
    }
}

/* What the filter needs: list heads, the sums of two levels, the payload itself, and the attributes it comes from. */
static void predict_payload(svo_plan *plan, uint64_t nodes, uint64_t leaves)
{
    const uint32_t depth = plan->info.depth;
    svo_i_plan_buffer_add(plan, "heads", leaves * 4);
    predict_sums(plan, depth > 1 ? svo_i_with_slack(svo_i_plan_expected(plan, depth - 2)) : 1);
    predict_sums(plan, svo_i_with_slack(svo_i_plan_expected(plan, depth - 1)));
    if ((plan->info.need & SVO_NEED_COLOR) != 0) {
        svo_i_plan_buffer_add(plan, "colors", nodes * 4);
    }
    if ((plan->info.need & SVO_NEED_NORMAL) != 0) {
        svo_i_plan_buffer_add(plan, "normals", nodes * 6);
    }
    predict_attributes(plan);
}

/* The sizes before a build: the same buffers the builder asks for, with expected counts in place of real ones, for a list
   of one chunk. */
static void predict_buffers(svo_plan *plan)
{
    const double expected = svo_i_plan_expected(plan, plan->info.depth);
    const uint64_t fragments =
        plan->options.fragment_capacity != 0 ? plan->options.fragment_capacity : svo_i_with_slack(expected);
    const uint64_t inner = svo_i_plan_inner_nodes(plan, fragments, false);
    const uint64_t leaves = fragments;
    svo_i_plan_buffers_reset(plan);
    svo_i_plan_buffer_add(plan, "fragments", fragments * svo_i_plan_fragment_bytes(plan));
    svo_i_plan_buffer_add(plan, "cursors", fragments * 4);
    svo_i_plan_buffer_add(plan, "child_mask_pool", (inner + 3) / 4 * 4);
    svo_i_plan_buffer_add(plan, "first_child_pool", inner * 4);
    svo_i_plan_buffer_add(plan, "state", sizeof(svo_build_state));
    svo_i_plan_buffer_add(plan, "partials", SVO_SCAN_GROUPS * sizeof(uint32_t));
    /* The nodes move to buffers of their size, one after the other. */
    svo_i_plan_buffer_add(plan, "child_mask", inner);
    svo_i_plan_buffer_remove(plan, (inner + 3) / 4 * 4);
    svo_i_plan_buffer_add(plan, "first_child", inner * 4);
    svo_i_plan_buffer_remove(plan, inner * 4);
    if ((plan->info.need & SVO_NEED_RAYS) != 0) {
        predict_lists(plan, fragments, leaves);
    }
    if ((plan->info.need & (SVO_NEED_COLOR | SVO_NEED_NORMAL)) != 0) {
        predict_payload(plan, inner + leaves, leaves);
    }
}

svo_status svo_plan_create(svo_device *device, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options,
                           svo_plan **out)
{
    if (device == NULL || mesh == NULL || out == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "svo_plan_create: %s is NULL",
                                 device == NULL ? "device"
                                 : mesh == NULL ? "mesh"
                                                : "out");
    }
    if (depth < SVO_DEPTH_MIN || depth > SVO_DEPTH_MAX) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "svo_plan_create: depth %u is not in %d .. %d", depth,
                                 SVO_DEPTH_MIN, SVO_DEPTH_MAX);
    }
    svo_status status = options != NULL ? check_options(device, options) : SVO_OK;
    if (status == SVO_OK) {
        status = check_mesh(device, mesh);
    }
    if (status != SVO_OK) {
        return status;
    }
    svo_plan *plan = calloc(1, sizeof *plan);
    if (plan == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "svo_plan_create: no memory for the handle");
    }
    const double start_ms = svo_i_now_ms();
    plan->device = device;
    plan->options = options != NULL ? *options : (svo_plan_options){.struct_size = sizeof *options};
    plan->info.depth = depth;
    plan->info.snap_bits = depth <= SNAP_BITS_DEPTH_MAX ? SNAP_BITS : depth + DEEP_VOXEL_LOG2;
    plan->info.coverage = plan->options.coverage;
    plan->voxel_log2 = plan->info.snap_bits - depth;
    status = svo_i_plan_grid(plan, mesh);
    if (status == SVO_OK) {
        status = svo_i_plan_attributes(plan, mesh);
    }
    if (status != SVO_OK) {
        svo_plan_destroy(&plan);
        return status;
    }
    plan->info.expected_fragments = svo_i_plan_expected(plan, depth);
    plan->info.grid_ms = svo_i_now_ms() - start_ms;
    predict_buffers(plan);
    plan->predicted_bytes = plan->peak_bytes;
    *out = plan;
    return SVO_OK;
}

void svo_plan_destroy(svo_plan **plan)
{
    if (plan == NULL || *plan == NULL) {
        return;
    }
    svo_plan *p = *plan;
    free(p->vertices);
    free(p->indices);
    free(p->triangle_ids);
    free(p->items);
    free(p->item_fragments);
    free(p->records);
    free(p->colors);
    free(p->normals);
    free(p->uvs);
    free(p->materials);
    free(p->texels);
    free(p);
    *plan = NULL;
}

void svo_plan_get_info(const svo_plan *plan, svo_plan_info *info)
{
    *info = plan->info;
}

size_t svo_plan_get_buffer(const svo_plan *plan, size_t index, svo_buffer_info *info)
{
    if (info != NULL && index < plan->buffer_count) {
        *info = plan->buffers[index];
    }
    return plan->buffer_count;
}

uint64_t svo_plan_peak_bytes(const svo_plan *plan)
{
    return plan->peak_bytes;
}
