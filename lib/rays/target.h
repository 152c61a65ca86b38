/* SPDX-License-Identifier: MIT */
/* What rays are traced against: a built tree's triangles or voxels, a compact tree. */
#ifndef SVO_LIB_RAYS_TARGET_H
#define SVO_LIB_RAYS_TARGET_H

#include "core/program.h"

typedef struct svo_i_ray_target {
    void *of;
    cl_uint arguments; /* that SVO_TREE_PARAMETERS declares */
    /* Whether rays can be traced; function: for the message. */
    svo_status (*check)(void *of, const char *function);
    /* Sets those arguments, from first_index on. */
    svo_status (*set)(void *of, const char *function, cl_kernel kernel, cl_uint first_index);
} svo_i_ray_target;

#endif
