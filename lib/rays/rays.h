/* SPDX-License-Identifier: MIT */
/*
 * What rays meet: the BVH that a tree keeps beside its public arrays, and the arguments of the ray kernels.
 *
 * The files of this room:
 *
 *   rays        the BVH of a tree, and arguments of ray kernels
 *   bvh_device  makes BVHs
 *   bvh_fit     what BVHs are; their leaves and boxes, the corners of leaves
 *   batch       rays and points in batches
 *   picture     pictures, and buffers for them
 *   camera      cameras and their frames
 *   target      the calls that take an svo_target, whatever it is of
 *   tree_target trees as targets
 */
#ifndef SVO_LIB_RAYS_RAYS_H
#define SVO_LIB_RAYS_RAYS_H

#include "core/program.h"
#include "core/tree.h"
#include "rays/bvh_device.h"
#include "rays/bvh_fit.h"
#include "shared/layout.h"
#include "svocl/nodes.h"

/* What rays are traced against: a built tree's triangles or voxels, a compact tree. */
typedef struct svo_i_ray_target {
    void *of;
    cl_uint arguments; /* that SVO_TREE_PARAMETERS declares */
    /* Whether rays can be traced; function: for the message. */
    svo_status (*check)(void *of, const char *function);
    /* Sets those arguments, from first_index on. */
    svo_status (*set)(void *of, const char *function, cl_kernel kernel, cl_uint first_index);
} svo_i_ray_target;

/* Whether a tree has triangles to meet; rays against others meet its voxels. */
bool svo_i_rays_of_triangles(const svo_tree_info *info);
/* Checks that rays can be traced against the tree's triangles. function: for the message. */
svo_status svo_i_rays_check(const svo_tree *tree, const char *function);
/* Builds the BVH unless the tree has it, and waits for it. queue: NULL for the device's own. */
svo_status svo_i_rays_prepare(svo_tree *tree, const char *function, cl_command_queue queue);
/* Makes the BVH, in place of the one that the tree may have, and waits for it. */
svo_status svo_i_rays_make(svo_tree *tree, const char *function, cl_command_queue queue,
                           const svo_i_bvh_options *options);
/* Enqueues the fit of the BVH, made with can_refit, to the tree's vertices, which have moved inside the grid, and
   flushes. wait and event: NULL allowed. */
svo_status svo_i_rays_refit(svo_tree *tree, const char *function, cl_command_queue queue, cl_event wait,
                            cl_event *event);
/* The geometry of which a tree's BVH is made. corners: of svo_i_corners_find. */
svo_i_bvh_mesh svo_i_rays_mesh(const svo_tree *tree, const svo_i_corners *corners);
/* Gives the tree a BVH of its triangles that was made elsewhere, in place of the one that it may have. bvh: nodes and
   leaves become the tree's, unless it fails. */
svo_status svo_i_rays_take(svo_tree *tree, const char *function, const svo_i_device_bvh *bvh, bool in_world);
/* The tree's BVH; all zero before it is made. */
typedef struct svo_i_ray_buffers {
    cl_mem nodes, leaves;
    uint64_t node_bytes, leaf_bytes;
} svo_i_ray_buffers;
svo_i_ray_buffers svo_i_rays_buffers(const svo_tree *tree);
/* What the ray kernels know of the tree. SVO_UNSUPPORTED: the grid is beyond the range of floats. */
svo_status svo_i_rays_tree_params(const svo_tree *tree, const char *function, svo_ray_params *params);
/* Sets the arguments that SVO_TREE_PARAMETERS declares, from first_index on. Makes the BVH if the tree has one. */
svo_status svo_i_rays_set_tree(svo_tree *tree, const char *function, cl_kernel kernel, cl_uint first_index);

SVO_I_SHARED_BEGIN

/* What the kernels know of a grid; edge: svo_tree_info.edge. */
svo_status svo_i_rays_params(svo_device *device, const char *function, const svo_grid *grid, double edge,
                             svo_ray_params *params);

SVO_I_SHARED_END

/* A tree's triangles as the target of batches; and its voxels, for which it makes no BVH. */
svo_i_ray_target svo_i_rays_target(svo_tree *tree);
svo_i_ray_target svo_i_voxels_target(svo_tree *tree);

/* svo_kernel_source and svo_kernel_set_arguments of a tree. */
const char *svo_i_tree_kernel_source(void);
svo_status svo_i_tree_set_kernel_arguments(void *of, const char *function, cl_kernel kernel, cl_uint first_index);

#endif
