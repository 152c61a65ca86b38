/* SPDX-License-Identifier: MIT */
/*
 * Radiance along rays in a lit tree, without specular light: what surfaces send everywhere. Direct light has exact
 * shadows (direct.clh), the other is gathered by cones (gather.clh). Rays that meet nothing see the sky, and so do rays
 * without a direction, at the zenith. A ray that begins later than at 0 stops at what it meets, whatever its alpha.
 *
 * Surfaces of one plane that lie near each other share what cones gather, which is nearly all of the time.
 *
 * Launch: one work-item per SVO_SHADE_RAYS consecutive rays, which share what cones gather. Reads tree, light, sources
 * and rays; writes three floats per ray. params.width: rays. No atomics, no local memory.
 */
#include "light/direct.clh"
#include "light/gather.clh"

#define SVO_SHADE_RAYS 64u

/* Surfaces share within this many leaf edges, if their normals' cosine is at least this, and if they are no farther off
   each other's plane than this, in leaf edges. */
#define SVO_SHADE_NEAR  4.0f
#define SVO_SHADE_ALIKE 0.97f
#define SVO_SHADE_OFF   0.25f

/* Surfaces for which the gathered is kept. */
#define SVO_SHADE_KEPT 4u

/* A surface, and the irradiance that cones gathered there. Threes of floats, since a float3 takes the space of four. */
typedef struct svo_shade_kept {
    float point[3], face[3];
    float irradiance[3];
} svo_shade_kept;

/* The last surfaces of a work-item at which cones gathered. */
typedef struct svo_shade_cache {
    svo_shade_kept *kept; /* an array of its own, so that the numbers stay in registers */
    uint count; /* of all */
} svo_shade_cache;

/* Where a surface finds what was gathered near it; SVO_SHADE_KEPT: nowhere. */
static uint svo_shade_cached(const svo_lit_picture *picture, const svo_lit_surface *surface,
                             const svo_shade_cache *cache)
{
    const float edge = picture->light.params.voxel_edge;
    for (uint k = 0; k < min(cache->count, SVO_SHADE_KEPT); ++k) {
        const float3 apart = surface->point - vload3(0, cache->kept[k].point);
        if (dot(surface->face, vload3(0, cache->kept[k].face)) >= SVO_SHADE_ALIKE &&
            dot(apart, apart) <= SVO_SHADE_NEAR * SVO_SHADE_NEAR * edge * edge &&
            fabs(dot(apart, surface->face)) <= SVO_SHADE_OFF * edge) {
            return k;
        }
    }
    return SVO_SHADE_KEPT;
}

/* The irradiance that cones gather at a surface. They leave the triangle's own plane: the payload's normal differs from
   leaf to leaf, which would show. The set is not turned: surfaces share what it gathers, and nothing smooths that. */
SVO_INLINED float3 svo_shade_cones(const svo_lit_picture *picture, const svo_lit_surface *surface,
                                   svo_shade_cache *cache)
{
    uint place = svo_shade_cached(picture, surface, cache);
    if (place == SVO_SHADE_KEPT) {
        svo_gather_point point = {{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}, 0.0f, {0u, 0u}};
        vstore3(surface->point, 0, point.position);
        vstore3(surface->face, 0, point.normal);
        const svo_gather_result gathered =
            svo_gather_turned(&picture->light, &point, &picture->gather, SVO_SET_FIXED, false);
        place = cache->count++ % SVO_SHADE_KEPT;
        vstore3(surface->point, 0, cache->kept[place].point);
        vstore3(surface->face, 0, cache->kept[place].face);
        vstore3(vload3(0, gathered.irradiance), 0, cache->kept[place].irradiance);
    }
    return vload3(0, cache->kept[place].irradiance);
}

/* What comes along a ray. */
SVO_INLINED float3 svo_shade_radiance(const svo_lit_picture *picture, const svo_ray *ray, svo_alpha_ray set,
                                      svo_direct_samples samples, svo_shade_cache *cache)
{
    svo_lit_surface surface;
    float3 direct;
    svo_lit_through start = svo_lit_start(0.0f);
    start.layers = ray->t_min > 0.0f ? SVO_SURFACE_LAYERS : 0u;
    if (!svo_direct_see(picture, ray, start, set, samples, &surface, &direct)) {
        return svo_light_sky(&picture->light, vload3(0, ray->direction));
    }
    svo_lit_payload(picture, &surface);
    const float3 irradiance = direct + svo_shade_cones(picture, &surface, cache);
    return surface.emission + surface.albedo * irradiance / M_PI_F;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_shade(SVO_LIT_PARAMETERS, __global const svo_ray *rays, __global float *radiance)
{
    const uint first = (uint)get_global_id(0) * SVO_SHADE_RAYS;
    const uint end = min(first + SVO_SHADE_RAYS, params.width);
    SVO_LIT_MAKE(picture);
    svo_shade_kept kept[SVO_SHADE_KEPT];
    svo_shade_cache cache = {kept, 0u};
    for (uint i = first; i < end; ++i) {
        const svo_ray ray = rays[i];
        const svo_alpha_ray set = {i % SVO_SHADE_RAYS, SVO_SHADE_RAYS};
        const svo_direct_samples samples = {i, 0u, params.source_rays_log2};
        vstore3(svo_shade_radiance(&picture, &ray, set, samples, &cache), i, radiance);
    }
}
