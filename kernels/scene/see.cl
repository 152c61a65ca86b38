/* SPDX-License-Identifier: MIT */
/*
 * What the texels of probes see of a scene where some tree shows in part: of the rays of 8 x 8 texels as many meet a
 * leaf of such a tree as its alpha tells; the others go on behind it (rays/alpha.clh). With -DSVO_CLEAR_NODES; the
 * options of read.clh select how nodes are read.
 *
 * Launch: one work-item per ray, in groups of SVO_GROUP_ITEMS, rounded up to whole groups. Reads the scene, its colors
 * and the rays; writes one record per ray. No atomics, no local memory.
 */
#include "shared/layout.h"

#include "scene/record.clh"
#include "scene/walk.clh"

#ifdef SVO_CLEAR_NODES

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_scene_see(SVO_SCENE_PARAMETERS, __global const uchar *colors, __global const svo_ray *rays,
                __global SVO_SCENE_RECORD *hits, uint ray_count)
{
    const uint i = (uint)get_global_id(0);
    if (i >= ray_count) {
        return;
    }
    SVO_SCENE_MAKE(scene);
    scene.colors = colors;
    const svo_ray ray = rays[i];
    svo_scene_search search;
    search.alpha = svo_alpha_ray_of_texel(i);
    svo_scene_search_ray(&scene, &ray, 0.0f, 0u, &search);
    hits[i] = svo_scene_record(&scene, &search);
}

#endif
