/* SPDX-License-Identifier: MIT */
/*
 * What probes see of trees that show in part. Of the rays of 8 x 8 texels as many meet a leaf as its alpha tells; the
 * others go on behind it (rays/alpha.clh). Leaves of triangles are found and chosen by integers, so that texels store
 * the same on every device.
 *
 *   svo_k_probe_through   per ray that met a triangle: whether it goes on behind it; it is traced again in any case
 *   svo_k_probe_see       with -DSVO_CLEAR_NODES, per ray: the voxel that it meets
 *   svo_k_probe_reach     per ray of a texel: lets it begin right before what the texel has seen, whose radiance it
 *                         then brings, whatever the alpha
 *
 * Launch: one work-item per ray. svo_k_probe_through counts by atomics. No local memory.
 */
#include "light/photons.clh"
#include "probes/encoding.clh"
#include "probes/item.clh"
#include "rays/alpha.clh"
#include "shared/light_layout.h"
#include "shared/probe_layout.h"

#ifdef SVO_CLEAR_NODES
#include "rays/rays.clh"
#endif

/* hits: of the rays, which begin anew behind what they met, or reach that alone from now on. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_probe_through(__global const uchar *child_mask, __global const uint *first_child, __global const uint *list_begin,
                    __global const uint *list, __global const int *vertices, __global const uint *indices,
                    __global const uint *triangle_ids, __global const uchar *colors, __global const svo_hit *hits,
                    __global svo_ray *rays, volatile __global uint *through, svo_photon_params photons,
                    svo_onward_params onward)
{
    const uint i = (uint)get_global_id(0);
    if (i >= onward.count || hits[i].triangle == SVO_NO_TRIANGLE) {
        return;
    }
    const svo_list_tree tree = {child_mask, first_child, list_begin, list, vertices, indices, triangle_ids, photons};
    const svo_hit hit = hits[i];
    svo_photon_place place;
    const uint leaf = svo_leaf_of_hit(&tree, hit.triangle, hit.u, hit.v, &place);
    const size_t color = (onward.flags & SVO_ONWARD_ONE_COLOR) != 0u ? 0u : (size_t)onward.leaf_begin + leaf;
    const uint alpha = svo_is_leaf(leaf) ? colors[4u * color + 3u] : 255u;
    if (svo_alpha_shows(alpha, svo_alpha_ray_of_texel(i), svo_alpha_turn(leaf))) {
        rays[i].t_min = as_float(max(as_uint(hit.t), 1u) - 1u);
        rays[i].t_max = as_float(as_uint(hit.t) + 1u);
    } else {
        rays[i].t_min = max(hit.t + onward.offset, as_float(as_uint(hit.t) + 1u));
        atomic_inc(through);
    }
}

#ifdef SVO_CLEAR_NODES

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_probe_see(SVO_TREE_PARAMETERS, __global const uchar *colors, __global const svo_ray *rays,
                __global svo_voxel_hit *hits, svo_onward_params onward)
{
    const uint i = (uint)get_global_id(0);
    if (i >= onward.count) {
        return;
    }
    SVO_TREE_MAKE(tree);
    tree.seen.colors = colors;
    tree.seen.color_step = (onward.flags & SVO_ONWARD_ONE_COLOR) != 0u ? 0u : 1u;
    tree.seen.index = 0u;
    tree.seen.ray = svo_alpha_ray_of_texel(i);
    const svo_ray ray = rays[i];
    svo_voxel_hit hit;
    svo_trace_voxel(&tree, &ray, 0.0f, &hit);
    hits[i] = hit;
}

#endif

/* Rays of texels begin before what they have seen by this share of its distance, which is more than codes are off. */
#define SVO_PROBE_BEFORE 2e-4f

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_probe_reach(__global const uint *texels, __global svo_ray *rays, svo_probes_params params, svo_probe_step step)
{
    const uint i = (uint)get_global_id(0);
    if (i >= step.count) {
        return;
    }
    const svo_probe_item item = svo_probe_find_item(&params, &step, i);
    const float3 vector = convert_float3(svo_probe_texel_vector(params.resolution, item.column, item.row));
    const uint code = texels[2u * item.texel] & 0xffffu;
    const float seen = svo_probe_distance_of(code, &params) * (1.0f - SVO_PROBE_BEFORE);
    const float begin =
        code == SVO_PROBE_NOTHING ? 16.0f * params.farthest : seen - SVO_PROBE_BEFORE * params.leaf_edge;
    rays[i].t_min = fmax(begin / length(vector), FLT_MIN);
}
