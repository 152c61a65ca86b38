/* SPDX-License-Identifier: MIT */
/*
 * Rays from a buffer, hits into a buffer: the batch side of rays.clh. Reads the tree, writes one record per ray;
 * -DSVO_COUNT_HITS counts all hits. No atomics, no local memory.
 *
 * On CPUs a work-item takes several rays, and eight at a time get ready for the walk, one to a lane. Where the eight go
 * much the same way, as those of a camera do, they go together: nodes are cut with slabs that hold all of theirs (as the
 * frusta of Reshetov, Soupikov and Hurley, "Multi-Level Ray Tracing Algorithm", 2005), and a leaf is tested by the rays
 * that meet its bounds. Else each goes alone: it walks to its next leaf and asks for what is there, and while that comes
 * the others have their turn. On GPUs other work-items do that, and one ray each is best. The hits are the same.
 *
 * Launch: one work-item per SVO_RAYS_PER_ITEM rays, one dimension, rounded up to whole groups.
 */
#include "svocl/layout.h"

#include "rays.clh"

#ifndef SVO_RAYS_PER_ITEM
#define SVO_RAYS_PER_ITEM 1 /* lib/rays_batch.c sets it for CPUs */
#endif

#if SVO_RAYS_PER_ITEM > 1

#ifdef cl_khr_fp64
typedef double8 svo_real8;
#define svo_to_real8 convert_double8
#else
typedef float8 svo_real8;
#define svo_to_real8 convert_float8
#endif

/* Rays go side by side where their starts, in widths of the grid, and their directions, in largest components, are no
   further apart on any axis. */
#define SVO_OCTET_SPREAD 0x1p-6f

/* Eight rays as svo_grid_ray has one, a lane each. */
typedef struct svo_octet {
    float8 direction[3];
    svo_real8 start[3];
    svo_real8 shear_x, shear_y;
    float8 per_main; /* one over the direction's largest component, without its sign */
    float8 per_step[3], enter[3], leave[3];
    float8 first, last, t_min, t_max, s_per_t, filter;
    int8 backwards; /* bit a: on axis a */
    int8 axis_z;
} svo_octet;

/* Loads eight rays; the lanes that are sound and of usual directions, a bit each. The others go one by one. */
static uint svo_octet_load(const svo_ray_params *params, __global const svo_ray *rays, svo_octet *out)
{
    float8 records[8];
    for (uint i = 0u; i < 8u; ++i) {
        records[i] = vload8(i, (__global const float *)rays);
    }
#define SVO_FIELD(k)                                                                                               \
    (float8)(records[0].s##k, records[1].s##k, records[2].s##k, records[3].s##k, records[4].s##k, records[5].s##k, \
             records[6].s##k, records[7].s##k)
    const float8 origin[3] = {SVO_FIELD(0), SVO_FIELD(1), SVO_FIELD(2)};
    out->direction[0] = SVO_FIELD(3);
    out->direction[1] = SVO_FIELD(4);
    out->direction[2] = SVO_FIELD(5);
    out->t_min = SVO_FIELD(6);
    out->t_max = SVO_FIELD(7);
#undef SVO_FIELD
    float8 sum = 0.0f;
    float8 largest = 0.0f;
    int8 tiny = 0;
    for (uint axis = 0u; axis < 3u; ++axis) {
        const svo_real from = (svo_real)params->origin[axis] + params->origin[axis + 3u] + params->origin[axis + 6u];
        out->start[axis] = (svo_to_real8(origin[axis]) - from) * svo_ray_scale(params);
        const float8 size = fabs(out->direction[axis]);
        sum += origin[axis] * 0.0f + size * 0.0f;
        largest = max(largest, size);
        tiny |= (as_int8(size) > 0) & (as_int8(size) < 0x00800000);
    }
    return svo_lanes((sum == 0.0f) & (out->t_min <= out->t_max) & (largest > SVO_RAY_SHORT) &
                     (largest <= SVO_RAY_LONG) & ~tiny);
}

static float8 svo_octet_choose(const float8 *vector, int8 axis)
{
    return select(select(vector[0], vector[1], axis == 1), vector[2], axis == 2);
}

/* The rest, as svo_ray_to_grid and svo_ray_slabs have it. */
static void svo_octet_to_grid(const svo_ray_params *params, svo_octet *octet)
{
    const float step = (float)(1u << (params->snap_bits - SVO_RAY_BOX_BITS));
    float8 reach = params->reach;
    float8 size[3];
    octet->backwards = 0;
    for (uint axis = 0u; axis < 3u; ++axis) {
        reach = max(reach, fabs(convert_float8(octet->start[axis])));
        size[axis] = fabs(octet->direction[axis]);
    }
    const float8 largest = max(size[0], max(size[1], size[2]));
    const float8 margin = reach * 0x1p-20f * SVO_RAY_BOX_MARGIN;
    for (uint axis = 0u; axis < 3u; ++axis) {
        const float8 start = convert_float8(octet->start[axis]);
        const float8 inverse = min(largest / size[axis], (float8)(SVO_RAY_INVERSE_MAX));
        const int8 backwards = octet->direction[axis] < 0.0f;
        const float8 along = select(inverse, -inverse, backwards);
        const float8 beyond = step * inverse;
        octet->backwards |= backwards & (1 << (int)axis);
        octet->per_step[axis] = step * along;
        octet->enter[axis] = -start * along - margin * inverse - select((float8)(0.0f), beyond, backwards);
        octet->leave[axis] = -start * along + margin * inverse + select(beyond, (float8)(0.0f), backwards);
    }
    octet->per_main = 1.0f / largest;
    octet->s_per_t = params->scale[0] * largest;
    const float8 first = octet->t_min * octet->s_per_t;
    const float8 last = octet->t_max * octet->s_per_t;
    octet->first = first - fabs(first) * 0x1p-20f;
    octet->last = last + fabs(last) * 0x1p-20f;
    octet->filter = reach * 0x1p-20f * SVO_RAY_FILTER;
    octet->axis_z = select(select((int8)(2), (int8)(1), size[1] >= size[2]),
                           select((int8)(2), (int8)(0), size[0] >= size[2]), size[0] >= size[1]);
    const int8 axis_x = select(octet->axis_z + 1, (int8)(0), octet->axis_z == 2);
    const int8 axis_y = select(axis_x + 1, (int8)(0), axis_x == 2);
    const svo_real8 main = svo_to_real8(svo_octet_choose(octet->direction, octet->axis_z));
    octet->shear_x = svo_to_real8(svo_octet_choose(octet->direction, axis_x)) / main;
    octet->shear_y = svo_to_real8(svo_octet_choose(octet->direction, axis_y)) / main;
}

#define SVO_LANE(vector)      (((const float *)&(vector))[lane])
#define SVO_LANE_INT(vector)  (((const int *)&(vector))[lane])
#define SVO_LANE_REAL(vector) (((const svo_real *)&(vector))[lane])
#define SVO_LANE_3(vectors)   (float4)(SVO_LANE((vectors)[0]), SVO_LANE((vectors)[1]), SVO_LANE((vectors)[2]), 0.0f)

static void svo_octet_lane(const svo_octet *octet, uint lane, svo_grid_ray *out)
{
    out->axis_z = (uint)SVO_LANE_INT(octet->axis_z);
    out->axis_x = out->axis_z == 2u ? 0u : out->axis_z + 1u;
    out->axis_y = out->axis_x == 2u ? 0u : out->axis_x + 1u;
    out->start = (svo_real4)(SVO_LANE_REAL(octet->start[out->axis_x]), SVO_LANE_REAL(octet->start[out->axis_y]),
                             SVO_LANE_REAL(octet->start[out->axis_z]), 0);
    out->direction = (svo_real4)(SVO_LANE(octet->direction[out->axis_x]), SVO_LANE(octet->direction[out->axis_y]),
                                 SVO_LANE(octet->direction[out->axis_z]), 0);
    out->shear_x = SVO_LANE_REAL(octet->shear_x);
    out->shear_y = SVO_LANE_REAL(octet->shear_y);
    out->slabs.enter_step = SVO_LANE_3(octet->per_step);
    out->slabs.leave_step = out->slabs.enter_step;
    out->slabs.enter = SVO_LANE_3(octet->enter);
    out->slabs.leave = SVO_LANE_3(octet->leave);
    out->slabs.first = SVO_LANE(octet->first);
    out->last = SVO_LANE(octet->last);
    out->t_min = SVO_LANE(octet->t_min);
    out->t_max = SVO_LANE(octet->t_max);
    out->s_per_t = SVO_LANE(octet->s_per_t);
    out->filter = SVO_LANE(octet->filter);
    svo_ray_find_rows((uint)SVO_LANE_INT(octet->backwards), &out->slabs);
}

/* ---- apart ---- */

#if defined(__x86_64__) || defined(__aarch64__)
#define SVO_PREFETCH(address) __builtin_prefetch(address)
#else
#define SVO_PREFETCH(address) (void)(address)
#endif

/* A ray under way: it has come to a leaf, which is on its way into the cache, and is to test what is there. */
typedef struct svo_flight {
    svo_grid_ray ray;
    svo_search search;
    uint leaf;
    svo_ray_way way;
} svo_flight;

/* Takes a ray to its next leaf; false when there is none. */
static bool svo_flight_go_on(const svo_tree *tree, svo_flight *flight)
{
    flight->leaf = svo_ray_next_leaf(tree, &flight->ray.slabs, flight->search.s_limit, &flight->way);
    if (flight->leaf == SVO_RAY_NO_LEAF) {
        return false;
    }
    SVO_PREFETCH(tree->leaves + flight->leaf);
    SVO_PREFETCH(tree->leaves + flight->leaf + 4);
    SVO_PREFETCH(tree->leaves + flight->leaf + 8);
    return true;
}

/* Tests the leaf and goes on; false when there is nothing more to find. */
static bool svo_flight_land(const svo_tree *tree, svo_flight *flight)
{
    svo_ray_leaf(tree, &flight->ray, flight->leaf, &flight->search);
    return !(flight->search.any && flight->search.met != 0u) && svo_flight_go_on(tree, flight);
}

/* Eight rays on their own ways. usual: the lanes that are in the octet. */
static void svo_trace_apart(const svo_tree *tree, __global const svo_ray *rays, const svo_octet *octet, uint usual,
                            bool any, svo_flight *flights)
{
    uint under_way = 0u;
    for (uint lane = 0u; lane < 8u; ++lane) {
        svo_flight *flight = &flights[lane];
        bool sound = true;
        if ((usual >> lane & 1u) != 0u) {
            svo_octet_lane(octet, lane, &flight->ray);
        } else {
            const svo_ray given = rays[lane];
            sound = svo_ray_to_grid(&tree->params, &given, &flight->ray);
        }
        svo_search_begin(sound ? flight->ray.last : 0.0f, any, false, &flight->search);
        svo_ray_begin(&flight->way);
        under_way |= sound && svo_flight_go_on(tree, flight) ? 1u << lane : 0u;
    }
    while (under_way != 0u) {
        for (uint left = under_way; left != 0u; left &= left - 1u) {
            const uint lane = svo_lowest_lane(left);
            under_way &= svo_flight_land(tree, &flights[lane]) ? ~0u : ~(1u << lane);
        }
    }
}

/* ---- side by side ---- */

static float svo_least(float8 v)
{
    const float4 four = min(v.lo, v.hi);
    const float2 two = min(four.lo, four.hi);
    return min(two.x, two.y);
}

static float svo_greatest(float8 v)
{
    return -svo_least(-v);
}

/* Whether eight rays go the same way: few boxes are then met by some of them and not by the others. */
static bool svo_octet_is_narrow(const svo_ray_params *params, const svo_octet *octet)
{
    const float width = (float)(1u << params->snap_bits) * SVO_OCTET_SPREAD;
    const int8 axis_z = octet->axis_z;
    const int8 backwards = octet->backwards;
    bool narrow = svo_lanes((axis_z != axis_z.s0) | (backwards != backwards.s0)) == 0u;
    for (uint axis = 0u; axis < 3u; ++axis) {
        const float8 start = convert_float8(octet->start[axis]);
        const float8 slope = octet->direction[axis] * octet->per_main;
        narrow = narrow && svo_greatest(start) - svo_least(start) <= width &&
                 svo_greatest(slope) - svo_least(slope) <= SVO_OCTET_SPREAD;
    }
    return narrow;
}

/* Slabs that hold those of all eight rays: bounds of boxes are not below zero. */
static void svo_octet_slabs(const svo_octet *octet, svo_ray_slabs *out)
{
    out->enter_step =
        (float4)(svo_least(octet->per_step[0]), svo_least(octet->per_step[1]), svo_least(octet->per_step[2]), 0.0f);
    out->enter = (float4)(svo_least(octet->enter[0]), svo_least(octet->enter[1]), svo_least(octet->enter[2]), 0.0f);
    out->leave_step = (float4)(svo_greatest(octet->per_step[0]), svo_greatest(octet->per_step[1]),
                               svo_greatest(octet->per_step[2]), 0.0f);
    out->leave =
        (float4)(svo_greatest(octet->leave[0]), svo_greatest(octet->leave[1]), svo_greatest(octet->leave[2]), 0.0f);
    out->first = svo_least(octet->first);
    svo_ray_find_rows((uint)octet->backwards.s0, out);
}

/* The lanes that meet the bounds of a leaf's triangles before their limits. */
static uint svo_octet_meets(const svo_ray_params *params, const svo_octet *octet, __global const int4 *leaf,
                            float8 limits)
{
    const float per_unit = 1.0f / (float)(1u << (params->snap_bits - SVO_RAY_BOX_BITS));
    const float4 low = convert_float4(leaf[0]) * per_unit;
    const float4 high = convert_float4(leaf[1]) * per_unit;
    const int4 backwards = (int4)(octet->backwards.s0) << (int4)(31, 30, 29, 0);
    const float4 near = select(low, high, backwards);
    const float4 far = select(high, low, backwards);
    const float8 enter_x = near.x * octet->per_step[0] + octet->enter[0];
    const float8 enter_y = near.y * octet->per_step[1] + octet->enter[1];
    const float8 enter_z = near.z * octet->per_step[2] + octet->enter[2];
    const float8 leave_x = far.x * octet->per_step[0] + octet->leave[0];
    const float8 leave_y = far.y * octet->per_step[1] + octet->leave[1];
    const float8 leave_z = far.z * octet->per_step[2] + octet->leave[2];
    return svo_lanes(max(max(enter_x, enter_y), max(enter_z, octet->first)) <=
                     min(min(leave_x, leave_y), min(leave_z, limits)));
}

/* Eight rays on one way, to all leaves that one of them may meet. */
static void svo_trace_together(const svo_tree *tree, const svo_octet *octet, bool any, svo_flight *flights)
{
    svo_ray_slabs slabs;
    svo_ray_way *way = &flights[0].way;
    float8 limits = octet->last;
    uint landed = 0u; /* rays that have been at a leaf */
    svo_octet_slabs(octet, &slabs);
    for (uint lane = 0u; lane < 8u; ++lane) {
        svo_search_begin(SVO_LANE(octet->last), any, false, &flights[lane].search);
    }
    svo_ray_begin(way);
    for (;;) {
        const uint leaf = svo_ray_next_leaf(tree, &slabs, svo_greatest(limits), way);
        if (leaf == SVO_RAY_NO_LEAF) {
            return;
        }
        uint left = svo_octet_meets(&tree->params, octet, tree->leaves + leaf, limits);
        for (; left != 0u; left &= left - 1u) {
            const uint lane = svo_lowest_lane(left);
            svo_flight *flight = &flights[lane];
            if ((landed >> lane & 1u) == 0u) {
                svo_octet_lane(octet, lane, &flight->ray);
                landed |= 1u << lane;
            }
            svo_ray_leaf(tree, &flight->ray, leaf, &flight->search);
            /* A ray that is done asks for nothing more. */
            ((float *)&limits)[lane] = any && flight->search.met != 0u ? -INFINITY : flight->search.s_limit;
        }
    }
}

static void svo_trace_octet(const svo_tree *tree, __global const svo_ray *rays, __global svo_hit *hits, bool any)
{
    svo_octet octet;
    svo_flight flights[8];
    const uint usual = svo_octet_load(&tree->params, rays, &octet);
    svo_octet_to_grid(&tree->params, &octet);
    if (usual == 255u && svo_octet_is_narrow(&tree->params, &octet)) {
        svo_trace_together(tree, &octet, any, flights);
    } else {
        svo_trace_apart(tree, rays, &octet, usual, any, flights);
    }
    for (uint lane = 0u; lane < 8u; ++lane) {
        svo_hit hit;
        svo_hit_from_search(tree, &flights[lane].search, &hit);
        hits[lane] = hit;
    }
}

#endif

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_trace(SVO_TREE_PARAMETERS, __global const svo_ray *rays, __global svo_hit *hits, uint ray_count, uint any)
{
    const uint first = (uint)get_global_id(0) * SVO_RAYS_PER_ITEM;
    const uint end = min(first + SVO_RAYS_PER_ITEM, ray_count);
    uint i = first;
    SVO_TREE_MAKE(tree);
#if SVO_RAYS_PER_ITEM > 1
    for (; i + 8u <= end; i += 8u) {
        svo_trace_octet(&tree, rays + i, hits + i, any != 0u);
    }
#endif
    for (; i < end; ++i) {
        const svo_ray ray = rays[i];
        svo_hit hit;
#ifdef SVO_COUNT_HITS
        (void)any;
        svo_trace_count(&tree, &ray, &hit);
#else
        svo_trace_first(&tree, &ray, any != 0u, &hit);
#endif
        hits[i] = hit;
    }
}
