/* SPDX-License-Identifier: MIT */
/*
 * The rays of photons, for the batches of kernels/rays: the first of three steps from sources to leaves; photons.cl has
 * the others. And rays from a source to the centers of leaves, for those that no photon met.
 *
 * Launch: one work-item per photon or leaf, rounded up to whole groups. Reads the weights of the launch's photons, or
 * the slots of its leaves; writes one ray each. Photons without weight and leaves with a slot get a ray that meets
 * nothing. No atomics, no local memory.
 */
#include "light/light_view.clh"
#include "shared/nodes.clh"

static void svo_set_ray(__global svo_ray *ray, float3 origin, float3 direction, bool shot)
{
    ray->origin[0] = origin.x;
    ray->origin[1] = origin.y;
    ray->origin[2] = origin.z;
    ray->direction[0] = direction.x;
    ray->direction[1] = direction.y;
    ray->direction[2] = direction.z;
    ray->t_min = shot ? 0.0f : 1.0f;
    ray->t_max = shot ? INFINITY : 0.0f;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_rays(__global const svo_photon_weight *weights, __global svo_ray *rays, __global const uint *groups,
                 svo_light_view_params view)
{
    const uint item = (uint)get_global_id(0);
    if (item >= view.count) {
        return;
    }
    float3 origin;
    const float3 direction = svo_photon_ray(&view, svo_photon_number(&view, groups, item), &origin);
    svo_set_ray(rays + item, origin, direction, weights[item].flux != 0u);
}

/* Whether a spot or a disk shines along a vector. */
static bool svo_is_in_spot(const svo_light_source *source, float3 along, float outer_cosine)
{
    const float3 axis = svo_view_vector(source->direction);
    const float aligned = dot(along, axis);
    return aligned > 0.0f && aligned * aligned > outer_cosine * outer_cosine * dot(along, along) * dot(axis, axis);
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_unmet_rays(__global const uchar *child_mask, __global const uint *first_child, __global const uint *slots,
                 __global svo_ray *rays, svo_light_source source, svo_unmet_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count) {
        return;
    }
    const uint leaf = params.first + item;
    bool shot = slots[leaf] == SVO_SLOT_NONE;
    svo_node node;
    svo_walk_up(child_mask, first_child, params.inner_count, params.inner_count + leaf, &node);
    const float3 cell = (float3)((float)node.cell[0], (float)node.cell[1], (float)node.cell[2]);
    const float3 center = svo_view_vector(params.origin) + (cell + 0.5f) * params.edge;
    float3 origin = svo_view_vector(source.position);
    float3 direction = center - origin;
    if (source.kind == SVO_SOURCE_DIRECTIONAL) {
        direction = normalize(svo_view_vector(source.direction));
        origin = center - params.reach * direction;
    } else if (source.kind >= SVO_SOURCE_SPOT) {
        shot = shot && svo_is_in_spot(&source, direction, params.outer_cosine);
    }
    svo_set_ray(rays + item, origin, direction, shot);
}
