/* SPDX-License-Identifier: MIT */
#include "rays/batch.h"
#include "rays/target.h"

static svo_device *device_of(const void *tree)
{
    return ((const svo_tree *)tree)->device;
}

static const struct svo_target_class tree_class = {.name = "tree",
                                                   .device = device_of,
                                                   .trace_triangles = svo_i_tree_trace_triangles,
                                                   .trace_voxels = svo_i_tree_trace_voxels};

svo_target svo_tree_target(svo_tree *tree)
{
    return (svo_target){&tree_class, tree};
}
