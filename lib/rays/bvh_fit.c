/* SPDX-License-Identifier: MIT */
/*
 * Launches kernels/bvh/leaves.cl and refit.cl for any number of BVHs at once: leaves, then nodes, the lowest level of
 * all first. A group takes a tile, at most SVO_GROUP_ITEMS nodes or items of one BVH; the host lists all tiles, so that
 * many small BVHs cost no more launches than a large one.
 *
 * Leaves hold the corners of their triangles, which are found or made here too.
 */
#include "rays/bvh_fit.h"

#include <math.h>

#include "rays/programs.h"
#include "shared/layout.h"

/* ---- corners: where they come from ---- */

/*
 * Where the leaves' corners come from: the mesh's floats as they are, if double can tell apart what the float stage of
 * rays computes of them; else floats in grid units, and with fp64 doubles in world units, which kernels/bvh/corners.cl
 * makes. Without fp64 the host makes the floats.
 */

/* Widths of grids, world units, in which the products of the float stage are within the range of floats. */
#define WORLD_WIDTH_MIN 0x1p-40
#define WORLD_WIDTH_MAX 0x1p50

static bool is_in_world(const svo_tree *tree)
{
    const double width = ldexp(1.0, (int)tree->info.snap_bits) / tree->info.scale;
    return tree->device->has_fp64 && tree->info.positions == SVO_POSITIONS_FLOAT && width >= WORLD_WIDTH_MIN &&
           width <= WORLD_WIDTH_MAX;
}

/* The buffer of the tree that has its mesh's vertices. */
static svo_tree_buffer source_of(const svo_tree *tree)
{
    return tree->info.positions == SVO_POSITIONS_FLOAT    ? SVO_TREE_POSITIONS
           : tree->info.positions == SVO_POSITIONS_DOUBLE ? SVO_TREE_POSITIONS_DOUBLE
                                                          : SVO_TREE_VERTICES;
}

/* ---- corners with fp64 ---- */

static svo_status make_on_device(const svo_tree *tree, svo_i_device_work *work, svo_i_corners *out)
{
    const svo_tree_info *info = &tree->info;
    const cl_double4 grid = {{info->origin[0], info->origin[1], info->origin[2], info->scale}};
    const cl_uint positions = info->positions;
    const cl_uint count = (cl_uint)(info->vertex_count * 3);
    SVO_I_TRY(svo_i_work_result(work, "ray_corners", count * sizeof(cl_float), &out->made[0]));
    SVO_I_TRY(svo_i_work_result(work, "ray_corners_double", count * sizeof(cl_double), &out->made[1]));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[source_of(tree)]),
                                        SVO_I_ARGUMENT(out->made[0]),
                                        SVO_I_ARGUMENT(out->made[1]),
                                        SVO_I_ARGUMENT(grid),
                                        SVO_I_ARGUMENT(positions),
                                        SVO_I_ARGUMENT(count)};
    SVO_I_TRY(svo_i_work_use(work, &svo_i_program_bvh, svo_i_bvh_defines(work->device)));
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_bvh_corners", SVO_I_ARGUMENTS(arguments), count));
    return svo_i_work_wait(work);
}

/* ---- corners without fp64 ---- */

static double world_coordinate(const svo_tree_info *info, const void *source, size_t at)
{
    return info->positions == SVO_POSITIONS_FLOAT ? (double)((const float *)source)[at]
           : info->positions == SVO_POSITIONS_DOUBLE
               ? ((const double *)source)[at]
               : info->origin[at % 3] + ((const int32_t *)source)[at] / info->scale;
}

static svo_status make_on_host(const svo_tree *tree, svo_i_device_work *work, svo_i_corners *out)
{
    const svo_tree_info *info = &tree->info;
    const svo_tree_buffer buffer = source_of(tree);
    const size_t count = (size_t)info->vertex_count * 3;
    const size_t bytes = (size_t)info->vertex_count * svo_i_tree_element_bytes(buffer);
    void *source = svo_i_alloc(&tree->memory, bytes + 1);
    float *floats = svo_i_alloc(&tree->memory, count * sizeof *floats + 1);
    svo_status status = SVO_OK;
    if (source == NULL || floats == NULL) {
        status = svo_i_device_fail(tree->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu corners",
                                   work->function, count / 3);
        goto cleanup;
    }
    SVO_I_TRY_CLEANUP(svo_i_work_read(work, tree->buffers[buffer], 0, source, bytes));
    for (size_t i = 0; i < count; ++i) {
        floats[i] = (float)((world_coordinate(info, source, i) - info->origin[i % 3]) * info->scale);
    }
    SVO_I_TRY_CLEANUP(svo_i_work_result(work, "ray_corners", count * sizeof *floats, &out->made[0]));
    SVO_I_TRY_CLEANUP(svo_i_work_write(work, out->made[0], floats, count * sizeof *floats));

cleanup:
    svo_i_free(source);
    svo_i_free(floats);
    return status;
}

/* ---- corners, either way ---- */

svo_status svo_i_corners_find(const svo_tree *tree, const char *function, cl_command_queue queue, svo_i_corners *out)
{
    svo_i_device_work work;
    *out = (svo_i_corners){.in_world = is_in_world(tree)};
    if (out->in_world) {
        out->floats = tree->buffers[SVO_TREE_POSITIONS];
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_begin(tree->device, function, queue, &work));
    const svo_status status =
        tree->device->has_fp64 ? make_on_device(tree, &work, out) : make_on_host(tree, &work, out);
    svo_i_work_end(&work);
    if (status != SVO_OK) {
        svo_i_corners_release(out);
    }
    out->floats = out->made[0];
    out->doubles = out->made[1];
    return status;
}

void svo_i_corners_release(svo_i_corners *corners)
{
    for (int i = 0; i < 2; ++i) {
        if (corners->made[i] != NULL) {
            clReleaseMemObject(corners->made[i]);
        }
    }
    *corners = (svo_i_corners){.floats = NULL};
}

/* ---- tiles ---- */

/* Items and one more, or the nodes of a level; a BVH may have fewer levels. */
typedef struct span {
    uint32_t begin, end;
} span;

static span items_of(const svo_i_device_bvh *bvh)
{
    return (span){0, bvh->item_count + 1};
}

static span nodes_of(const svo_i_device_bvh *bvh, uint32_t level)
{
    return level < bvh->level_count ? (span){bvh->level_begin[level], bvh->level_begin[level + 1]} : (span){0, 0};
}

static uint32_t tiles_of(span of)
{
    return (of.end - of.begin + SVO_GROUP_ITEMS - 1) / SVO_GROUP_ITEMS;
}

/* Appends the tiles of a span. */
static svo_bvh_tile *add_tiles(svo_bvh_tile *to, uint32_t member, span of)
{
    for (uint32_t begin = of.begin; begin < of.end; begin += SVO_GROUP_ITEMS) {
        const uint32_t end = of.end - begin < SVO_GROUP_ITEMS ? of.end : begin + SVO_GROUP_ITEMS;
        *to++ = (svo_bvh_tile){.member = member, .begin = begin, .end = end};
    }
    return to;
}

/* Counts the tiles of each launch. Returns how many there are. */
static uint64_t count_tiles(const svo_i_device_bvh *const *bvhs, svo_i_bvh_tables *to)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < to->count; ++i) {
        to->leaf_tiles += tiles_of(items_of(bvhs[i]));
        for (uint32_t level = 0; level < bvhs[i]->level_count; ++level) {
            to->level_tiles[level] += tiles_of(nodes_of(bvhs[i], level));
        }
        to->level_count = bvhs[i]->level_count > to->level_count ? bvhs[i]->level_count : to->level_count;
    }
    for (uint32_t level = 0; level < to->level_count; ++level) {
        sum += to->level_tiles[level];
    }
    return sum + to->leaf_tiles;
}

static void fill_tiles(const svo_i_device_bvh *const *bvhs, const svo_i_bvh_tables *of, svo_bvh_tile *tiles)
{
    for (uint32_t i = 0; i < of->count; ++i) {
        tiles = add_tiles(tiles, i, items_of(bvhs[i]));
    }
    for (uint32_t level = of->level_count; level-- > 0;) {
        for (uint32_t i = 0; i < of->count; ++i) {
            tiles = add_tiles(tiles, i, nodes_of(bvhs[i], level));
        }
    }
}

static svo_bvh_member member_of(const svo_i_device_bvh *bvh)
{
    return (svo_bvh_member){.first_triangle = bvh->first_triangle,
                            .item_count = bvh->item_count,
                            .item_begin = bvh->item_begin,
                            .child_begin = bvh->child_begin,
                            .node_begin = bvh->node_begin,
                            .leaf_begin = bvh->leaf_begin};
}

/* ---- tables ---- */

void svo_i_bvh_tables_free(svo_i_bvh_tables *tables)
{
    svo_i_buffer_release(&tables->members);
    svo_i_buffer_release(&tables->tiles);
    svo_i_buffer_release(&tables->extents);
    *tables = (svo_i_bvh_tables){.count = 0};
}

svo_status svo_i_bvh_tables_make(svo_device *device, const char *function, const svo_i_device_bvh *const *bvhs,
                                 uint32_t count, svo_i_bvh_tables *out)
{
    *out = (svo_i_bvh_tables){.count = count};
    const size_t tile_count = (size_t)count_tiles(bvhs, out);
    svo_bvh_tile *tiles = svo_i_alloc_zeroed(&device->memory, tile_count, sizeof *tiles);
    svo_bvh_member *members = svo_i_alloc_zeroed(&device->memory, count, sizeof *members);
    svo_status status = SVO_OK;
    if (tiles == NULL || members == NULL) {
        status = svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu tiles of %u BVHs", function,
                                   tile_count, count);
        goto cleanup;
    }
    fill_tiles(bvhs, out, tiles);
    for (uint32_t i = 0; i < count; ++i) {
        members[i] = member_of(bvhs[i]);
    }
    SVO_I_TRY_CLEANUP(
        svo_i_device_constants(device, function, "bvh_tiles", tiles, tile_count * sizeof *tiles, &out->tiles));
    SVO_I_TRY_CLEANUP(
        svo_i_device_constants(device, function, "bvh_members", members, count * sizeof *members, &out->members));
    SVO_I_TRY_CLEANUP(svo_i_device_buffer(device, function, "bvh_extents", CL_MEM_READ_WRITE,
                                          count * sizeof(svo_bvh_extent), &out->extents));
cleanup:
    svo_i_free(tiles);
    svo_i_free(members);
    if (status != SVO_OK) {
        svo_i_bvh_tables_free(out);
    }
    return status;
}

/* ---- launches ---- */

static svo_status fit_leaves(svo_i_device_work *work, const svo_i_bvh_mesh *mesh, const svo_i_device_bvh *any,
                             const svo_i_bvh_tables *tables)
{
    const cl_uint has_doubles = mesh->doubles != NULL;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(mesh->vertices),
                                        SVO_I_ARGUMENT(mesh->indices),
                                        SVO_I_ARGUMENT(mesh->triangle_ids),
                                        SVO_I_ARGUMENT(mesh->floats),
                                        SVO_I_ARGUMENT(mesh->doubles),
                                        SVO_I_ARGUMENT(any->shape[SVO_I_BVH_ORDER]),
                                        SVO_I_ARGUMENT(any->shape[SVO_I_BVH_ITEM_COUNTS]),
                                        SVO_I_ARGUMENT(any->shape[SVO_I_BVH_PLACES]),
                                        SVO_I_ARGUMENT(any->leaves),
                                        SVO_I_ARGUMENT(any->shape[SVO_I_BVH_LEAF_BOXES]),
                                        SVO_I_ARGUMENT(tables->members),
                                        SVO_I_ARGUMENT(tables->tiles),
                                        SVO_I_ARGUMENT(tables->extents),
                                        SVO_I_ARGUMENT(mesh->snap_bits),
                                        SVO_I_ARGUMENT(has_doubles)};
    return svo_i_work_launch(work, "svo_k_bvh_leaves", SVO_I_ARGUMENTS(arguments),
                             (uint64_t)tables->leaf_tiles * SVO_GROUP_ITEMS);
}

static svo_status fit_nodes(svo_i_device_work *work, const svo_i_bvh_mesh *mesh, const svo_i_device_bvh *any,
                            const svo_i_bvh_tables *tables)
{
    const cl_uint box_log2 = mesh->snap_bits - SVO_RAY_BOX_BITS;
    cl_uint first_tile = tables->leaf_tiles;
    for (uint32_t level = tables->level_count; level-- > 0;) {
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(any->shape[SVO_I_BVH_CHILDREN]),
                                            SVO_I_ARGUMENT(any->shape[SVO_I_BVH_PLACES]),
                                            SVO_I_ARGUMENT(any->shape[SVO_I_BVH_LEAF_BOXES]),
                                            SVO_I_ARGUMENT(any->shape[SVO_I_BVH_NODE_BOXES]),
                                            SVO_I_ARGUMENT(any->nodes),
                                            SVO_I_ARGUMENT(tables->members),
                                            SVO_I_ARGUMENT(tables->tiles),
                                            SVO_I_ARGUMENT(tables->extents),
                                            SVO_I_ARGUMENT(first_tile),
                                            SVO_I_ARGUMENT(box_log2)};
        SVO_I_TRY(svo_i_work_launch(work, "svo_k_bvh_refit", SVO_I_ARGUMENTS(arguments),
                                    (uint64_t)tables->level_tiles[level] * SVO_GROUP_ITEMS));
        first_tile += tables->level_tiles[level];
    }
    return SVO_OK;
}

svo_status svo_i_bvh_fit(svo_i_device_work *work, const svo_i_bvh_mesh *mesh, const svo_i_device_bvh *any,
                         const svo_i_bvh_tables *tables)
{
    SVO_I_TRY(svo_i_work_fill_zero(work, tables->extents, (uint64_t)tables->count * sizeof(svo_bvh_extent)));
    SVO_I_TRY(fit_leaves(work, mesh, any, tables));
    return fit_nodes(work, mesh, any, tables);
}

/* ---- one BVH ---- */

/* Fits, and reads the extent without waiting. */
static svo_status refit(svo_i_device_work *work, const svo_i_bvh_mesh *mesh, const svo_i_device_bvh *bvh,
                        svo_bvh_extent *extent)
{
    cl_event event = NULL;
    const cl_mem extents = bvh->tables.extents;
    SVO_I_TRY(svo_i_work_use(work, &svo_i_program_bvh, svo_i_bvh_defines(work->device)));
    SVO_I_TRY(svo_i_bvh_fit(work, mesh, bvh, &bvh->tables));
    const cl_int error =
        clEnqueueReadBuffer(work->queue, extents, CL_FALSE, 0, sizeof *extent, extent, 1, &work->last, &event);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(work->device, work->function, "clEnqueueReadBuffer", error);
    }
    svo_i_work_follow(work, event);
    return SVO_OK;
}

svo_status svo_i_bvh_refit(svo_device *device, const char *function, cl_command_queue queue, const svo_i_bvh_mesh *mesh,
                           const svo_i_device_bvh *bvh, cl_event wait, svo_bvh_extent *extent, cl_event *event)
{
    svo_i_device_work work;
    SVO_I_TRY(svo_i_work_begin_after(device, function, queue, wait != NULL ? 1 : 0, &wait, &work));
    const svo_status status = refit(&work, mesh, bvh, extent);
    if (status != SVO_OK) {
        svo_i_work_end(&work);
        return status;
    }
    svo_i_work_leave(&work, event);
    return SVO_OK;
}

svo_status svo_i_bvh_place(svo_device *device, const char *function, svo_i_device_bvh *bvh, cl_mem nodes, cl_mem leaves,
                           uint32_t node_begin, uint32_t leaf_begin)
{
    cl_mem *const held[] = {&bvh->nodes, &bvh->leaves};
    const cl_mem given[] = {nodes, leaves};
    for (int i = 0; i < 2; ++i) {
        const cl_int error = clRetainMemObject(given[i]);
        if (error != CL_SUCCESS) {
            return svo_i_device_fail_cl(device, function, "clRetainMemObject", error);
        }
        svo_i_buffer_release(held[i]);
        *held[i] = given[i];
    }
    bvh->node_begin = node_begin;
    bvh->leaf_begin = leaf_begin;
    return SVO_OK;
}
