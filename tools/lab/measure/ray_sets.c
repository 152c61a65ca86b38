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

void ray_set_primary(const svo_camera *camera, unsigned tile, size_t count, svo_ray *rays)
{
    const size_t rows = (size_t)sqrt((double)count) / tile; /* of tiles */
    const size_t edge = (rows > 0 ? rows : 1) * tile;
    const double tangent = tan(0.5 * (double)camera->vertical_fov);
    const camera_axes axes = ray_table_axes(camera);
    const double eye[3] = {(double)camera->eye[0], (double)camera->eye[1], (double)camera->eye[2]};
    for (size_t i = 0; i < count; ++i) {
        const size_t in_tile = i % ((size_t)tile * tile);
        const size_t first = i / ((size_t)tile * tile) * tile; /* column of the tile, were the tiles in one row */
        const size_t column = first % edge + in_tile % tile;
        const size_t row = first / edge * tile % edge + in_tile / tile;
        const double across = (2.0 * ((double)column + 0.5) / (double)edge - 1.0) * tangent;
        const double down = (2.0 * ((double)row + 0.5) / (double)edge - 1.0) * tangent;
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

bool ray_set_through(const svo_ray *among, const svo_hit *hits, size_t count, svo_ray *rays)
{
    size_t made = 0;
    for (size_t i = 0; made < count && (made > 0 || i < count); ++i) {
        if (hits[i % count].triangle == SVO_NO_TRIANGLE) {
            rays[made++] = among[i % count];
        }
    }
    return made == count;
}

/* A place outside of the surface that a ray hit. */
static void find_start(const svo_ray *primary, const svo_hit *hit, double origin[3])
{
    const double t = (double)hit->t * (1.0 - SHADOW_OFFSET);
    for (int axis = 0; axis < 3; ++axis) {
        origin[axis] = (double)primary->origin[axis] + t * (double)primary->direction[axis];
    }
}

/* Two random numbers of which the point (x, y) is uniform in the unit disk. */
static void random_in_disk(uint64_t *state, double *x, double *y)
{
    do {
        *x = 2.0 * random_unit(state) - 1.0;
        *y = 2.0 * random_unit(state) - 1.0;
    } while (*x * *x + *y * *y >= 1.0);
}

/* A direction about a unit normal by the cosine: the disk below the hemisphere, projected up onto it (Malley's
   method). */
static void random_about(uint64_t *state, const double normal[3], double direction[3])
{
    const int least = fabs(normal[0]) < fabs(normal[1]) ? (fabs(normal[0]) < fabs(normal[2]) ? 0 : 2)
                                                        : (fabs(normal[1]) < fabs(normal[2]) ? 1 : 2);
    double first[3] = {0, 0, 0}, x, y;
    first[least] = 1;
    for (int axis = 0; axis < 3; ++axis) {
        first[axis] -= normal[least] * normal[axis];
    }
    normalize(first);
    const double second[3] = {normal[1] * first[2] - normal[2] * first[1], normal[2] * first[0] - normal[0] * first[2],
                              normal[0] * first[1] - normal[1] * first[0]};
    random_in_disk(state, &x, &y);
    for (int axis = 0; axis < 3; ++axis) {
        direction[axis] = x * first[axis] + y * second[axis] + sqrt(1.0 - x * x - y * y) * normal[axis];
    }
}

bool ray_set_diffuse(const svo_ray *primary, const svo_hit *hits, float t_max, size_t count, svo_ray *rays)
{
    uint64_t state = UINT64_C(0x9e3779b97f4a7c15);
    size_t made = 0;
    for (size_t i = 0; made < count && (made > 0 || i < count); ++i) {
        const svo_hit *hit = &hits[i % count];
        const svo_ray *ray = &primary[i % count];
        if (hit->triangle == SVO_NO_TRIANGLE) {
            continue;
        }
        double along = 0, normal[3], origin[3], direction[3];
        for (int axis = 0; axis < 3; ++axis) {
            along += (double)ray->direction[axis] * (double)hit->normal[axis];
        }
        for (int axis = 0; axis < 3; ++axis) {
            normal[axis] = along > 0 ? -(double)hit->normal[axis] : (double)hit->normal[axis];
        }
        find_start(ray, hit, origin);
        random_about(&state, normal, direction);
        rays[made] = make_ray(origin, direction);
        rays[made++].t_max = t_max;
    }
    return made == count;
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
            double origin[3];
            find_start(&primary[i], &hits[i], origin);
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
