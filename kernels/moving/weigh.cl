/* SPDX-License-Identifier: MIT */
/*
 * What the pairs of an object contribute to the payload: clipped, weighed and sampled once, as filter.cl would do it
 * for each build, and kept until the object moves.
 *
 *   svo_k_moving_weigh  per pair or, with -DSVO_PAIR_LANES for CPUs, per window of pairs: its weight, color and normal,
 *                       with -DSVO_AREAS what it shows, and its material where materials is not NULL
 *
 * Launch: one work-item per pair or window, rounded up to whole groups. No atomics.
 */
#include "moving/areas.clh"
#include "moving/kept.clh"
#include "stages/attribute.clh"
#include "stages/pair_lanes.clh"
#include "stages/sums.clh"

/* What is made of each pair. */
typedef struct svo_weighed {
    __global uint4 *values;
    __global uint4 *areas; /* NULL without projected areas */
} svo_weighed;

#ifdef SVO_PAIR_LANES
#define SVO_WEIGH_PAIRS SVO_WINDOW_PAIRS

/* Weighs the pairs from begin to end, at most a window. */
static void svo_weigh(__global const uint *fragments, svo_surface surface, svo_weighed to, uint begin, uint end,
                      svo_filter_params filter, uint object)
{
    svo_window window;
    svo_code *codes = (svo_code *)window.code;
    const uint count = end - begin;
    const uint vectors = (count + SVO_LANES - 1u) / SVO_LANES;
    for (uint i = 0; i < SVO_LANES * vectors; ++i) {
        const uint from = begin + min(i, count - 1u);
        window.triangle[i] = svo_fragment_triangle(fragments, from);
        codes[i] = svo_fragment_code(fragments, from);
    }
    svo_window_run(&window, vectors, surface, filter);
    for (uint i = 0; i < count; ++i) {
        uint color = 0u;
        int3 normal = (int3)(0);
#ifdef SVO_COLOR
        color = SVO_UINT_OF(window.color, i);
#endif
#ifdef SVO_NORMAL
        normal =
            (int3)(SVO_INT_OF(window.normal[0], i), SVO_INT_OF(window.normal[1], i), SVO_INT_OF(window.normal[2], i));
#endif
        to.values[begin + i] = svo_keep(SVO_UINT_OF(window.weight, i), color, normal, object);
#ifdef SVO_AREAS
        to.areas[begin + i] = svo_keep_seen(svo_window_seen(&window, i));
#endif
    }
}

#else
#define SVO_WEIGH_PAIRS 1u

static void svo_weigh(__global const uint *fragments, svo_surface surface, svo_weighed to, uint begin, uint end,
                      svo_filter_params filter, uint object)
{
    uint weight = 0u;
    uint color = 0u;
    int3 normal = (int3)(0);
#if defined(SVO_GATHERED) || defined(SVO_MATERIAL)
    const uint triangle = svo_fragment_triangle(fragments, begin);
    const svo_share share = svo_pair_share(surface, triangle, svo_fragment_code(fragments, begin), filter);
    weight = share.weight;
#endif
#ifdef SVO_COLOR
    const uint4 rgba = svo_surface_color(surface, triangle, share.corners);
    color = rgba.x | rgba.y << 8 | rgba.z << 16 | rgba.w << 24;
#endif
#ifdef SVO_NORMAL
    normal = svo_surface_normal(surface, triangle, share.corners);
#endif
    SVO_UNUSED(fragments);
    SVO_UNUSED(surface);
    SVO_UNUSED(filter);
    SVO_UNUSED(end);
#ifdef SVO_AREAS
    const long doubled_area =
        svo_pair_doubled_area(surface, triangle, svo_fragment_code(fragments, begin), share, filter);
    to.areas[begin] = svo_keep_seen(svo_part_shows(surface, triangle, doubled_area, filter.voxel_log2));
#endif
    to.values[begin] = svo_keep(weight, color, normal, object);
}

#endif

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_moving_weigh(__global const uint *fragments, SVO_SURFACE_PARAMETERS, __global uint4 *values,
                   __global uint *pair_materials, __global const uint *counted, svo_filter_params filter,
                   svo_moving_params params SVO_AND_AREAS(uint4, areas))
{
    const ulong begin = (ulong)get_global_id(0) * SVO_WEIGH_PAIRS;
    const uint pairs = svo_kept_count(params.count, counted);
    if (begin >= pairs) {
        return;
    }
    const uint end = (uint)min(begin + SVO_WEIGH_PAIRS, (ulong)pairs);
    const svo_surface surface = SVO_SURFACE;
    svo_weighed to = {values, 0};
#ifdef SVO_AREAS
    to.areas = areas;
#endif
    svo_weigh(fragments, surface, to, (uint)begin, end, filter, params.object);
    for (uint i = (uint)begin; i < (pair_materials != 0 ? end : (uint)begin); ++i) {
        pair_materials[i] = records[svo_fragment_triangle(fragments, i)].material;
    }
}
