/* SPDX-License-Identifier: MIT */
/* What a tree with rays keeps beside its public arrays, and what the ray kernels are given of it. */
#ifndef SVO_LIB_RAYS_RAYS_H
#define SVO_LIB_RAYS_RAYS_H

#include "core/program.h"
#include "core/tree.h"
#include "svocl/layout.h"

/* On the device, with the reach of the geometry; owned by the tree. */
struct svo_i_tree_bvh {
    cl_mem nodes, leaves; /* NULL: not prepared yet */
    uint64_t bytes; /* of both */
    float reach; /* the largest coordinate of a vertex */
};

SVO_I_SHARED_BEGIN

void svo_i_rays_release(const svo_tree *tree);

/* Whether the tree can be asked for triangles; function: for the message. */
svo_status svo_i_rays_check(const svo_tree *tree, const char *function);
/* Makes the BVH if there is none yet and waits for it. queue: NULL: one of its own. */
svo_status svo_i_rays_prepare(const svo_tree *tree, const char *function, cl_command_queue queue);
/* Sets the arguments SVO_TREE_PARAMETERS, and any others, from first_index on. */
svo_status svo_i_rays_set_tree(const svo_tree *tree, const char *function, cl_kernel kernel, cl_uint first_index);
svo_status svo_i_rays_set(const svo_tree *tree, const char *function, cl_kernel kernel, cl_uint first_index,
                          const svo_i_argument *arguments, cl_uint argument_count);

SVO_I_SHARED_END

#endif
