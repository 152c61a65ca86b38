/* SPDX-License-Identifier: MIT */
/*
 * The rays of photons, for the batches of kernels/rays: the first of three steps from sources to leaves; photons.cl has
 * the others.
 *
 * Launch: one work-item per photon, rounded up to whole groups. Reads the weights of the launch's photons, writes one
 * ray each; those without weight get a ray that meets nothing. No atomics, no local memory.
 */
#include "light/light_view.clh"

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
svo_k_light_rays(__global const svo_photon_weight *weights, __global svo_ray *rays, svo_light_view_params view)
{
    const uint item = (uint)get_global_id(0);
    if (item >= view.count) {
        return;
    }
    float x;
    float y;
    svo_photon_pixel(&view, view.first + item, &x, &y);
    const float3 direction = svo_photon_direction(&view, x, y);
    float3 origin = svo_view_vector(view.base);
    if (view.parallel != 0u) {
        origin += x * svo_view_vector(view.right) + y * svo_view_vector(view.up);
    }
    svo_set_ray(rays + item, origin, direction, weights[item].flux != 0u);
}
