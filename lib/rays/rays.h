/* SPDX-License-Identifier: MIT */
/* The BVH that a tree keeps beside its public arrays, and the arguments of the ray kernels. */
#ifndef SVO_LIB_RAYS_RAYS_H
#define SVO_LIB_RAYS_RAYS_H

#include "core/program.h"
#include "core/tree.h"
#include "shared/layout.h"

SVO_I_SHARED_BEGIN

/* Whether rays can be traced against the tree's triangles. function: for the message. */
svo_status svo_i_rays_check(const svo_tree *tree, const char *function);
/* Makes the BVH unless it is there, and waits for it. queue: NULL for the device's own. */
svo_status svo_i_rays_prepare(svo_tree *tree, const char *function, cl_command_queue queue);
/* Sets the arguments SVO_TREE_PARAMETERS, and any others, from first_index on. */
svo_status svo_i_rays_set_tree(svo_tree *tree, const char *function, cl_kernel kernel, cl_uint first_index);
svo_status svo_i_rays_set(const svo_tree *tree, const char *function, cl_kernel kernel, cl_uint first_index,
                          const svo_i_argument *arguments, cl_uint argument_count);

SVO_I_SHARED_END

#endif
