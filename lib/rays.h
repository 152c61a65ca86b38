/* SPDX-License-Identifier: MIT */
/* What a tree with rays keeps beside its public arrays, and what the ray kernels are given of it. */
#ifndef SVO_LIB_RAYS_H
#define SVO_LIB_RAYS_H

#include "program.h"
#include "svocl/layout.h"
#include "tree.h"

/* A triangle as kernels/rays.clh reads it: x of the three corners and its input id, then y, then z, four words each. */
#define SVO_I_RAY_TRIANGLE_WORDS 12u
#define SVO_I_RAY_TRIANGLE_BYTES (4u * SVO_I_RAY_TRIANGLE_WORDS)
/* A wide node. */
#define SVO_I_RAY_NODE_BYTES 16u

typedef struct svo_i_snapped_mesh {
    const int32_t *vertices;
    uint64_t vertex_count;
    const uint32_t *indices;
    const uint32_t *triangle_ids;
    uint64_t triangle_count;
} svo_i_snapped_mesh;

SVO_I_SHARED_BEGIN

/*
 * Makes what the ray kernels read beside the tree's own arrays: ray_triangles from the mesh, ray_nodes from the masks on
 * the device. wait: NULL, or what the masks wait for. Waits until it is done. function: for messages.
 */
svo_status svo_i_rays_prepare(svo_tree *tree, svo_device *device, const char *function, const svo_i_snapped_mesh *mesh,
                              cl_command_queue queue, const cl_event *wait);
/* Records of ray_nodes when the levels have that many nodes. */
uint64_t svo_i_ray_node_count(const uint32_t *level_begin, uint32_t depth);
void svo_i_rays_release(svo_tree *tree);

/* Sets the arguments SVO_TREE_PARAMETERS from first_index on; returns their number in *count. */
svo_status svo_i_rays_set_args(const svo_tree *tree, const char *function, cl_kernel kernel, cl_uint first_index,
                               cl_uint *count);

SVO_I_SHARED_END

#endif
