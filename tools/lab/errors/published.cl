/* SPDX-License-Identifier: MIT */
/*
 * Gathering as published, for comparison (Crassin et al., "Interactive Indirect Illumination Using Voxel Cone Tracing",
 * 2011, in the form of the systems that followed it): five equal cones through bricks without direction, one sample
 * per node, at its entry, then on to the node's exit. The level is the coarsest whose cells have a diagonal below the
 * cone's radius; levels are not blended, and opacity is not corrected for the length of the step. A step ends a little
 * beyond its face, else the march would stall there.
 *
 * Behind the source of lights, of which it takes more than integrators are promised: fields, frames, sets of cones.
 * Launch: one work-item per point. Reads: the light, svo_gather_point. Writes: svo_gather_result. No local memory, no
 * atomics.
 */

#define PUBLISHED_CONES 5u
/* Beyond a face, in voxels. */
#define PUBLISHED_NUDGE 1e-3f
/* Of a unit cube. */
#define PUBLISHED_DIAGONAL 1.73205081f

/* The distance along a line from inside a box to where it leaves it. */
static float published_exit(float3 position, float3 direction, float3 low, float width)
{
    const float3 size = fmax(fabs(direction), (float3)(1e-12f));
    const float3 beyond = select(position - low, low + width - position, direction > 0.0f) / size;
    return fmax(fmin(beyond.x, fmin(beyond.y, beyond.z)), 0.0f);
}

/* One node: adds its sample, and returns the distance to its exit. */
static float published_node(const svo_light *light, const svo_march *march, float t, svo_cone_result *result)
{
    const uint depth = light->params.depth;
    const float3 position = march->origin + t * march->direction;
    const float cell = 0.5f * march->growth * t / PUBLISHED_DIAGONAL; /* as wide as its diagonal allows */
    const uint up = cell > 1.0f ? min((uint)log2(cell), depth) : 0u;
    const float width = (float)(1u << up);
    const int3 last = (int3)((1 << (int)(depth - up)) - 1);
    const int3 at = clamp(convert_int3(floor(position / width)), (int3)(0), last);
    uint left = depth - up;
    const uint node = svo_light_down(light->child_mask, light->first_child, 0u, at, &left);
    if (node == SVO_NO_NODE) {
        const int shift = (int)left - 1; /* an empty cell of this many levels above */
        return published_exit(position, march->direction, convert_float3(at >> shift << shift) * width,
                              width * (float)(1 << shift));
    }
    const svo_field_sample sample = svo_field_at(light, position, depth - up, march->direction, march->with_light);
    result->occlusion += result->pass * sample.opacity / (1.0f + march->falloff * t);
    result->radiance += result->pass * sample.radiance;
    result->pass *= 1.0f - sample.opacity;
    return published_exit(position, march->direction, convert_float3(at) * width, width);
}

static svo_cone_result published_cone(const svo_light *light, const svo_march *march, float range)
{
    svo_cone_result result = {0.0f, 1.0f, (float3)(0.0f), 0u};
    const float2 inside = svo_march_inside(march->origin, march->direction, (float)(1u << light->params.depth));
    const float end = fmin(inside.y, range);
    float t = fmax(inside.x, 0.0f);
    while (t < end && result.pass >= SVO_CONE_PASS_MIN && result.steps < SVO_CONE_STEPS_MAX) {
        t += published_node(light, march, t, &result) + PUBLISHED_NUDGE;
        result.steps += 1u;
    }
    if (march->with_light && range >= inside.y) {
        result.radiance += result.pass * svo_light_sky(light, march->direction);
    }
    return result;
}

/* Starts a voxel above the surface. */
static svo_gather_result published_gather(const svo_light *light, const svo_gather_point *point, float reach,
                                          uint with_light)
{
    svo_gather_result result = svo_gather_dark();
    float3 radiance = (float3)(0.0f);
    svo_gather_place place;
    if (!svo_gather_begin(light, point, &place)) {
        return result;
    }
    svo_march march;
    march.origin = place.voxel + place.frame.normal;
    march.own_width = MAXFLOAT;
    march.own_growth = 0.0f;
    march.step = 1.0f;
    march.falloff = 0.0f;
    march.with_light = with_light != 0u;
    const float range = reach > 0.0f ? reach / light->params.voxel_edge : MAXFLOAT;
    /* The reflection's cone comes last, as in svo_gather. */
    const uint cones = PUBLISHED_CONES + (place.has_reflection ? 1u : 0u);
    for (uint k = 0; k < cones; ++k) {
        const bool is_reflection = k == PUBLISHED_CONES;
        if (is_reflection) {
            march.direction = place.reflected;
            march.growth = 2.0f * svo_lobe_tangent(point->exponent);
        } else {
            const svo_set_cone member = svo_cone_of_set(k, PUBLISHED_CONES, SVO_SET_FIXED);
            march.direction = svo_from_frame(&place.frame, member.direction);
            march.growth = 2.0f * member.tangent;
        }
        const svo_cone_result met = published_cone(light, &march, range);
        result.steps += met.steps;
        if (is_reflection) {
            vstore3(met.radiance, 0, result.specular);
        } else {
            result.openness -= met.occlusion / (float)PUBLISHED_CONES;
            radiance += met.radiance / (float)PUBLISHED_CONES;
        }
    }
    vstore3(radiance * M_PI_F, 0, result.irradiance);
    return result;
}

/* range: world units; 0: to the end of the grid. */
__kernel void gather_as_published(SVO_LIGHT_PARAMETERS, __global const svo_gather_point *points,
                                  __global svo_gather_result *results, uint count, float range, uint with_light)
{
    const uint i = (uint)get_global_id(0);
    if (i < count) {
        SVO_LIGHT_MAKE(light);
        const svo_gather_point point = points[i];
        results[i] = published_gather(&light, &point, range, with_light);
    }
}
