/* SPDX-License-Identifier: MIT */
/* What a tree with rays keeps beside its public arrays, and what the ray kernels are given of it. */
#ifndef SVO_LIB_RAYS_H
#define SVO_LIB_RAYS_H

#include "program.h"
#include "svocl/layout.h"
#include "tree.h"

/* Of a list entry: x of the triangle's corners and its input id, then y, then z, four words each. */
#define SVO_I_RAY_TRIANGLE_BYTES 48u
/* Of a wide node. */
#define SVO_I_RAY_NODE_BYTES 16u

SVO_I_SHARED_BEGIN

/*
 * Makes what the ray kernels read beside the tree's own arrays, ray_triangles and ray_nodes, from the buffers of a tree
 * with lists, and waits until it is done.
 *
 * program: has kernels/widen.cl; NULL: that of the batches. vertices: the snapped ones on the host. wait: NULL, or what the
 * buffers wait for. device_ms: time of the launches; 0 where the queue does not profile. function: for messages.
 */
svo_status svo_i_rays_prepare(svo_tree *tree, svo_device *device, const char *function, cl_program program,
                              const int32_t *vertices, cl_command_queue queue, const cl_event *wait, double *device_ms);
/* Wide nodes of an octree. */
uint64_t svo_i_ray_node_count(const uint32_t *level_begin, uint32_t depth);
void svo_i_rays_release(svo_tree *tree);

/* Whether the tree can be asked for triangles; function: for the message. */
svo_status svo_i_rays_check(const svo_tree *tree, const char *function);
/* Sets the arguments SVO_TREE_PARAMETERS, and any others, from first_index on. */
svo_status svo_i_rays_set_tree(const svo_tree *tree, const char *function, cl_kernel kernel, cl_uint first_index);
svo_status svo_i_rays_set(const svo_tree *tree, const char *function, cl_kernel kernel, cl_uint first_index,
                          const svo_i_argument *arguments, cl_uint argument_count);

SVO_I_SHARED_END

#endif
