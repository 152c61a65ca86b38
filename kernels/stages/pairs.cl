/* SPDX-License-Identifier: MIT */
/*
 * The sums of the leaves' payload, pair by pair, for GPUs: what the gather kernels of filter.cl do leaf by leaf for
 * CPUs. A pair is a triangle and a voxel, so a fragment. However many triangles a leaf has, no work-item does more than
 * the others: the sums over a leaf are a segmented reduction (Blelloch, "Prefix Sums and Their Applications", 1990).
 *
 *   svo_k_clear_shared  per two neighboring groups of the launch that follows: zeroes the sums of a leaf that has pairs
 *                       in both. For fragments in the order of leaves
 *   svo_k_gather_pairs  per fragment of a chunk, in the order of leaves: what the pair contributes goes to local
 *                       memory; the first work-item of each run of one leaf adds up the run and adds it to the leaf
 *
 * Invariant: sums are 64-bit integers, so they depend neither on the order of pairs nor on where groups begin.
 *
 * Launch: one work-item per fragment, rounded up to whole groups; a run is at most a group long. The fragments are in
 * the order of svo_k_scatter, in that of a sorted list, or in any order (params.grouped 0: lists of several chunks).
 * Buffers: sums of the leaves, which start at zero where runs are added: weights (ulong), color (4 ulong a leaf),
 * normal (3 long a leaf), areas (6 ulong a leaf). Local memory: SVO_PAIR_WORDS * SVO_GROUP_ITEMS ulong and
 * SVO_GROUP_ITEMS uint, arguments (see group.clh).
 * Atomics: a run that is all of its leaf is stored. Runs of a leaf that groups share are added by atomics
 * (shared_sum.clh).
 */
#include "shared/fragment.clh"
#include "shared/state.clh"
#include "stages/shared_sum.clh"
#include "stages/sums.clh"

#if defined(SVO_GATHERED) && !defined(SVO_PAIR_LANES)

/* 64-bit words of a pair's sums: weight, color, normal, areas; and where each begins. */
#define SVO_COLOR_WORD 1u
#ifdef SVO_COLOR
#define SVO_NORMAL_WORD 5u
#else
#define SVO_NORMAL_WORD 1u
#endif
#ifdef SVO_NORMAL
#define SVO_AREA_WORD (SVO_NORMAL_WORD + 3u)
#else
#define SVO_AREA_WORD SVO_NORMAL_WORD
#endif
#ifdef SVO_AREAS
#define SVO_PAIR_WORDS (SVO_AREA_WORD + 6u)
#else
#define SVO_PAIR_WORDS SVO_AREA_WORD
#endif

/* After the last fragment. */
#define SVO_NO_LEAF 0xffffffffu

/* Puts a pair's sums into local memory. Words of one kind are adjacent: at[word * SVO_GROUP_ITEMS]. */
static void svo_put_pair(__local ulong *at, svo_surface surface, uint triangle, svo_code code, svo_filter_params params)
{
    const svo_share share = svo_pair_share(surface, triangle, code, params);
    at[0] = share.weight;
#ifdef SVO_COLOR
    const ulong4 color = svo_color_share(share.weight, svo_surface_color(surface, triangle, share.corners));
    at[SVO_COLOR_WORD * SVO_GROUP_ITEMS] = color.x;
    at[(SVO_COLOR_WORD + 1u) * SVO_GROUP_ITEMS] = color.y;
    at[(SVO_COLOR_WORD + 2u) * SVO_GROUP_ITEMS] = color.z;
    at[(SVO_COLOR_WORD + 3u) * SVO_GROUP_ITEMS] = color.w;
#endif
#ifdef SVO_NORMAL
    const int3 normal = svo_surface_normal(surface, triangle, share.corners);
    at[SVO_NORMAL_WORD * SVO_GROUP_ITEMS] = (ulong)((long)share.weight * normal.x);
    at[(SVO_NORMAL_WORD + 1u) * SVO_GROUP_ITEMS] = (ulong)((long)share.weight * normal.y);
    at[(SVO_NORMAL_WORD + 2u) * SVO_GROUP_ITEMS] = (ulong)((long)share.weight * normal.z);
#endif
#ifdef SVO_AREAS
    svo_areas areas = svo_no_areas();
    const long doubled_area = svo_pair_doubled_area(surface, triangle, code, share, params);
    svo_add_areas(&areas, svo_part_shows(surface, triangle, doubled_area, params.voxel_log2), params.both_sides != 0u);
    for (uint i = 0; i < 6u; ++i) {
        at[(SVO_AREA_WORD + i) * SVO_GROUP_ITEMS] = areas.of[i];
    }
#endif
}

/* A run of pairs of one leaf, in local memory: the first, and how many. */
typedef struct svo_run {
    __local const ulong *at;
    uint count;
    bool is_whole; /* the leaf has no other pairs */
} svo_run;

/* Adds up adjacent words of the run, from that of its pairs on, and adds them to a leaf's sums. sums: NULL where none
   are needed. */
static void svo_add_run(svo_run run, uint word, uint words, uint leaf, __global ulong *sums)
{
    for (uint k = 0; k < (sums != 0 ? words : 0u); ++k) {
        __local const ulong *at = run.at + (word + k) * SVO_GROUP_ITEMS;
        ulong sum = at[0];
        for (uint pair = 1; pair < run.count; ++pair) {
            sum += at[pair];
        }
        __global ulong *to = sums + (size_t)leaf * words + k;
        if (run.is_whole) {
            *to = sum;
        } else {
            svo_add_shared(to, sum);
        }
    }
}

/* The leaf of a fragment, counted from the first of the tree; slot: its place in the order of leaves. */
static uint svo_leaf_at(uint slot, __global const uint *order, __global const uint *cursors, svo_filter_params params)
{
    return slot < params.fragment_count ? cursors[order != 0 ? order[slot] : slot] - params.leaf_begin : SVO_NO_LEAF;
}

static void svo_clear_sums(uint words, uint leaf, __global ulong *sums)
{
    for (uint k = 0; k < (sums != 0 ? words : 0u); ++k) {
        sums[(size_t)leaf * words + k] = 0UL;
    }
}

/* Of the neighbors that share a leaf, the first two clear it. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_clear_shared(__global const uint *cursors, __global const uint *order, __global ulong *weights,
                   __global ulong *color_sums, __global ulong *normal_sums, __global ulong *area_sums,
                   __global const svo_build_state *state, svo_filter_params params)
{
    svo_make_current(&params, state);
    const uint slot = ((uint)get_global_id(0) + 1u) * SVO_GROUP_ITEMS; /* the first of a group */
    if (slot >= params.fragment_count) {
        return;
    }
    const uint leaf = svo_leaf_at(slot, order, cursors, params);
    const bool is_shared = svo_leaf_at(slot - 1u, order, cursors, params) == leaf;
    const bool was_shared =
        slot > SVO_GROUP_ITEMS && svo_leaf_at(slot - SVO_GROUP_ITEMS - 1u, order, cursors, params) == leaf;
    if (is_shared && !was_shared) {
        svo_clear_sums(1u, leaf, weights);
        svo_clear_sums(4u, leaf, color_sums);
        svo_clear_sums(3u, leaf, normal_sums);
        svo_clear_sums(6u, leaf, area_sums);
    }
}

/* order: NULL: that of the list. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_gather_pairs(__global const uint *fragments, __global const uint *cursors, __global const uint *order,
                   SVO_SURFACE_PARAMETERS, __global ulong *weights, __global ulong *color_sums,
                   __global ulong *normal_sums, __global ulong *area_sums, __global const svo_build_state *state,
                   svo_filter_params params, __local ulong *sums, __local uint *leaves)
{
    svo_make_current(&params, state);
    const uint slot = params.first_index + (uint)get_global_id(0);
    const uint item = (uint)get_local_id(0);
    const uint leaf = svo_leaf_at(slot, order, cursors, params);
    leaves[item] = leaf;
    if (leaf != SVO_NO_LEAF) {
        const svo_surface surface = SVO_SURFACE;
        const uint fragment = order != 0 ? order[slot] : slot;
        svo_put_pair(sums + item, surface, svo_fragment_triangle(fragments, fragment),
                     svo_fragment_code(fragments, fragment), params);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (leaf == SVO_NO_LEAF || (item > 0u && leaves[item - 1u] == leaf)) {
        return;
    }
    uint end = item + 1u;
    while (end < SVO_GROUP_ITEMS && leaves[end] == leaf) {
        ++end;
    }
    const bool goes_on = end == SVO_GROUP_ITEMS && svo_leaf_at(slot + end - item, order, cursors, params) == leaf;
    const bool began = item == 0u && slot > 0u && svo_leaf_at(slot - 1u, order, cursors, params) == leaf;
    const svo_run run = {sums + item, end - item, params.grouped != 0u && !began && !goes_on};
    svo_add_run(run, 0u, 1u, leaf, weights);
#ifdef SVO_COLOR
    svo_add_run(run, SVO_COLOR_WORD, 4u, leaf, color_sums);
#endif
#ifdef SVO_NORMAL
    svo_add_run(run, SVO_NORMAL_WORD, 3u, leaf, normal_sums);
#endif
#ifdef SVO_AREAS
    svo_add_run(run, SVO_AREA_WORD, 6u, leaf, area_sums);
#endif
    SVO_UNUSED(color_sums);
    SVO_UNUSED(normal_sums);
    SVO_UNUSED(area_sums);
}

#endif
