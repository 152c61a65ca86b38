/* SPDX-License-Identifier: MIT */
/*
 * Decides what becomes of each triangle, and the expected number of its fragments. lib/plan/grid.c and estimate.c
 * explain the rules; they do the same on the host.
 *
 * Launch: one work-item per SVO_PLAN_RUN triangles, in whole groups. Writes 16 bits and a float per triangle, and a row
 * of sums per group. No atomics.
 */
#include "plan/plan.clh"
#include "shared/snap.clh"

#define SVO_NEEDLE_RATIO 4096.0
#define SVO_CORNERS_MAX  9u

/* Classes, as svo_i_class in lib/plan/plan_data.h. */
#define SVO_CLASS_POINT   0u
#define SVO_CLASS_NARROW  1u
#define SVO_CLASS_REGULAR 2u
#define SVO_CLASS_WIDE    3u

/* The position of a snapped triangle in the grid. */
typedef struct svo_placed {
    int3 low, high; /* grid units */
    int3 width; /* voxels inside the grid */
    bool far, outside, inside; /* too far to test; off the grid; wholly in it */
} svo_placed;

static svo_placed svo_place_triangle(const svo_snapped *q, const svo_plan_params *params)
{
    const int units = (int)(1u << params->snap_bits);
    const int closed = (params->flags & SVO_PLAN_CLOSED) != 0u ? 1 : 0;
    svo_placed p;
    p.low = min(min(q->a, q->b), q->c);
    p.high = max(max(q->a, q->b), q->c);
    p.far = any(p.low <= -SVO_UNITS_FAR || p.high >= SVO_UNITS_FAR);
    p.outside = any(p.high < 0 || p.low >= units + closed);
    p.inside = all(p.low >= 0 && p.high < units);
    p.width = (min(p.high, (int3)(units - 1)) >> (int3)(params->voxel_log2)) -
              (max(p.low - closed, (int3)(0)) >> (int3)(params->voxel_log2)) + 1;
    return p;
}

static uint svo_class_of(const svo_placed *p, const svo_plan_params *params)
{
    const int widest = max(max(p->width.x, p->width.y), p->width.z);
    if (!p->inside) {
        return SVO_CLASS_WIDE;
    }
    if (widest == 1 && (params->flags & SVO_PLAN_THIN) == 0u) {
        return SVO_CLASS_POINT;
    }
    if (widest <= SVO_NARROW_VOXELS) {
        return SVO_CLASS_NARROW;
    }
    return params->snap_bits <= SVO_REGULAR_BITS ? SVO_CLASS_REGULAR : SVO_CLASS_WIDE;
}

/* The squares of an edge's projections along the three axes; exact inside the grid. */
static ulong3 svo_projected_squares(int3 from, int3 to)
{
    const long3 d = convert_long3(to - from);
    const ulong3 squares = convert_ulong3(d * d);
    return squares.yzx + squares.zxy;
}

static uint svo_draw_flags(const svo_snapped *q, const svo_placed *p, ulong3 sizes, uint voxel_log2)
{
    const uint axis = svo_largest_axis(sizes);
    const ulong size = svo_component(sizes, axis);
    const int3 extent = p->high - p->low;
    if (size == 0ul) {
        const uint shortest = extent.y < extent.x ? 1u : 0u;
        return (extent.z < min(extent.x, extent.y) ? 2u : shortest) | SVO_DRAW_BOUNDS;
    }
    if (!p->inside) {
        return axis | SVO_DRAW_BOUNDS;
    }
    const ulong3 squares = max(max(svo_projected_squares(q->a, q->b), svo_projected_squares(q->b, q->c)),
                               svo_projected_squares(q->c, q->a));
    const double voxel = (double)(1u << voxel_log2);
    const double area = (double)size;
    const double squared = (double)svo_component(squares, axis);
    const bool needle = area * area < voxel * voxel * squared || area * SVO_NEEDLE_RATIO < squared;
    return axis | (needle ? SVO_DRAW_BOUNDS : 0u);
}

/* ---- the fragment estimate ---- */

typedef struct svo_polygon {
    int corners[SVO_CORNERS_MAX][3];
    uint count;
} svo_polygon;

/* Keeps the part with side * x[axis] <= side * bound. */
static void svo_cut_polygon(svo_polygon *p, uint axis, int side, int bound)
{
    const svo_polygon from = *p;
    uint count = 0;
    for (uint i = 0; i < from.count; ++i) {
        const uint next = i + 1u < from.count ? i + 1u : 0u;
        const int a_depth = side * (bound - from.corners[i][axis]);
        const int b_depth = side * (bound - from.corners[next][axis]);
        if (a_depth >= 0 && count < SVO_CORNERS_MAX) {
            for (uint k = 0; k < 3; ++k) {
                p->corners[count][k] = from.corners[i][k];
            }
            ++count;
        }
        if ((a_depth >= 0) != (b_depth >= 0) && count < SVO_CORNERS_MAX) {
            for (uint k = 0; k < 3; ++k) {
                const int a = from.corners[i][k];
                p->corners[count][k] = a + (int)((long)(from.corners[next][k] - a) * a_depth / (a_depth - b_depth));
            }
            ++count;
        }
    }
    p->count = count;
}

static ulong svo_polygon_widths(const svo_polygon *p)
{
    ulong sum = 0;
    for (uint axis = 0; axis < (p->count > 0u ? 3u : 0u); ++axis) {
        int low = p->corners[0][axis];
        int high = low;
        for (uint i = 1; i < p->count; ++i) {
            low = min(low, p->corners[i][axis]);
            high = max(high, p->corners[i][axis]);
        }
        sum += (ulong)(high - low);
    }
    return sum;
}

static ulong svo_polygon_doubled_areas(const svo_polygon *p)
{
    ulong sum = 0;
    for (uint axis = 0; axis < 3; ++axis) {
        const uint u = (axis + 1u) % 3u;
        const uint v = (axis + 2u) % 3u;
        long doubled = 0;
        for (uint i = 1; i + 1u < p->count; ++i) {
            const long bu = p->corners[i][u] - p->corners[0][u];
            const long bv = p->corners[i][v] - p->corners[0][v];
            const long cu = p->corners[i + 1u][u] - p->corners[0][u];
            const long cv = p->corners[i + 1u][v] - p->corners[0][v];
            doubled += bu * cv - bv * cu;
        }
        sum += abs(doubled);
    }
    return sum;
}

/* The sums of the part inside the grid, of a triangle that reaches outside: widths, and twice the projected areas. */
static ulong2 svo_clipped_sums(const svo_snapped *q, uint snap_bits)
{
    const int units = (int)(1u << snap_bits);
    svo_polygon p;
    p.count = 3;
    vstore3(q->a, 0, p.corners[0]);
    vstore3(q->b, 0, p.corners[1]);
    vstore3(q->c, 0, p.corners[2]);
    for (uint axis = 0; axis < 3; ++axis) {
        bool above = false;
        bool below = false;
        for (uint corner = 0; corner < p.count; ++corner) {
            above = above || p.corners[corner][axis] > units;
            below = below || p.corners[corner][axis] < 0;
        }
        if (above) {
            svo_cut_polygon(&p, axis, 1, units);
        }
        if (below) {
            svo_cut_polygon(&p, axis, -1, 0);
        }
    }
    return (ulong2)(svo_polygon_widths(&p), svo_polygon_doubled_areas(&p));
}

/* What the triangle is sorted by within its class, by the columns that the front end visits for it. */
static uint svo_size_of(const svo_placed *p, uint axis)
{
    const int u = axis == 0u ? p->width.y : axis == 1u ? p->width.z : p->width.x;
    const int v = axis == 0u ? p->width.z : axis == 1u ? p->width.x : p->width.y;
    const long columns = (long)u * v;
    return columns > SVO_TILE_COLUMNS ? SVO_SIZE_LARGE : (uint)min(columns, (long)(SVO_SIZE_COUNT - 1));
}

/* The fate of an accepted triangle. sums: widths, and twice the projected areas, of one that is kept. */
static uint svo_judge(const svo_snapped *q, const svo_plan_params *params, ulong2 *sums)
{
    const svo_placed p = svo_place_triangle(q, params);
    if (p.outside || p.far) {
        return p.outside ? SVO_FATE_OUTSIDE : SVO_FATE_FAR;
    }
    const ulong3 sizes = abs(svo_snapped_normal(q));
    const uint flags = svo_draw_flags(q, &p, sizes, params->voxel_log2);
    const int3 extent = p.high - p.low;
    *sums = p.inside ? (ulong2)((ulong)(extent.x + extent.y + extent.z), sizes.x + sizes.y + sizes.z)
                     : svo_clipped_sums(q, params->snap_bits);
    return svo_class_of(&p, params) | flags << SVO_FATE_DRAW_LOG2 |
           svo_size_of(&p, flags & SVO_DRAW_AXIS_MASK) << SVO_FATE_SIZE_LOG2;
}

/* Numbers of a work-item's triangles by fate, 8 bits each, to columns. */
static void svo_unpack_counts(ulong counts, ulong columns[SVO_PLAN_SUMS])
{
    for (uint fate = 0; fate < SVO_PLAN_SUM_WIDTHS; ++fate) {
        columns[fate] = counts >> (8u * fate) & 255ul;
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_plan_classify(__global const int *vertices, __global const uint *indices, __global const uchar *used,
                    __global ushort *fates, __global float *fragments, __global ulong *partials, svo_plan_params params,
                    __local ulong *scratch)
{
    const uint2 run = svo_own_run(params.triangle_count);
    /* The expected number of fragments is a sum of integers in units of 1 / (2 h^2). */
    const uint one_log2 = 2u * params.voxel_log2 + 1u;
    const float unit = 1.0f / (float)(1ul << one_log2);
    ulong counts = 0;
    ulong large = 0;
    ulong2 total = (ulong2)(0, 0);
    for (uint t = run.x; t < run.y; ++t) {
        uint corners[3];
        uint fate = SVO_FATE_REFUSED;
        ulong2 sums = (ulong2)(0, 0);
        if (svo_mesh_corners(indices, &params, t, corners) && used[corners[0]] != 0 && used[corners[1]] != 0 &&
            used[corners[2]] != 0) {
            const svo_snapped q = svo_snapped_triangle(vertices, corners);
            fate = svo_judge(&q, &params, &sums);
        }
        fates[t] = (ushort)fate;
        fragments[t] = (float)((1ul << one_log2) + (sums.x << (params.voxel_log2 + 1u)) + sums.y) * unit;
        counts += 1ul << (8u * (fate & SVO_FATE_MASK));
        large += svo_fate_is_large(fate) ? 1ul : 0ul;
        total += sums; /* below 16 * 3 * 2^48 */
    }
    ulong columns[SVO_PLAN_SUMS];
    svo_unpack_counts(counts, columns);
    columns[SVO_PLAN_SUM_WIDTHS] = total.x;
    columns[SVO_PLAN_SUM_AREAS_LOW] = total.y & 0xfffffffful;
    columns[SVO_PLAN_SUM_AREAS_HIGH] = total.y >> 32;
    columns[SVO_PLAN_SUM_LARGE] = large;
    svo_group_columns(columns, SVO_PLAN_SUMS, false, scratch, partials);
}
