/* SPDX-License-Identifier: MIT */
/*
 * Drops pairs by their alpha: a triangle's part in a voxel is left out of the list where its alpha, as the payload has
 * it (attribute.clh), is below params.least_alpha. What remains of a chunk lies at its start, in any order.
 *
 *   svo_k_drop_pairs   per fragment: marks those that are dropped and counts them
 *   svo_k_find_places  then, per fragment: notes the places of dropped ones among the first as many as remain, and
 *                      where remaining ones lie behind these; there are as many of both
 *   svo_k_move_pairs   then, per pair of such places: moves the remaining one; the first work-item writes the count
 *
 * A chunk has params.capacity fragments. Where counters is not NULL it has at most that room, and counters, two of 64
 * bits (SVO_COUNTER_WORDS), tell how many there are; then, how many remain and how many were dropped. If the fragments
 * did not fit, nothing is dropped.
 *
 * Compiled with SVO_COLOR, whose alpha it is.
 *
 * Launch: one work-item per fragment, or per two of them, rounded up to whole groups. Atomics: increments of the
 * numbers of dropped fragments and of places. They decide the order of the list, on which no result depends. Fragments
 * outside the grid or of no triangle, which a driver may make, remain for the stage that tells of them.
 *
 * Most triangles are decided without clipping: no point of a triangle shows less than the least alpha of its material's
 * texels, of its corners and of the material's color, multiplied, since means and products are rounded the same way.
 */
#include "shared/clip.clh"
#include "stages/attribute.clh"

#ifdef SVO_COLOR

/* Words of the tally of a chunk: dropped fragments, and places of each kind. */
#define SVO_TALLY_DROPPED 0
#define SVO_TALLY_EMPTY   1
#define SVO_TALLY_BEHIND  2

#ifndef SVO_NO_TRIANGLE
#define SVO_NO_TRIANGLE 0xffffffffu
#endif

/* Fragments of the chunk; 0 where they do not fit. */
static uint svo_pairs_of(__global const uint *counters, const svo_drop_params *params)
{
    if (counters == 0) {
        return params->capacity;
    }
    __global const uint *own = counters + SVO_COUNTER_WORDS * params->counter;
    return own[1] == 0u && own[0] <= params->capacity ? own[0] : 0u;
}

/* No point of the triangle has less. */
static uint svo_least_of(const svo_surface *surface, uint triangle)
{
    uint4 least = (uint4)(surface->materials[surface->records[triangle].material].least_alpha);
#ifdef SVO_VERTEX_COLOR
    __global const uint *corner = surface->indices + (size_t)triangle * 3u;
    const uint alpha =
        min(min(surface->colors[corner[0]] >> 24, surface->colors[corner[1]] >> 24), surface->colors[corner[2]] >> 24);
    least = svo_modulate(least, (uint4)(alpha));
#endif
    return least.x;
}

/* Whether the alpha of a triangle's part in a voxel is enough. */
SVO_CALLED bool svo_shows(const svo_surface *surface, uint triangle, svo_code code, const svo_drop_params *params)
{
    if (svo_least_of(surface, triangle) >= params->least_alpha) {
        return true;
    }
    int3 corners = svo_equal_weights();
    if (!svo_triangle_is_flat(surface->records[triangle])) {
        svo_filter_params filter;
        filter.voxel_log2 = params->voxel_log2;
        filter.weight_log2 = params->weight_log2;
        corners = svo_pair_share(*surface, triangle, code, filter).corners;
    }
    return svo_surface_color(*surface, triangle, corners).w >= params->least_alpha;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_drop_pairs(__global uint *fragments, SVO_SURFACE_PARAMETERS, __global const uint *counters,
                 volatile __global uint *tally, svo_drop_params params)
{
    const uint index = (uint)get_global_id(0);
    if (index >= svo_pairs_of(counters, &params)) {
        return;
    }
    const svo_surface surface = SVO_SURFACE;
    const svo_code code = svo_fragment_code(fragments, index);
    const uint triangle = svo_fragment_triangle(fragments, index);
    const bool is_damaged = (uint)(code >> (3u * params.depth)) != 0u || triangle >= params.triangle_count;
    if (!is_damaged && !svo_shows(&surface, triangle, code, &params)) {
        svo_fragment_store(fragments, index, code, SVO_NO_TRIANGLE);
        atomic_inc(tally + SVO_TALLY_DROPPED);
    }
}

/* places: as many as params.capacity. Those of dropped fragments stand at its start, the others at its end. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_find_places(__global const uint *fragments, __global const uint *counters, volatile __global uint *tally,
                  __global uint *places, svo_drop_params params)
{
    const uint index = (uint)get_global_id(0);
    const uint count = svo_pairs_of(counters, &params);
    if (index >= count) {
        return;
    }
    const uint kept = count - tally[SVO_TALLY_DROPPED];
    const bool is_dropped = svo_fragment_triangle(fragments, index) == SVO_NO_TRIANGLE;
    if (is_dropped && index < kept) {
        places[atomic_inc(tally + SVO_TALLY_EMPTY)] = index;
    } else if (!is_dropped && index >= kept) {
        places[params.capacity - 1u - atomic_inc(tally + SVO_TALLY_BEHIND)] = index;
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_move_pairs(__global uint *fragments, __global uint *counters, __global const uint *tally,
                 __global const uint *places, svo_drop_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item < tally[SVO_TALLY_EMPTY]) {
        const uint from = places[params.capacity - 1u - item];
        svo_fragment_store(fragments, places[item], svo_fragment_code(fragments, from),
                           svo_fragment_triangle(fragments, from));
    }
    if (item == 0u && counters != 0 && svo_pairs_of(counters, &params) != 0u) {
        __global uint *own = counters + SVO_COUNTER_WORDS * params.counter;
        own[0] -= tally[SVO_TALLY_DROPPED];
        own[2] = tally[SVO_TALLY_DROPPED];
        own[3] = 0u;
    }
}

#endif
