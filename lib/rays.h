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

typedef struct svo_i_snapped_mesh {
    const int32_t *vertices;
    uint64_t vertex_count;
    const uint32_t *indices;
    const uint32_t *triangle_ids;
    uint64_t triangle_count;
} svo_i_snapped_mesh;

SVO_I_SHARED_BEGIN

/* The records of all triangles, by malloc; NULL for none. function: for the message. */
svo_status svo_i_ray_records(svo_device *device, const char *function, const svo_i_snapped_mesh *mesh, int32_t **out);
/* The largest coordinate there is, at least the width of the grid. */
float svo_i_ray_reach(const svo_i_snapped_mesh *mesh, uint32_t snap_bits);

/* Makes ray_triangles and ray_reach of a tree whose host arrays hold lists; does nothing for others. */
svo_status svo_i_rays_upload(svo_tree *tree, svo_device *device, cl_command_queue queue);

/* Sets the arguments SVO_TREE_PARAMETERS from first_index on; returns their number in *count. */
svo_status svo_i_rays_set_args(const svo_tree *tree, const char *function, cl_kernel kernel, cl_uint first_index,
                               cl_uint *count);

SVO_I_SHARED_END

#endif
