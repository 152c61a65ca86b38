/* SPDX-License-Identifier: MIT */
/*
 * The host side of kernels/rays/rays.clh: builds the BVH on first use, and sets the arguments of svocl's and of the
 * caller's kernels. trace.c and render.c launch.
 */
#include "rays/rays.h"

#include <math.h>

#include "core/foreign.h"
#include "rays/bvh.h"
#include "svocl/plan.h"
#include "svocl/trace.h"

/* Widths of grids, world units, in which the products of the float stage are within the range of floats. */
#define WORLD_WIDTH_MIN 0x1p-40
#define WORLD_WIDTH_MAX 0x1p50

/* Made by cmake/embed.cmake. */
extern const char svo_i_source_rays[];

/* ---- the BVH ---- */

/* The BVH on the device, derived from the tree's geometry. */
typedef struct device_bvh {
    svo_i_attachment attachment;
    cl_mem nodes, leaves;
    uint64_t node_bytes, leaf_bytes;
    float reach; /* the largest coordinate of a vertex */
    uint32_t flags; /* SVO_RAY_FLAG_* */
} device_bvh;

static void release_bvh(svo_i_attachment *attachment)
{
    device_bvh *bvh = (device_bvh *)attachment;
    cl_mem buffers[] = {bvh->nodes, bvh->leaves};
    for (size_t i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        if (buffers[i] != NULL) {
            clReleaseMemObject(buffers[i]);
        }
    }
    svo_i_free(bvh);
}

/* The tree's BVH; all zero before it is built. */
static device_bvh find_bvh(const svo_tree *tree)
{
    const svo_i_attachment *found = svo_i_attachment_find(tree->derived, release_bvh);
    return found != NULL ? *(const device_bvh *)found : (device_bvh){.node_bytes = 0};
}

/* The largest absolute coordinate, at least the width of the grid. A file may hold any number for a vertex without a
   triangle. */
static float find_reach(const int32_t *vertices, uint64_t vertex_count, uint32_t snap_bits)
{
    int64_t reach = INT64_C(1) << snap_bits;
    for (uint64_t i = 0; i < vertex_count * 3; ++i) {
        const int64_t distance = vertices[i] < 0 ? -(int64_t)vertices[i] : vertices[i];
        reach = distance > reach ? distance : reach;
    }
    return (float)reach;
}

/* Whether a vertex lies outside the grid. Then the leaf lists determine which triangles the BVH holds. */
static bool reaches_outside(const int32_t *vertices, uint64_t vertex_count, uint32_t snap_bits)
{
    bool outside = false;
    for (uint64_t i = 0; i < vertex_count * 3; ++i) {
        outside = outside || vertices[i] < 0 || vertices[i] >= (int32_t)(1u << snap_bits);
    }
    return outside;
}

/* A host array of the tree: its own, or *copy, read from the device, which the caller frees. */
static svo_status read_array(const svo_tree *tree, const char *function, cl_command_queue queue, svo_tree_buffer buffer,
                             const void **array, void **copy)
{
    *array = tree->host[buffer];
    if (tree->host[buffer] != NULL) {
        return SVO_OK;
    }
    size_t bytes = 0;
    if (svo_i_mul_size((size_t)svo_i_tree_element_count(&tree->info, buffer), svo_i_tree_element_bytes(buffer),
                       &bytes)) {
        *copy = svo_i_alloc_zeroed(&tree->memory, bytes + 1, 1);
    }
    if (*copy == NULL) {
        return svo_i_device_fail(tree->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %s", function,
                                 svo_tree_buffer_name(buffer));
    }
    *array = *copy;
    const cl_int error =
        bytes > 0 ? clEnqueueReadBuffer(queue, tree->buffers[buffer], CL_TRUE, 0, bytes, *copy, 0, NULL, NULL)
                  : CL_SUCCESS;
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(tree->device, function, "clEnqueueReadBuffer", error);
}

static svo_status upload(const svo_tree *tree, const char *function, cl_command_queue queue, const char *name,
                         const void *data, size_t bytes, cl_mem *out)
{
    SVO_I_TRY(svo_i_device_buffer(tree->device, function, name, CL_MEM_READ_ONLY, bytes, out));
    const cl_int error = clEnqueueWriteBuffer(queue, *out, CL_TRUE, 0, bytes, data, 0, NULL, NULL);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(tree->device, function, "clEnqueueWriteBuffer", error);
}

/* Builds the BVH on the host, uploads it and attaches it to the tree. */
static svo_status make_bvh(svo_tree *tree, const char *function, cl_command_queue queue, const svo_i_bvh_source *source)
{
    svo_status status = SVO_OK;
    svo_i_bvh bvh = {.nodes = NULL};
    device_bvh *to = svo_i_alloc_zeroed(&tree->memory, 1, sizeof *to);
    if (to == NULL || !svo_i_bvh_make(&tree->memory, source, &bvh)) {
        status = svo_i_device_fail(tree->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the BVH of %u triangles",
                                   function, source->triangle_count);
        goto cleanup;
    }
    const size_t node_bytes = bvh.node_count * sizeof *bvh.nodes;
    const size_t leaf_bytes = bvh.leaf_words * sizeof *bvh.leaves;
    SVO_I_TRY_CLEANUP(upload(tree, function, queue, "ray_nodes", bvh.nodes, node_bytes, &to->nodes));
    SVO_I_TRY_CLEANUP(upload(tree, function, queue, "ray_leaves", bvh.leaves, leaf_bytes, &to->leaves));
    to->attachment.destroy = release_bvh;
    to->node_bytes = node_bytes;
    to->leaf_bytes = leaf_bytes;
    to->reach = find_reach(source->vertices, tree->info.vertex_count, tree->info.snap_bits);
    to->flags =
        (source->rows == SVO_I_ROWS_WORLD ? SVO_RAY_FLAG_WORLD : 0) | (source->list != NULL ? SVO_RAY_FLAG_CLIP : 0);
    svo_i_attachment_add(&tree->derived, &to->attachment);
    to = NULL;

cleanup:
    svo_i_bvh_free(&bvh);
    if (to != NULL) {
        release_bvh(&to->attachment);
    }
    return status;
}

/* What leaves hold: the mesh's floats as they are, if double can tell apart what the float stage computes of them. */
static svo_i_leaf_rows find_rows(const svo_tree *tree)
{
    const double width = ldexp(1.0, (int)tree->info.snap_bits) / tree->info.scale;
    if (!tree->device->has_fp64) {
        return SVO_I_ROWS_GRID;
    }
    return tree->info.positions == SVO_POSITIONS_FLOAT && width >= WORLD_WIDTH_MIN && width <= WORLD_WIDTH_MAX
               ? SVO_I_ROWS_WORLD
               : SVO_I_ROWS_DOUBLE;
}

svo_status svo_i_rays_prepare(svo_tree *tree, const char *function, cl_command_queue queue)
{
    static const svo_tree_buffer buffers[] = {SVO_TREE_VERTICES,  SVO_TREE_INDICES,          SVO_TREE_TRIANGLE_IDS,
                                              SVO_TREE_POSITIONS, SVO_TREE_POSITIONS_DOUBLE, SVO_TREE_LIST};
    enum { COUNT = sizeof buffers / sizeof buffers[0], LIST = COUNT - 1 };
    const svo_tree_info *info = &tree->info;
    const void *arrays[COUNT] = {NULL};
    void *copies[COUNT] = {NULL};
    svo_status status = SVO_OK;
    if (find_bvh(tree).leaves != NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_device_queue(tree->device, function, queue, &queue));
    for (int i = 0; i < LIST; ++i) {
        if (svo_i_tree_holds(info, buffers[i])) {
            SVO_I_TRY_CLEANUP(read_array(tree, function, queue, buffers[i], &arrays[i], &copies[i]));
        }
    }
    if (reaches_outside(arrays[0], info->vertex_count, info->snap_bits)) {
        SVO_I_TRY_CLEANUP(read_array(tree, function, queue, buffers[LIST], &arrays[LIST], &copies[LIST]));
    }
    const svo_i_bvh_source source = {.vertices = arrays[0],
                                     .indices = arrays[1],
                                     .triangle_ids = arrays[2],
                                     .positions = arrays[3],
                                     .positions_double = arrays[4],
                                     .rows = find_rows(tree),
                                     .origin = {info->origin[0], info->origin[1], info->origin[2]},
                                     .scale = info->scale,
                                     .list = arrays[LIST],
                                     .list_count = info->list_count,
                                     .triangle_count = (uint32_t)info->list_triangle_count,
                                     .snap_bits = info->snap_bits};
    SVO_I_TRY_CLEANUP(make_bvh(tree, function, queue, &source));

cleanup:
    for (int i = 0; i < COUNT; ++i) {
        svo_i_free(copies[i]);
    }
    return status;
}

svo_status svo_tree_prepare_rays(svo_tree *tree, cl_command_queue queue)
{
    static const char function[] = "svo_tree_prepare_rays";
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(svo_i_rays_check(tree, function));
    return svo_i_rays_prepare(tree, function, queue);
}

uint64_t svo_tree_ray_bytes(const svo_tree *tree)
{
    const svo_i_ray_buffers buffers = tree != NULL ? svo_i_rays_buffers(tree) : (svo_i_ray_buffers){.nodes = NULL};
    return buffers.node_bytes + buffers.leaf_bytes;
}

svo_i_ray_buffers svo_i_rays_buffers(const svo_tree *tree)
{
    const device_bvh bvh = find_bvh(tree);
    return (svo_i_ray_buffers){bvh.nodes, bvh.leaves, bvh.node_bytes, bvh.leaf_bytes};
}

/* ---- kernel arguments ---- */

/* Splits a double into an exact sum of three floats; false beyond the range of floats. */
static bool split(double value, float parts[3])
{
    if (!(fabs(value) < 0x1p120) || (value != 0 && fabs(value) < 0x1p-70)) {
        return false;
    }
    for (int i = 0; i < 3; ++i) {
        parts[i] = (float)value;
        value -= (double)parts[i];
    }
    return true;
}

svo_status svo_i_rays_params(svo_device *device, const char *function, const svo_grid *grid, double edge,
                             svo_ray_params *params)
{
    bool fits = split(grid->scale, params->scale);
    for (int axis = 0; axis < 3 && fits; ++axis) {
        float parts[3] = {0};
        /* A corner this close to zero counts as zero. */
        fits = split(fabs(grid->origin[axis]) < edge * 0x1p-60 ? 0.0 : grid->origin[axis], parts);
        for (int part = 0; part < 3; ++part) {
            params->origin[3 * part + axis] = parts[part];
        }
    }
    if (!fits) {
        return svo_i_device_fail(device, SVO_UNSUPPORTED,
                                 "%s: a grid of edge %g at %g, %g, %g is beyond the range of rays in floats", function,
                                 edge, grid->origin[0], grid->origin[1], grid->origin[2]);
    }
    params->depth = grid->depth;
    params->snap_bits = grid->snap_bits;
    return SVO_OK;
}

svo_status svo_i_rays_tree_params(const svo_tree *tree, const char *function, svo_ray_params *params)
{
    svo_grid grid = {.depth = 0};
    SVO_I_TRY(svo_tree_get_grid(tree, &grid));
    SVO_I_TRY(svo_i_rays_params(tree->device, function, &grid, tree->info.edge, params));
    params->inner_count = (cl_uint)tree->info.inner_count;
    params->reach = find_bvh(tree).reach;
    params->flags = find_bvh(tree).flags;
    return SVO_OK;
}

bool svo_i_rays_of_triangles(const svo_tree_info *info)
{
    return (info->need & SVO_NEED_RAYS) != 0 && info->coverage != SVO_COVERAGE_THIN;
}

svo_status svo_i_rays_check(const svo_tree *tree, const char *function)
{
    SVO_I_TRY(svo_i_tree_check(tree, function));
    if ((tree->info.need & SVO_NEED_RAYS) == 0) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT,
                                 "%s: the tree holds no leaf lists; build it with SVO_NEED_RAYS", function);
    }
    if (tree->info.coverage == SVO_COVERAGE_THIN) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT,
                                 "%s: the tree's coverage is thin, which leaves out voxels that triangles touch",
                                 function);
    }
    if (tree->device == NULL) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT,
                                 "%s: the tree is not on a device; call svo_tree_upload first", function);
    }
    return SVO_OK;
}

svo_status svo_i_rays_set_tree(svo_tree *tree, const char *function, cl_kernel kernel, cl_uint first_index)
{
    svo_ray_params params = {.depth = 0};
    /* Voxels need no BVH. */
    if (svo_i_rays_of_triangles(&tree->info)) {
        SVO_I_TRY(svo_i_rays_check(tree, function));
        SVO_I_TRY(svo_i_rays_prepare(tree, function, NULL));
    }
    SVO_I_TRY(svo_i_rays_tree_params(tree, function, &params));
    const device_bvh bvh = find_bvh(tree);
    const svo_i_argument arguments[SVO_TREE_ARGUMENTS] = {
        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]), SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
        SVO_I_ARGUMENT(bvh.nodes), SVO_I_ARGUMENT(bvh.leaves), SVO_I_ARGUMENT(params)};
    return svo_i_kernel_set_from(tree->device, function, kernel, first_index, arguments, SVO_TREE_ARGUMENTS);
}

static svo_status check_target(void *tree, const char *function)
{
    return svo_i_rays_check(tree, function);
}

static svo_status set_target(void *tree, const char *function, cl_kernel kernel, cl_uint first_index)
{
    return svo_i_rays_set_tree(tree, function, kernel, first_index);
}

svo_i_ray_target svo_i_rays_target(svo_tree *tree)
{
    return (svo_i_ray_target){tree, SVO_TREE_ARGUMENTS, check_target, set_target};
}

/* Voxels need no leaf lists. */
static svo_status check_voxels(void *of, const char *function)
{
    const svo_tree *tree = of;
    SVO_I_TRY(svo_i_tree_check(tree, function));
    return tree->device != NULL
               ? SVO_OK
               : svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT,
                                   "%s: the tree is not on a device; call svo_tree_upload first", function);
}

/* The arguments of a tree, without triangles. */
static svo_status set_voxels(void *of, const char *function, cl_kernel kernel, cl_uint first_index)
{
    const svo_tree *tree = of;
    const cl_mem none = NULL;
    svo_ray_params params = {.depth = 0};
    SVO_I_TRY(svo_i_rays_tree_params(tree, function, &params));
    const svo_i_argument arguments[SVO_TREE_ARGUMENTS] = {
        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]), SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
        SVO_I_ARGUMENT(none), SVO_I_ARGUMENT(none), SVO_I_ARGUMENT(params)};
    return svo_i_kernel_set_from(tree->device, function, kernel, first_index, arguments, SVO_TREE_ARGUMENTS);
}

svo_i_ray_target svo_i_voxels_target(svo_tree *tree)
{
    return (svo_i_ray_target){tree, SVO_TREE_ARGUMENTS, check_voxels, set_voxels};
}

svo_status svo_tree_set_args(svo_tree *tree, cl_kernel kernel, cl_uint first_index)
{
    static const char function[] = "svo_tree_set_args";
    if (tree == NULL || kernel == NULL) {
        return svo_i_device_fail(tree != NULL ? tree->device : NULL, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                 tree == NULL ? "tree" : "kernel");
    }
    SVO_I_TRY(svo_i_tree_check(tree, function));
    if (tree->device == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const char *wrong = svo_i_wrong_kernel(tree->device->context, kernel);
    if (wrong != NULL) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: kernel %s", function, wrong);
    }
    return svo_i_rays_set_tree(tree, function, kernel, first_index);
}

const char *svo_tree_kernel_source(void)
{
    return svo_i_source_rays;
}

const char *svo_tree_kernel_options(void)
{
    return "-cl-std=CL1.2";
}
