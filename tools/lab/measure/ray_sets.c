/* SPDX-License-Identifier: MIT */
/* Coherent and incoherent rays for measurements, and a comparison of hits ray by ray. */
#include "measure/ray_sets.h"

#include <math.h>
#include <stdint.h>

#include "support/query_table.h"

/* ---- sets ---- */

#define SHADOW_OFFSET 1e-4 /* of the distance from the camera */

/* [0, 1), a multiple of 2^-24: Marsaglia, "Xorshift RNGs", 2003. */
static double random_unit(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return (double)(*state >> 40) * 0x1p-24;
}

static void normalize(double vector[3])
{
    const double length = sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
    for (int axis = 0; axis < 3; ++axis) {
        vector[axis] /= length;
    }
}

static svo_ray make_ray(const double origin[3], const double direction[3])
{
    svo_ray ray = {.t_min = 0, .t_max = INFINITY};
    for (int axis = 0; axis < 3; ++axis) {
        ray.origin[axis] = (float)origin[axis];
        ray.direction[axis] = (float)direction[axis];
    }
    return ray;
}

void ray_set_primary(const svo_camera *camera, size_t count, svo_ray *rays)
{
    size_t edge = (size_t)sqrt((double)count);
    edge = edge > 0 ? edge : 1;
    const double tangent = tan(0.5 * (double)camera->vertical_fov);
    const camera_axes axes = ray_table_axes(camera);
    const double eye[3] = {(double)camera->eye[0], (double)camera->eye[1], (double)camera->eye[2]};
    for (size_t i = 0; i < count; ++i) {
        const double across = (2.0 * ((double)(i % edge) + 0.5) / (double)edge - 1.0) * tangent;
        const double down = (2.0 * ((double)(i / edge % edge) + 0.5) / (double)edge - 1.0) * tangent;
        double direction[3];
        for (int axis = 0; axis < 3; ++axis) {
            direction[axis] = axes.forward[axis] + across * axes.right[axis] - down * axes.up[axis];
        }
        normalize(direction);
        rays[i] = make_ray(eye, direction);
    }
}

void ray_set_incoherent(const double low[3], const double high[3], size_t count, svo_ray *rays)
{
    uint64_t state = UINT64_C(0x9e3779b97f4a7c15);
    double radius = 0;
    for (int axis = 0; axis < 3; ++axis) {
        radius += (high[axis] - low[axis]) * (high[axis] - low[axis]);
    }
    radius = radius > 0 ? 0.5 * sqrt(radius) : 1.0; /* a point is met from around it */
    for (size_t i = 0; i < count; ++i) {
        const double height = 2.0 * random_unit(&state) - 1.0;
        const double angle = 6.283185307179586 * random_unit(&state);
        const double ring = sqrt(1.0 - height * height);
        const double on_sphere[3] = {ring * cos(angle), ring * sin(angle), height};
        double origin[3];
        double direction[3];
        for (int axis = 0; axis < 3; ++axis) {
            origin[axis] = 0.5 * (low[axis] + high[axis]) + radius * on_sphere[axis];
            direction[axis] = low[axis] + (high[axis] - low[axis]) * random_unit(&state) - origin[axis];
        }
        normalize(direction);
        rays[i] = make_ray(origin, direction);
    }
}

void ray_set_misses(const double low[3], const double high[3], size_t count, svo_ray *rays)
{
    ray_set_incoherent(low, high, count, rays);
    for (size_t i = 0; i < count; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            rays[i].direction[axis] = -rays[i].direction[axis];
        }
    }
}

bool ray_set_shadow(const svo_camera *camera, const svo_ray *primary, const svo_hit *hits, size_t count, svo_ray *rays)
{
    const camera_axes axes = ray_table_axes(camera);
    double sun[3];
    size_t hit_count = 0;
    for (int axis = 0; axis < 3; ++axis) {
        sun[axis] = 2.0 * axes.up[axis] + axes.right[axis] - axes.forward[axis];
    }
    normalize(sun);
    for (size_t i = 0; i < count; ++i) {
        hit_count += hits[i].triangle != SVO_NO_TRIANGLE;
    }
    for (size_t made = 0, i = 0; made < count && hit_count > 0; i = i + 1 < count ? i + 1 : 0) {
        if (hits[i].triangle != SVO_NO_TRIANGLE) {
            const double t = (double)hits[i].t * (1.0 - SHADOW_OFFSET); /* outside of the surface */
            double origin[3];
            for (int axis = 0; axis < 3; ++axis) {
                origin[axis] = (double)primary[i].origin[axis] + t * (double)primary[i].direction[axis];
            }
            rays[made++] = make_ray(origin, sun);
        }
    }
    return hit_count > 0;
}

/* ---- comparison ---- */

bool ray_ties(double a, double b)
{
    return fabs(a - b) <= 0x1p-21 * fmax(fabs(a), fabs(b));
}

/* The distance from a number's float to the next one. */
static long double float_ulp(long double number)
{
    int exponent = 0;
    (void)frexpl(number, &exponent);
    return ldexpl(1, exponent - 24 < -149 ? -149 : exponent - 24);
}

ray_t_error ray_judge_t(const oracle_ray_scene *scene, size_t triangle, const oracle_ray *ray, float t, double nearest)
{
    const long double exact = oracle_ray_plane(scene, triangle, ray);
    const long double ulp = float_ulp(exact);
    const ray_t_error error = {.beyond = exact > (long double)nearest + ulp,
                               .ulps = (double)(fabsl((long double)t - exact) / ulp)};
    return error;
}

oracle_ray ray_widen(const svo_ray *ray)
{
    oracle_ray wide = {.t_min = (double)ray->t_min, .t_max = (double)ray->t_max};
    for (int axis = 0; axis < 3; ++axis) {
        wide.origin[axis] = (double)ray->origin[axis];
        wide.direction[axis] = (double)ray->direction[axis];
    }
    return wide;
}

static void judge_one(const oracle_ray_hit *exact, uint32_t exact_id, const svo_hit *hit, size_t *wrong_ids,
                      size_t *missed)
{
    const bool met = hit->triangle != SVO_NO_TRIANGLE;
    if (exact->hit && !met) {
        ++*missed;
    } else if (exact->hit != met || (met && hit->triangle != exact_id && !ray_ties((double)hit->t, exact->t))) {
        ++*wrong_ids;
    }
}

ray_verdict ray_judge(const oracle_ray_scene *scene, const uint32_t *triangle_ids, const svo_ray *rays,
                      const svo_hit *ours, const svo_hit *theirs, size_t ray_count)
{
    ray_verdict verdict = {0};
    for (size_t i = 0; i < ray_count; ++i) {
        verdict.leaves += (double)ours[i].count / (double)ray_count;
        verdict.hits += ours[i].triangle != SVO_NO_TRIANGLE;
        if (theirs == NULL || ours[i].triangle == theirs[i].triangle) {
            continue;
        }
        ++verdict.differing;
        if (ours[i].triangle != SVO_NO_TRIANGLE && theirs[i].triangle != SVO_NO_TRIANGLE &&
            ray_ties((double)ours[i].t, (double)theirs[i].t)) {
            ++verdict.tied;
            continue;
        }
        const oracle_ray ray = ray_widen(&rays[i]);
        const oracle_ray_hit exact = oracle_ray_closest(scene, &ray);
        const uint32_t exact_id = exact.hit ? triangle_ids[exact.triangle] : SVO_NO_TRIANGLE;
        judge_one(&exact, exact_id, &ours[i], &verdict.wrong_ids, &verdict.missed);
        judge_one(&exact, exact_id, &theirs[i], &verdict.their_wrong_ids, &verdict.their_missed);
    }
    return verdict;
}

ray_verdict ray_judge_occlusion(const oracle_ray_scene *scene, const svo_ray *rays, const svo_hit *ours,
                                const svo_hit *theirs, size_t ray_count)
{
    ray_verdict verdict = {0};
    for (size_t i = 0; i < ray_count; ++i) {
        const bool occluded = ours[i].triangle != SVO_NO_TRIANGLE;
        verdict.leaves += (double)ours[i].count / (double)ray_count;
        verdict.hits += occluded;
        if (theirs == NULL || occluded == (theirs[i].triangle != SVO_NO_TRIANGLE)) {
            continue;
        }
        ++verdict.differing;
        const oracle_ray ray = ray_widen(&rays[i]);
        const bool exact = oracle_ray_closest(scene, &ray).hit;
        verdict.missed += exact && !occluded;
        verdict.wrong_ids += !exact && occluded;
        verdict.their_missed += exact && occluded;
        verdict.their_wrong_ids += !exact && !occluded;
    }
    return verdict;
}
