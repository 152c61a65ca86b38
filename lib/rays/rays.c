/* SPDX-License-Identifier: MIT */
/*
 * The host side of kernels/rays/rays.clh: builds the BVH on first use, and sets the arguments of svocl's and of the
 * caller's kernels. batch.c and picture.c launch.
 */
#include "rays/rays.h"

#include <math.h>

#include "core/opencl.h"
#include "core/submit.h"
#include "rays/bvh_device.h"
#include "rays/bvh_fit.h"
#include "svocl/plan.h"
#include "svocl/trace.h"

/* Made by cmake/embed.cmake. */
extern const char svo_i_source_rays[];

/* ---- the BVH ---- */

/* The BVH, derived from the tree's geometry. */
typedef struct tree_bvh {
    svo_i_attachment attachment;
    svo_tree *tree;
    svo_i_device_bvh bvh;
    uint32_t flags; /* SVO_RAY_FLAG_* */
    bool is_outdated; /* the geometry has changed since */
    bool follows; /* the newest refit is of the geometry that the tree has, or that a build in flight makes */
    cl_event refitted; /* the newest refit, unless its outcome is known; else NULL */
    svo_bvh_extent extent; /* of that refit */
} tree_bvh;

static void forget_refit(tree_bvh *held)
{
    if (held->refitted != NULL) {
        clReleaseEvent(held->refitted);
        held->refitted = NULL;
    }
}

static void release_bvh(svo_i_attachment *attachment)
{
    tree_bvh *held = (tree_bvh *)attachment;
    if (held->refitted != NULL) {
        (void)svo_i_event_settle(held->refitted);
    }
    forget_refit(held);
    svo_i_bvh_release(&held->bvh);
    held->tree->ray_bytes = 0;
    svo_i_free(held);
}

/* The tree's BVH, outdated or not; NULL before it is made. */
static tree_bvh *find_any_bvh(const svo_tree *tree)
{
    return (tree_bvh *)svo_i_attachment_find(tree->derived, release_bvh);
}

/* Waits for a refit, and finds out whether it suits the tree: all triangles are in the BVH, and inside the grid. */
static void settle_refit(const svo_tree *tree, tree_bvh *held)
{
    if (held->refitted == NULL || !held->follows || tree->content == SVO_I_TREE_IN_FLIGHT) {
        return;
    }
    held->is_outdated = clWaitForEvents(1, &held->refitted) != CL_SUCCESS || held->extent.outside != 0 ||
                        tree->content != SVO_I_TREE_COMPLETE || tree->info.list_triangle_count != held->bvh.item_count;
    forget_refit(held);
}

/* The tree's BVH; NULL unless there is one that suits the geometry. */
static tree_bvh *find_bvh(const svo_tree *tree)
{
    tree_bvh *held = find_any_bvh(tree);
    if (held != NULL) {
        settle_refit(tree, held);
    }
    return held != NULL && !held->is_outdated ? held : NULL;
}

/* The tree is built anew. A BVH that can follow stays. */
static int outdate_bvh(svo_i_attachment *attachment)
{
    tree_bvh *held = (tree_bvh *)attachment;
    held->is_outdated = true;
    held->follows = false;
    return held->bvh.shape[SVO_I_BVH_CHILDREN] != NULL;
}

svo_i_bvh_mesh svo_i_rays_mesh(const svo_tree *tree, const svo_i_corners *corners)
{
    return (svo_i_bvh_mesh){.vertices = tree->buffers[SVO_TREE_VERTICES],
                            .floats = corners->floats,
                            .doubles = corners->doubles,
                            .indices = tree->buffers[SVO_TREE_INDICES],
                            .triangle_ids = tree->buffers[SVO_TREE_TRIANGLE_IDS],
                            .list = tree->buffers[SVO_TREE_LIST],
                            .vertex_count = tree->info.vertex_count,
                            .list_count = tree->info.list_count,
                            .triangle_count = (uint32_t)tree->info.list_triangle_count,
                            .snap_bits = tree->info.snap_bits};
}

/* The tree's BVH, at first without buffers. */
static svo_status hold_bvh(svo_tree *tree, const char *function, tree_bvh **out)
{
    *out = find_any_bvh(tree);
    if (*out != NULL) {
        return SVO_OK;
    }
    *out = svo_i_alloc_zeroed(&tree->memory, 1, sizeof **out);
    if (*out == NULL) {
        return svo_i_device_fail(tree->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the BVH", function);
    }
    (*out)->attachment = (svo_i_attachment){.destroy = release_bvh, .outdate = outdate_bvh};
    (*out)->tree = tree;
    svo_i_attachment_add(&tree->derived, &(*out)->attachment);
    return SVO_OK;
}

static void replace_bvh(tree_bvh *held, const svo_i_device_bvh *made, bool in_world)
{
    svo_i_bvh_release(&held->bvh);
    held->bvh = *made;
    held->tree->ray_bytes = made->node_bytes + made->leaf_bytes;
    held->is_outdated = false;
    held->flags = (in_world ? SVO_RAY_FLAG_WORLD : 0) | (made->clips ? SVO_RAY_FLAG_CLIP : 0);
}

svo_status svo_i_rays_take(svo_tree *tree, const char *function, const svo_i_device_bvh *bvh, bool in_world)
{
    tree_bvh *held = NULL;
    SVO_I_TRY(hold_bvh(tree, function, &held));
    replace_bvh(held, bvh, in_world);
    return SVO_OK;
}

svo_status svo_i_rays_make(svo_tree *tree, const char *function, cl_command_queue queue,
                           const svo_i_bvh_options *options)
{
    tree_bvh *held = NULL;
    svo_i_device_bvh made;
    svo_i_corners corners;
    SVO_I_TRY(hold_bvh(tree, function, &held));
    settle_refit(tree, held);
    SVO_I_TRY(svo_i_corners_find(tree, function, queue, &corners));
    const svo_i_bvh_mesh mesh = svo_i_rays_mesh(tree, &corners);
    const svo_status status = svo_i_bvh_make(tree->device, function, queue, &mesh, options, &made);
    if (status == SVO_OK) {
        replace_bvh(held, &made, corners.in_world);
    }
    svo_i_corners_release(&corners);
    return status;
}

svo_status svo_i_rays_refit(svo_tree *tree, const char *function, cl_command_queue queue, cl_event wait,
                            cl_event *event)
{
    tree_bvh *held = find_any_bvh(tree);
    svo_i_corners corners;
    SVO_I_TRY(svo_i_corners_find(tree, function, queue, &corners));
    svo_i_bvh_mesh mesh = svo_i_rays_mesh(tree, &corners);
    if (held->refitted != NULL) {
        (void)svo_i_event_settle(held->refitted);
    }
    forget_refit(held);
    held->is_outdated = true; /* until the outcome is known */
    const svo_status status =
        svo_i_bvh_refit(tree->device, function, queue, &mesh, &held->bvh, wait, &held->extent, &held->refitted);
    svo_i_corners_release(&corners);
    SVO_I_TRY(status);
    held->follows = true;
    cl_int error = clFlush(queue);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(tree->device, function, "clFlush", error);
    }
    if (event != NULL) {
        error = clRetainEvent(held->refitted);
        if (error != CL_SUCCESS) {
            return svo_i_device_fail_cl(tree->device, function, "clRetainEvent", error);
        }
        *event = held->refitted;
    }
    return SVO_OK;
}

/* Whether a BVH that is made now can follow a mesh that moves: all of it is there, and in the grid, and its leaves hold
   the mesh's own floats. Others are made anew. */
static bool can_follow(const svo_tree *tree)
{
    return tree->moves && tree->workspace != NULL && tree->info.positions == SVO_POSITIONS_FLOAT &&
           tree->info.list_triangle_count == tree->info.triangles;
}

/* Why the tree's BVH cannot be refit; NULL: it can. */
static const char *wrong_refit(const svo_tree *tree)
{
    const tree_bvh *held = find_any_bvh(tree);
    if (!tree->moves || tree->workspace == NULL) {
        return "tree is not of a workspace of an updatable plan, or was trimmed";
    }
    if (held == NULL) {
        return "tree has no BVH; call svo_tree_make_bvh after the first build";
    }
    return tree->content != SVO_I_TREE_COMPLETE && tree->content != SVO_I_TREE_IN_FLIGHT ? svo_i_tree_undefined(tree)
                                                                                         : NULL;
}

/* A BVH follows a mesh where its leaves hold floats and all triangles were in it, inside the grid, when it was made. */
static svo_status check_bvh(const svo_tree *tree, const char *function)
{
    const tree_bvh *held = find_any_bvh(tree);
    const bool clips = (held->flags & SVO_RAY_FLAG_CLIP) != 0;
    if ((held->flags & SVO_RAY_FLAG_WORLD) != 0 && !clips && held->bvh.shape[SVO_I_BVH_CHILDREN] != NULL) {
        return SVO_OK;
    }
    if (tree->info.positions == SVO_POSITIONS_DOUBLE) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT,
                                 "%s: the BVH was made of %llu vertices in doubles, and a refit needs floats", function,
                                 (unsigned long long)tree->info.vertex_count);
    }
    if ((held->flags & SVO_RAY_FLAG_WORLD) == 0) {
        return svo_i_device_fail(
            tree->device, SVO_INVALID_ARGUMENT,
            "%s: the BVH was made in grid units, since %s, and a refit needs the mesh's floats", function,
            tree->device->has_fp64 ? "the grid's width is not in 2^-40 .. 2^50" : "the device has no doubles");
    }
    return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT,
                             "%s: the BVH was made of %u of %llu triangles%s, and a refit needs all of them inside the "
                             "grid; make it anew",
                             function, held->bvh.item_count, (unsigned long long)tree->info.triangles,
                             clips ? ", some of which reach out of the grid" : "");
}

/* Enqueues the refit after the caller's events. The build came earlier on the caller's word. */
static svo_status refit(svo_tree *tree, const svo_i_call *call)
{
    cl_event waited = NULL;
    const cl_int error = clEnqueueMarkerWithWaitList(call->queue, call->num_wait, call->wait, &waited);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(tree->device, call->function, "clEnqueueMarkerWithWaitList", error);
    }
    const svo_status status = svo_i_rays_refit(tree, call->function, call->queue, waited, call->event);
    clReleaseEvent(waited);
    return status;
}

svo_status svo_tree_refit_bvh(svo_tree *tree, const svo_submit *submit)
{
    static const char function[] = "svo_tree_refit_bvh";
    svo_i_call call;
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (tree->device == NULL) {
        return SVO_NOT_ON_DEVICE;
    }
    const char *wrong = wrong_refit(tree);
    if (wrong != NULL) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: %s", function, wrong);
    }
    SVO_I_TRY(check_bvh(tree, function));
    SVO_I_TRY(svo_i_call_begin(tree->device, function, submit, &call));
    return svo_i_call_end(&call, refit(tree, &call));
}

svo_status svo_i_rays_prepare(svo_tree *tree, const char *function, cl_command_queue queue)
{
    const svo_i_bvh_options options = {.quality = SVO_BVH_BEST, .can_refit = can_follow(tree)};
    return svo_i_rays_buffers(tree).leaves != NULL ? SVO_OK : svo_i_rays_make(tree, function, queue, &options);
}

svo_status svo_tree_make_bvh(svo_tree *tree, svo_bvh_quality quality, cl_command_queue queue)
{
    static const char function[] = "svo_tree_make_bvh";
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(svo_i_rays_check(tree, function));
    const svo_i_bvh_options options = {.quality = quality, .can_refit = can_follow(tree)};
    if ((unsigned)quality > SVO_BVH_FAST) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: quality %d is not in 0 .. %d", function,
                                 (int)quality, (int)SVO_BVH_FAST);
    }
    const tree_bvh *held = find_bvh(tree);
    const bool is_made = held != NULL && held->bvh.leaves != NULL && held->bvh.quality == quality;
    return is_made ? SVO_OK : svo_i_rays_make(tree, function, queue, &options);
}

svo_i_ray_buffers svo_i_rays_buffers(const svo_tree *tree)
{
    const tree_bvh *held = find_bvh(tree);
    return held != NULL
               ? (svo_i_ray_buffers){held->bvh.nodes, held->bvh.leaves, held->bvh.node_bytes, held->bvh.leaf_bytes}
               : (svo_i_ray_buffers){.nodes = NULL};
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
    const tree_bvh *held = find_bvh(tree);
    SVO_I_TRY(svo_tree_get_grid(tree, &grid));
    SVO_I_TRY(svo_i_rays_params(tree->device, function, &grid, tree->info.edge, params));
    params->inner_count = (cl_uint)tree->info.inner_count;
    params->reach = held != NULL ? held->bvh.reach : 0.0F;
    params->flags = held != NULL ? held->flags : 0;
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
    if (tree->part.header.depth != 0) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT,
                                 "%s: the tree is a part of another, which rays need whole", function);
    }
    if (tree->device == NULL) {
        return SVO_NOT_ON_DEVICE;
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
    const svo_i_ray_buffers bvh = svo_i_rays_buffers(tree);
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
    return tree->device != NULL ? SVO_OK : SVO_NOT_ON_DEVICE;
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

svo_status svo_i_tree_set_kernel_arguments(void *of, const char *function, cl_kernel kernel, cl_uint first_index)
{
    svo_tree *tree = of;
    SVO_I_TRY(svo_i_tree_check(tree, function));
    return svo_i_rays_set_tree(tree, function, kernel, first_index);
}

const char *svo_i_tree_kernel_source(void)
{
    return svo_i_source_rays;
}
