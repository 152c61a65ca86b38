/* SPDX-License-Identifier: MIT */
/*
 * What photons meet of a tree of voxels some of which show in part. A photon goes through such a voxel or stops there;
 * of the photons that come to one as many stop as its alpha tells. As in sent_photons.cl their numbers decide, which
 * are spread over the view. Compiled with -DSVO_CLEAR_NODES.
 *
 * Launch: one work-item per photon. Reads the tree, its colors and the rays; writes hits. No atomics, no local memory.
 */
#ifdef SVO_CLEAR_NODES

#include "light/light_view.clh"
#include "light/sobol.clh"
#include "rays/rays.clh"

/* Photons of a view are stopped like the rays of sets of so many. */
#define SVO_VOXEL_PHOTON_SET 256u

/* groups: of the photons that are shot, as svo_photon_number has it. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_photon_voxel(SVO_TREE_PARAMETERS, __global const uchar *colors, __global const svo_ray *rays,
                   __global svo_voxel_hit *hits, __global const uint *groups, svo_onward_params onward,
                   svo_light_view_params view)
{
    const uint photon = (uint)get_global_id(0);
    if (photon >= onward.count) {
        return;
    }
    const uint number = svo_photon_number(&view, groups, photon);
    const float place = svo_sobol_pair(number, svo_hash(onward.seed)).x;
    SVO_TREE_MAKE(tree);
    tree.seen.colors = colors;
    tree.seen.color_step = (onward.flags & SVO_ONWARD_ONE_COLOR) != 0u ? 0u : 1u;
    tree.seen.index = 0u;
    tree.seen.ray.index = (uint)(place * (float)SVO_VOXEL_PHOTON_SET);
    tree.seen.ray.count = SVO_VOXEL_PHOTON_SET;
    const svo_ray ray = rays[photon];
    svo_voxel_hit hit;
    svo_trace_voxel(&tree, &ray, 0.0f, &hit);
    hits[photon] = hit;
}

#endif
