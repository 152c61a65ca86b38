/* SPDX-License-Identifier: MIT */
/* A tree as a target. */
#include "rays/batch.h"
#include "rays/camera.h"
#include "rays/picture.h"
#include "rays/rays.h"
#include "rays/target.h"

static svo_device *device_of(const void *tree)
{
    return ((const svo_tree *)tree)->device;
}

static const char *kernel_options(const void *tree)
{
    (void)tree;
    return SVO_I_KERNEL_OPTIONS;
}

static const struct svo_target_class tree_class = {.name = "tree",
                                                   .device = device_of,
                                                   .trace_triangles = svo_i_tree_trace_triangles,
                                                   .trace_voxels = svo_i_tree_trace_voxels,
                                                   .render = svo_i_tree_render,
                                                   .fit_camera = svo_i_tree_fit_camera,
                                                   .kernel_source = svo_i_tree_kernel_source,
                                                   .kernel_options = kernel_options,
                                                   .set_kernel_arguments = svo_i_tree_set_kernel_arguments};

svo_target svo_tree_target(svo_tree *tree)
{
    return (svo_target){&tree_class, tree};
}
