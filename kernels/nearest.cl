/* SPDX-License-Identifier: MIT */
/*
 * The nearest triangle to each point of a buffer.
 *
 * Depth first over wide nodes (widen.cl), each time into the nearest cell that is left and can still hold something nearer
 * than the best so far (branch and bound, after Roussopoulos, Kelley and Vincent, "Nearest Neighbor Queries", 1995). A
 * triangle's nearest point lies in one of the leaves that list it, so no leaf is left out that matters: cells are measured
 * in float and taken a margin nearer than they are, triangles in double where the device has it.
 *
 * Launch: one work-item per point, one dimension, rounded up to whole groups. Reads the tree, writes one record per point.
 * No atomics, no local memory.
 */
#include "svocl/layout.h"

#include "rays.clh"

typedef struct svo_nearest_search {
    svo_real4 point; /* grid units */
    float4 point_f;
    float margin; /* grid units that float may be off */
    float limit; /* grid units: cells from here on hold nothing better */
    float distance; /* world, rounded: of the best so far, else the farthest that counts */
    uint triangle; /* among the tree's list entries; UINT_MAX: none yet */
    uint id;
    svo_real4 nearest; /* relative to the point, grid units */
    uint leaves;
} svo_nearest_search;

static svo_real svo_dot3(svo_real4 a, svo_real4 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/* The nearest point to the zero point on the segment from a to b. */
static svo_real4 svo_nearest_on_segment(svo_real4 a, svo_real4 b)
{
    const svo_real4 edge = b - a;
    const svo_real squared = svo_dot3(edge, edge);
    svo_real share = squared > 0 ? -svo_dot3(a, edge) / squared : 0;
    share = share < 0 ? 0 : share > 1 ? 1 : share;
    return a + share * edge;
}

static svo_real4 svo_nearer(svo_real4 a, svo_real4 b)
{
    return svo_dot3(b, b) < svo_dot3(a, a) ? b : a;
}

/* The nearest point to the zero point on the triangle: the foot of its plane where that is inside, else on an edge.
   Segments and points are all edge. */
static svo_real4 svo_nearest_on_triangle(svo_real4 a, svo_real4 b, svo_real4 c)
{
    const svo_real4 u = b - a;
    const svo_real4 v = c - a;
    const svo_real uu = svo_dot3(u, u);
    const svo_real uv = svo_dot3(u, v);
    const svo_real vv = svo_dot3(v, v);
    const svo_real au = svo_dot3(a, u);
    const svo_real av = svo_dot3(a, v);
    const svo_real area = uu * vv - uv * uv;
    const svo_real along_u = uv * av - vv * au;
    const svo_real along_v = uv * au - uu * av;
    if (area > 0 && along_u >= 0 && along_v >= 0 && along_u + along_v <= area) {
        return a + (along_u / area) * u + (along_v / area) * v;
    }
    return svo_nearer(svo_nearer(svo_nearest_on_segment(a, b), svo_nearest_on_segment(b, c)),
                      svo_nearest_on_segment(c, a));
}

static void svo_nearest_try(const svo_tree *tree, uint triangle, svo_nearest_search *search)
{
    __global const int4 *corners = tree->triangles + 3u * (size_t)triangle;
    const svo_real4 x = svo_to_real4(corners[0]) - search->point.x;
    const svo_real4 y = svo_to_real4(corners[1]) - search->point.y;
    const svo_real4 z = svo_to_real4(corners[2]) - search->point.z;
    const svo_real4 nearest = svo_nearest_on_triangle((svo_real4)(x.x, y.x, z.x, 0), (svo_real4)(x.y, y.y, z.y, 0),
                                                      (svo_real4)(x.z, y.z, z.z, 0));
    const svo_real away = sqrt(svo_dot3(nearest, nearest));
    const float distance = (float)(away / svo_ray_scale(&tree->params));
    const uint id = (uint)corners[0].w;
    if (!(distance <= search->distance) || (distance == search->distance && id >= search->id)) {
        return;
    }
    search->distance = distance;
    search->triangle = triangle;
    search->id = id;
    search->nearest = nearest;
    search->limit = (float)away * (1.0f + 0x1p-20f) + search->margin;
}

/* The distance from the point to a cube, less the margin. */
static float svo_nearest_cell(const svo_nearest_search *search, float4 low, float width)
{
    const float4 outside = max(max(low - search->point_f, search->point_f - (low + width)), (float4)(0.0f));
    return sqrt(outside.x * outside.x + outside.y * outside.y + outside.z * outside.z) * (1.0f - 0x1p-20f) -
           search->margin;
}

/* The nearest of the cells that are left; 64 when none is near enough. */
static uint svo_nearest_pick(const svo_nearest_search *search, ulong left, float4 low, float width)
{
    uint best = 64u;
    float least = search->limit;
    for (; left != 0ul; left &= left - 1ul) {
        const uint cell = 63u - (uint)clz(left & (0ul - left));
        const float distance = svo_nearest_cell(search, low + svo_cell_position(cell) * width, width);
        if (distance <= least) {
            least = distance;
            best = cell;
        }
    }
    return best;
}

/* A node on the way down, and the cells of it that are left to visit. */
typedef struct svo_nearest_frame {
    ulong occupied, left;
    float4 low; /* its first corner, grid units */
    uint first_child;
} svo_nearest_frame;

static void svo_nearest_walk(const svo_tree *tree, svo_nearest_search *search)
{
    svo_nearest_frame stack[SVO_RAY_LEVELS];
    const uint top = tree->params.levels - 1u;
    uint level = top;
    uint node = 0u;
    float width = (float)(1u << (2u * level + tree->params.snap_bits - tree->params.depth));
    float4 low = (float4)(0.0f);
    bool opened = true;
    for (;;) {
        svo_nearest_frame *at = &stack[level];
        if (opened) {
            const uint4 stored = tree->nodes[node];
            at->occupied = (ulong)stored.x | (ulong)stored.y << 32;
            at->left = at->occupied;
            at->first_child = stored.z;
            at->low = low;
        }
        const uint cell = svo_nearest_pick(search, at->left, at->low, width);
        opened = false;
        if (cell == 64u) {
            if (level == top) {
                return;
            }
            ++level;
            width *= 4.0f;
            continue;
        }
        at->left &= ~(1ul << cell);
        const uint child = at->first_child + (uint)popcount(at->occupied & ((1ul << cell) - 1ul));
        if (level == 0u) {
            ++search->leaves;
            for (uint k = tree->list_begin[child]; k < tree->list_begin[child + 1u]; ++k) {
                svo_nearest_try(tree, k, search);
            }
            continue;
        }
        low = at->low + svo_cell_position(cell) * width;
        node = child;
        --level;
        width *= 0.25f;
        opened = true;
    }
}

static void svo_nearest_of(const svo_tree *tree, const svo_query_point *point, svo_nearest *out)
{
    const float sum = point->position[0] * 0.0f + point->position[1] * 0.0f + point->position[2] * 0.0f;
    out->distance = INFINITY;
    out->triangle = SVO_NO_TRIANGLE;
    out->position[0] = out->position[1] = out->position[2] = 0.0f;
    out->leaves = 0u;
    out->reserved[0] = out->reserved[1] = 0u;
    if (!(sum == 0.0f) || !(point->farthest >= 0.0f)) {
        return;
    }
    svo_nearest_search search;
    search.point = svo_position_to_grid(&tree->params, point->position[0], point->position[1], point->position[2]);
    search.point_f = convert_float4(search.point);
    search.margin = max(tree->params.reach, svo_largest(fabs(search.point_f))) * 0x1p-20f * SVO_RAY_CELL_MARGIN;
    search.limit = point->farthest * tree->params.scale[0] * (1.0f + 0x1p-20f) + search.margin;
    search.distance = point->farthest;
    search.triangle = UINT_MAX;
    search.id = UINT_MAX;
    search.nearest = (svo_real4)(0);
    search.leaves = 0u;
    svo_nearest_walk(tree, &search);
    out->leaves = search.leaves;
    if (search.triangle == UINT_MAX) {
        return;
    }
    const svo_real4 offset = search.nearest / svo_ray_scale(&tree->params);
    out->distance = search.distance;
    out->triangle = search.id;
    out->position[0] = (float)(point->position[0] + offset.x);
    out->position[1] = (float)(point->position[1] + offset.y);
    out->position[2] = (float)(point->position[2] + offset.z);
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_nearest(SVO_TREE_PARAMETERS, __global const svo_query_point *points, __global svo_nearest *results,
              uint point_count)
{
    const uint item = (uint)get_global_id(0);
    if (item >= point_count) {
        return;
    }
    SVO_TREE_MAKE(tree);
    const svo_query_point point = points[item];
    svo_nearest found;
    svo_nearest_of(&tree, &point, &found);
    results[item] = found;
}
