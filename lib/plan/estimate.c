/* SPDX-License-Identifier: MIT */
/*
 * The fragment estimate: the expected number of voxels that a triangle touches, over random offsets of the grid. For
 * bounding widths w, area A, unit normal n and voxels of edge h it is
 *
 *   E = 1 + (wx + wy + wz) / h + A (|nx| + |ny| + |nz|) / h^2.
 *
 * The last product is the sum of the areas of the three projections.
 *
 * Triangles that reach outside the grid are clipped to it (Sutherland and Hodgman, "Reentrant Polygon Clipping", 1974).
 *
 * All of it is in integers, so that kernels/plan/classify.cl finds the same numbers. Cuts are rounded to grid units,
 * 2^8 and more of which make a voxel: the estimate only sizes buffers, and a list that does not fit is drawn again.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "plan/estimate.h"

/* Fragments per triangle at which leaves are about as large as triangles. */
#define RAY_PAIRS_PER_TRIANGLE 6.0
/* The largest depth of a grid of 2^20 units. */
#define RAY_DEPTH_MAX 12u

/* A triangle cut by six planes has at most nine corners. */
#define CORNERS_MAX 9

typedef struct polygon {
    int32_t corners[CORNERS_MAX][3];
    unsigned count;
} polygon;

/* Keeps the part with side * x[axis] <= side * bound. Coordinates are below 2^29, so products fit 61 bits. */
static polygon cut(const polygon *from, unsigned axis, int32_t side, int32_t bound)
{
    polygon to = {.count = 0};
    for (unsigned i = 0; i < from->count; ++i) {
        const int32_t *a = from->corners[i];
        const int32_t *b = from->corners[(i + 1) % from->count];
        const int32_t a_depth = side * (bound - a[axis]);
        const int32_t b_depth = side * (bound - b[axis]);
        if (a_depth >= 0 && to.count < CORNERS_MAX) {
            memcpy(to.corners[to.count++], a, sizeof to.corners[0]);
        }
        if ((a_depth >= 0) != (b_depth >= 0) && to.count < CORNERS_MAX) {
            for (unsigned k = 0; k < 3; ++k) {
                to.corners[to.count][k] = a[k] + (int32_t)((int64_t)(b[k] - a[k]) * a_depth / (a_depth - b_depth));
            }
            ++to.count;
        }
    }
    return to;
}

/* Clips to a grid of so many units. */
static polygon clip_to_grid(const int32_t corners[3][3], int32_t units)
{
    polygon p = {.count = 3};
    memcpy(p.corners, corners, 3 * sizeof p.corners[0]);
    for (unsigned axis = 0; axis < 3; ++axis) {
        bool above = false;
        bool below = false;
        for (unsigned corner = 0; corner < p.count; ++corner) {
            above = above || p.corners[corner][axis] > units;
            below = below || p.corners[corner][axis] < 0;
        }
        p = above ? cut(&p, axis, 1, units) : p;
        p = below ? cut(&p, axis, -1, 0) : p;
    }
    return p;
}

static uint64_t sum_of_widths(const polygon *p)
{
    uint64_t sum = 0;
    for (unsigned axis = 0; axis < 3 && p->count > 0; ++axis) {
        int32_t low = p->corners[0][axis];
        int32_t high = low;
        for (unsigned i = 1; i < p->count; ++i) {
            const int32_t x = p->corners[i][axis];
            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        sum += (uint64_t)(high - low);
    }
    return sum;
}

/* Twice the sum of the areas of the three projections. */
static uint64_t sum_of_doubled_areas(const polygon *p)
{
    uint64_t sum = 0;
    for (unsigned axis = 0; axis < 3; ++axis) {
        const unsigned u = (axis + 1) % 3;
        const unsigned v = (axis + 2) % 3;
        int64_t doubled = 0;
        for (unsigned i = 1; i + 1 < p->count; ++i) {
            const int32_t *a = p->corners[0];
            const int32_t *b = p->corners[i];
            const int32_t *c = p->corners[i + 1];
            doubled += (int64_t)(b[u] - a[u]) * (c[v] - a[v]) - (int64_t)(b[v] - a[v]) * (c[u] - a[u]);
        }
        sum += (uint64_t)llabs(doubled);
    }
    return sum;
}

void svo_i_estimate_sums(const int32_t corners[3][3], uint32_t units_log2, uint64_t *widths, uint64_t *doubled_areas)
{
    const polygon part = clip_to_grid(corners, (int32_t)(1u << units_log2));
    *widths = sum_of_widths(&part);
    *doubled_areas = sum_of_doubled_areas(&part);
}

float svo_i_estimate_add(svo_plan *plan, const uint32_t corners[3])
{
    int32_t snapped[3][3];
    uint64_t widths = 0;
    uint64_t doubled_areas = 0;
    for (unsigned corner = 0; corner < 3; ++corner) {
        memcpy(snapped[corner], plan->vertices + (size_t)corners[corner] * 3, sizeof snapped[corner]);
    }
    svo_i_estimate_sums((const int32_t(*)[3])snapped, plan->info.snap_bits, &widths, &doubled_areas);
    /* One fragment in units of the last term's, 1 / (2 h^2). The sum is below 2^52. */
    const uint32_t one_log2 = 2 * plan->voxel_log2 + 1;
    const uint64_t scaled = (UINT64_C(1) << one_log2) + (widths << (plan->voxel_log2 + 1)) + doubled_areas;
    plan->sums.widths += widths;
    plan->sums.areas_low += doubled_areas & UINT32_MAX;
    plan->sums.areas_high += doubled_areas >> 32;
    return (float)scaled * (1.0f / (float)(UINT64_C(1) << one_log2));
}

void svo_i_estimate_end(svo_plan *plan)
{
    plan->sums.areas_high += plan->sums.areas_low >> 32;
    plan->sums.areas_low &= UINT32_MAX;
    plan->estimate[0] = (double)plan->triangle_count;
    plan->estimate[1] = (double)plan->sums.widths;
    plan->estimate[2] = 0.5 * ((double)plan->sums.areas_high * 4294967296.0 + (double)plan->sums.areas_low);
}

double svo_i_plan_expected(const svo_plan *plan, uint32_t level)
{
    const double voxel = (double)(1u << (plan->info.snap_bits - level));
    return plan->estimate[0] + plan->estimate[1] / voxel + plan->estimate[2] / (voxel * voxel);
}

uint32_t svo_i_plan_ray_depth(const svo_plan *plan)
{
    uint32_t depth = SVO_DEPTH_MIN;
    while (depth < RAY_DEPTH_MAX &&
           svo_i_plan_expected(plan, depth + 1) <= RAY_PAIRS_PER_TRIANGLE * plan->estimate[0]) {
        ++depth;
    }
    return depth;
}

uint64_t svo_i_with_slack(double expected)
{
    const double least = expected + 64.0; /* with few triangles the relative error is larger */
    return expected > 0.0 ? (uint64_t)(expected * 1.125 + fmin(least, 1024.0)) : 0;
}

uint32_t svo_i_plan_fragment_bytes(const svo_plan *plan)
{
    return 4u * (plan->info.depth <= SVO_CODE30_DEPTH_MAX ? SVO_FRAGMENT_WORDS_30 : SVO_FRAGMENT_WORDS_48);
}

uint64_t svo_i_plan_level_nodes(const svo_plan *plan, uint32_t level, uint64_t fragments, bool worst_case)
{
    uint64_t nodes = UINT64_C(1) << (3 * level);
    if (level == 0) {
        return nodes; /* the root always exists */
    }
    nodes = nodes > fragments ? fragments : nodes;
    const uint64_t likely = svo_i_with_slack(svo_i_plan_expected(plan, level));
    return !worst_case && likely < nodes ? likely : nodes;
}

uint64_t svo_i_plan_inner_nodes(const svo_plan *plan, uint64_t fragments, bool worst_case)
{
    uint64_t total = 0;
    for (uint32_t level = 0; level < plan->info.depth; ++level) {
        total += svo_i_plan_level_nodes(plan, level, fragments, worst_case);
    }
    return total;
}
