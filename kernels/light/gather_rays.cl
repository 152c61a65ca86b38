/* SPDX-License-Identifier: MIT */
/*
 * Light at a batch of points by paths (paths.clh); with SVO_GATHER_CONES by cones, and beside it the light of the
 * sources, for which gather.paths is 0; with SVO_GATHER_ERRORS by cones alone, with errors that a picture smooths by.
 *
 * Launch: one work-item a point, params.width in all. Reads tree, light, sources and points; writes svo_gather_result.
 * No local memory, no atomics.
 */
#include "light/paths.clh"

/* The fewest paths of a lobe. */
#define SVO_GATHER_LOBE_LEAST 16u

/* The surface that a point is on. */
static svo_lit_surface svo_gather_surface(const svo_gather_place *place)
{
    svo_lit_surface surface;
    surface.point = place->position;
    surface.normal = surface.face = place->frame.normal;
    surface.albedo = surface.emission = surface.specular = (float3)(0.0f);
    surface.exponent = 0.0f;
    surface.node = SVO_NO_NODE;
    return surface;
}

/* How a path of a point leaves it: the sources' light first, then paths by the cosine, then those of the reflection's
   lobe. */
static svo_path_start svo_gather_next(const svo_gather_place *place, float exponent, uint number, uint seed,
                                      uint diffuse_end)
{
    svo_path_start path = {(float3)(0.0f), number > 0u && number < diffuse_end, 0u, seed};
    if (number > 0u) {
        path.index = path.is_cosine ? number - 1u : number - diffuse_end;
        path.seed = path.is_cosine ? seed : svo_hash(seed);
        path.direction = svo_path_direction(path.is_cosine ? place->frame.normal : place->reflected,
                                            path.is_cosine ? 1.0f : exponent, svo_sobol_pair(path.index, path.seed));
    }
    return path;
}

/* Paths of the lobe above the surface. */
typedef struct svo_gather_lobe {
    float3 sum, squares;
    uint count;
} svo_gather_lobe;

/* The mean of the lobe's paths and its standard error. */
static void svo_gather_end_lobe(const svo_gather_lobe *lobe, svo_gather_result *result)
{
    const float count = (float)max(lobe->count, 1u);
    const float3 mean = lobe->sum / count;
    const float3 variance = fmax(lobe->squares / count - mean * mean, (float3)(0.0f));
    vstore3(mean, 0, result->specular);
    result->specular_error = sqrt(fmax(variance.x, fmax(variance.y, variance.z)) / fmax(count - 1.0f, 1.0f));
}

SVO_INLINED svo_gather_result svo_gather_rays(const svo_lit_picture *picture, const svo_gather_point *point)
{
    const svo_gather_params *gather = &picture->gather;
    svo_gather_result result = svo_gather_dark();
    svo_gather_place place;
    if (!svo_gather_begin(&picture->light, point, &place)) {
        return result;
    }
    const svo_lit_surface surface = svo_gather_surface(&place);
    const uint seed = svo_path_seed(point);
    const bool has_lobe = place.has_reflection && gather->with_light != 0u && gather->paths > 0u;
    const uint lobe_paths = has_lobe ? max(gather->paths / 4u, SVO_GATHER_LOBE_LEAST) : 0u;
    svo_path_sums sums = {(float4)(0.0f), (float4)(0.0f), (float4)(0.0f), (float4)(0.0f), SVO_PATH_BLOCK, 0u};
    svo_gather_lobe lobe = {(float3)(0.0f), (float3)(0.0f), 0u};
    uint diffuse_end = gather->paths + 1u;
    for (uint number = gather->with_light != 0u ? 0u : 1u; number < diffuse_end + lobe_paths; ++number) {
        const svo_path_start path = svo_gather_next(&place, point->exponent, number, seed, diffuse_end);
        if (number >= diffuse_end && dot(path.direction, place.frame.normal) <= 0.0f) {
            continue; /* the lobe reaches below the surface */
        }
        const svo_path_light light = svo_path_follow(picture, &surface, &path, &result.steps);
        if (number == 0u) {
            vstore3(light.radiance, 0, result.direct);
        } else if (number < diffuse_end) {
            svo_path_add(&sums, &light);
            diffuse_end = svo_path_suffices(&sums, gather->goal) ? number + 1u : diffuse_end;
        } else {
            lobe.sum += light.radiance;
            lobe.squares += light.radiance * light.radiance;
            lobe.count += 1u;
        }
    }
    if (sums.count > 0u) {
        const float4 mean = svo_path_mean(&sums);
        const float4 error = svo_path_error(&sums);
        result.openness = 1.0f - mean.w;
        vstore3(M_PI_F * mean.xyz, 0, result.irradiance);
        result.openness_error = error.w;
        result.irradiance_error = M_PI_F * fmax(error.x, fmax(error.y, error.z));
    }
    svo_gather_end_lobe(&lobe, &result);
    return result;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_gather_rays(SVO_LIT_PARAMETERS, __global const svo_gather_point *points, __global svo_gather_result *results)
{
    const uint i = (uint)get_global_id(0);
    if (i >= params.width) {
        return;
    }
    SVO_LIT_MAKE(picture);
    const svo_gather_point point = points[i];
#ifdef SVO_GATHER_ERRORS
    results[i] = svo_gather_turned(&picture.light, &point, &gather, svo_gather_turn(&point), true);
#else
    svo_gather_result result = svo_gather_rays(&picture, &point);
#ifdef SVO_GATHER_CONES
    svo_gather_result gathered = svo_gather_by(&picture.light, &point, &gather);
    vstore3(vload3(0, result.direct), 0, gathered.direct);
    gathered.steps += result.steps;
    result = gathered;
#endif
    results[i] = result;
#endif
}
