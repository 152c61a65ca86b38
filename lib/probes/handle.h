/* SPDX-License-Identifier: MIT */
/*
 * The fields of probes, and what the files of this room share.
 *
 * The room, each file after those that it uses:
 *   handle     this: the fields
 *   encoding   what texels store, on the host: tables of codes, directions
 *   plan       what probes look at; options, checks, sizes
 *   clear      what probes see of trees that show in part
 *   place      where probes are: those in bad places are moved or switched off
 *   probes     creation, stage by stage: texels, radiance, the field, prefiltered maps; description, hash
 *   trace      rays through probes, diffuse light, the caller's kernels
 */
#ifndef SVO_LIB_PROBES_HANDLE_H
#define SVO_LIB_PROBES_HANDLE_H

#include "core/tree.h"
#include "core/work.h"
#include "shared/probe_layout.h"
#include "svocl/probes.h"

struct svo_probes {
    svo_tree *tree; /* the caller's; NULL: of a scene */
    svo_scene *scene; /* the caller's; NULL: of a tree */
    svo_light *light; /* the caller's; NULL: no radiance */
    svo_device *device; /* the tree's or the scene's */
    svo_probe_info info;
    svo_probes_params params; /* of its kernels */
    bool is_clear; /* some of what they see shows in part */
    uint32_t cones; /* svo_probe_options.cones */
    cl_mem buffers[SVO_PROBES_BUFFER_COUNT]; /* owned; NULL where not held */
    cl_mem sky_map; /* of the light that texels have; retained; NULL: none */
};

/* Launches of rays of texels: their scratch buffers. */
typedef struct svo_i_probe_bands {
    svo_probes *probes;
    svo_i_device_work *work;
    uint32_t most_rays; /* of a band */
    uint32_t hit_words;
    cl_mem rays, hits; /* of most_rays; hits: NULL where none are needed */
    cl_mem thresholds; /* svo_i_probe_thresholds; NULL like hits */
} svo_i_probe_bands;

#endif
