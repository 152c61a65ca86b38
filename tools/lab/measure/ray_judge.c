/* SPDX-License-Identifier: MIT */
/* Compares hits ray by ray. */
#include "measure/ray_judge.h"

#include <math.h>

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
