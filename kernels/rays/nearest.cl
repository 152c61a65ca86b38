/* SPDX-License-Identifier: MIT */
/*
 * The nearest triangle to each point of a buffer.
 *
 * Traverses the BVH (kernels/bvh) depth first, the nearest box first, and skips boxes that cannot hold anything
 * nearer than the best so far (branch and bound, after Roussopoulos, Kelley and Vincent, "Nearest Neighbor Queries",
 * 1995). Distances to boxes are float, less a margin; distances to triangles are double where the device has it.
 *
 * Launch: one work-item per point, one dimension, rounded up to whole groups. Reads the tree and the points; writes one
 * record per point. No atomics, no local memory.
 */
#include "shared/layout.h"

#include "rays/rays.clh"

typedef struct svo_nearest_search {
    svo_real4 point; /* in the units of svo_leaf_corners */
    float4 point_f; /* grid units */
    float margin; /* grid units: the error bound of float */
    float limit; /* grid units: boxes beyond hold nothing nearer */
    float distance; /* world units, rounded: of the best so far, else max_distance */
    uint id; /* SVO_NO_TRIANGLE: none yet */
    svo_real4 nearest; /* relative to the point, in the units of svo_leaf_corners */
    uint leaves;
} svo_nearest_search;

static svo_real svo_dot3(svo_real4 a, svo_real4 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/* The point nearest to the origin on the segment from a to b. */
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

/* The point nearest to the origin on the triangle: the projection onto its plane if that is inside, else a point of an
   edge. Segments and points have edges alone. */
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

static void svo_nearest_try(const svo_tree *tree, __global const int4 *leaf, int4 head, uint lane,
                            svo_nearest_search *search)
{
    const svo_real4 x = svo_leaf_corners(tree, leaf, head, lane, 0u) - search->point.x;
    const svo_real4 y = svo_leaf_corners(tree, leaf, head, lane, 1u) - search->point.y;
    const svo_real4 z = svo_leaf_corners(tree, leaf, head, lane, 2u) - search->point.z;
    const svo_real4 nearest = svo_nearest_on_triangle((svo_real4)(x.x, y.x, z.x, 0), (svo_real4)(x.y, y.y, z.y, 0),
                                                      (svo_real4)(x.z, y.z, z.z, 0));
    const svo_real away = sqrt(svo_dot3(nearest, nearest));
    const float distance = (float)(away / svo_leaf_scale(&tree->params));
    const uint id = svo_leaf_id(tree, leaf, head, lane);
    if (!(distance <= search->distance) || (distance == search->distance && id >= search->id)) {
        return;
    }
    search->distance = distance;
    search->id = id;
    search->nearest = nearest;
    search->limit = distance * tree->params.scale[0] * (1.0f + 0x1p-20f) + search->margin;
}

/* Of all children of a node: the distance from the point to the box, less the margin. */
static float8 svo_nearest_distances(const svo_tree *tree, const svo_nearest_search *search,
                                    __global const svo_ray_node *node)
{
    __global const ushort8 *rows = (__global const ushort8 *)node;
    const float step = (float)(1u << (tree->params.snap_bits - SVO_RAY_BOX_BITS));
    const float4 at = search->point_f;
    const float8 x =
        max(max(convert_float8(rows[0]) * step - at.x, at.x - convert_float8(rows[3]) * step - step), (float8)(0.0f));
    const float8 y =
        max(max(convert_float8(rows[1]) * step - at.y, at.y - convert_float8(rows[4]) * step - step), (float8)(0.0f));
    const float8 z =
        max(max(convert_float8(rows[2]) * step - at.z, at.z - convert_float8(rows[5]) * step - step), (float8)(0.0f));
    return sqrt(x * x + y * y + z * z) * (1.0f - 0x1p-20f) - search->margin;
}

/* The same of one child, for its order among those that wait. */
static float svo_nearest_distance(const svo_tree *tree, const svo_nearest_search *search,
                                  __global const svo_ray_node *node, uint lane)
{
    __global const ushort *bounds = (__global const ushort *)node + lane;
    const float step = (float)(1u << (tree->params.snap_bits - SVO_RAY_BOX_BITS));
    const float4 at = search->point_f;
    const float4 low = (float4)((float)bounds[0], (float)bounds[8], (float)bounds[16], 0.0f) * step - at;
    const float4 high = at - (float4)((float)bounds[24], (float)bounds[32], (float)bounds[40], 0.0f) * step - step;
    const float4 away = max(max(low, high), (float4)(0.0f));
    return sqrt(away.x * away.x + away.y * away.y + away.z * away.z) * (1.0f - 0x1p-20f) - search->margin;
}

static void svo_nearest_leaf(const svo_tree *tree, uint place, svo_nearest_search *search)
{
    __global const int4 *leaf = tree->leaves + place;
    const int4 head = leaf[0];
    const uint count = svo_leaf_count(head);
    for (uint lane = 0u; lane < count; ++lane) {
        svo_nearest_try(tree, leaf, head, lane, search);
    }
    ++search->leaves;
}

/* The next child that waits and that may hold something nearer; SVO_RAY_NO_LEAF when there is none. */
static uint svo_nearest_pop(const svo_tree *tree, const svo_nearest_search *search, svo_ray_stack *stack)
{
    for (; stack->height > 0u; --stack->height) {
        const uint2 top = svo_ray_top(stack);
        if (!svo_ray_is_beyond(svo_nearest_distance(tree, search, tree->nodes + top.x, top.y & 7u), search->limit)) {
            return svo_ray_take(tree, stack);
        }
    }
    return SVO_RAY_NO_LEAF;
}

static void svo_nearest_traverse(const svo_tree *tree, svo_nearest_search *search)
{
    SVO_RAY_STACK(stack);
    for (uint at = SVO_RAY_ROOT; at != SVO_RAY_NO_LEAF;) {
        int8 near = 0;
        float8 distances = 0.0f;
        if ((at & SVO_RAY_LEAF) != 0u) {
            svo_nearest_leaf(tree, at & ~SVO_RAY_LEAF, search);
        } else {
            distances = svo_nearest_distances(tree, search, tree->nodes + at);
            near = distances <= search->limit;
        }
        at = svo_lanes(near) != 0u ? svo_ray_pick(tree, at, near, distances, &stack)
                                   : svo_nearest_pop(tree, search, &stack);
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
    if (!(sum == 0.0f) || !(point->max_distance >= 0.0f)) {
        return;
    }
    svo_nearest_search search;
    const float4 position = (float4)(point->position[0], point->position[1], point->position[2], 0.0f);
    search.point = svo_position_to_leaf(&tree->params, position);
    search.point_f = svo_start_in_grid(&tree->params, position);
    search.margin = max(tree->params.reach, svo_largest(fabs(search.point_f))) * 0x1p-20f * SVO_RAY_BOX_MARGIN;
    search.limit = point->max_distance * tree->params.scale[0] * (1.0f + 0x1p-20f) + search.margin;
    search.distance = point->max_distance;
    search.id = SVO_NO_TRIANGLE;
    search.nearest = (svo_real4)(0);
    search.leaves = 0u;
    svo_nearest_traverse(tree, &search);
    out->leaves = search.leaves;
    if (search.id == SVO_NO_TRIANGLE) {
        return;
    }
    const svo_real4 offset = search.nearest / svo_leaf_scale(&tree->params);
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
