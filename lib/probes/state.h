/* SPDX-License-Identifier: MIT */
/* The fields of probes, and what the files of this room share. */
#ifndef SVO_LIB_PROBES_STATE_H
#define SVO_LIB_PROBES_STATE_H

#include "core/tree.h"
#include "shared/probe_layout.h"
#include "svocl/probes.h"

struct svo_probes {
    svo_tree *tree; /* the caller's; NULL: of a scene */
    svo_scene *scene; /* the caller's; NULL: of a tree */
    svo_light *light; /* the caller's; NULL: no radiance */
    svo_device *device; /* the tree's or the scene's */
    svo_probe_info info;
    svo_probes_params params; /* of its kernels */
    uint32_t cones; /* svo_probe_options.cones */
    cl_mem buffers[SVO_PROBES_BUFFER_COUNT]; /* owned; NULL where not held */
};

#endif
