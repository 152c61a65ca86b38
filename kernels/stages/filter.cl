/* SPDX-License-Identifier: MIT */
/*
 * The payload, from the leaves up: mean color, mean normal and fill of every node, and the leaves' projected areas, in
 * integers.
 *
 *   svo_k_gather_level  on CPUs, per node of the deepest inner level: traverses its leaves' linked lists, sums each
 *                       triangle's contribution to the voxel, writes the leaves' payload and the node's sums. For lists
 *                       of one chunk
 *   svo_k_gather        on CPUs, per leaf of a chunk: the same into the leaf's sums, on top of those of earlier chunks
 *   pairs.cl            elsewhere, per fragment: the leaves' sums
 *   svo_k_filter        per node of a level, from the deepest level upwards: writes its children's payload and its own
 *                       sums
 *   svo_k_filter_top    the same for the few nodes of the top levels, by one group
 *   svo_k_round_areas   per leaf, after all chunks: writes the leaf's projected areas from their sums
 *
 * Invariant: sums are 64-bit and are passed up unrounded; each node rounds once, half up. So the result depends neither
 * on the order of the lists nor on how the fragments are cut into chunks. The plan chooses the unit of weight so that a
 * tree's weights add up to less than 2^46, which leaves headroom for the sums.
 *
 * Launch: one work-item per node or leaf, rounded up to whole groups. The first two kernels, with -DSVO_PAIR_LANES for
 * CPUs with fp64, have one per SVO_GATHER_NODES of them, a group of its own, which evaluates its pairs eight at a time
 * (pair_lanes.clh). No atomics: one work-item writes a node's sums.
 * Buffers: sums of one level each: weights (ulong), color (4 ulong a node), normal (3 long a node); of the leaves, for
 * lists of several chunks: areas (6 ulong a leaf).
 */
#include "shared/fragment.clh"
#include "shared/state.clh"
#include "stages/leaf_windows.clh"
#include "stages/payload.clh"

#ifdef SVO_GATHERED

/* A last argument, which only kernels with projected areas have. */
#ifdef SVO_AREAS
#define SVO_AND_AREAS(type, name) , __global type *name
#else
#define SVO_AND_AREAS(type, name)
#endif

#ifdef SVO_PAIR_LANES

__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void
svo_k_gather(__global const uint *fragments, __global const uint *links, __global const uint *heads,
             SVO_SURFACE_PARAMETERS, __global ulong *weights, __global ulong *color_sums, __global long *normal_sums,
             __global const svo_build_state *state, svo_filter_params params SVO_AND_AREAS(ulong, area_sums))
{
    svo_make_current(&params, state);
    const uint begin = params.first_index + (uint)get_global_id(0) * SVO_ITEM_NODES;
    const uint end = min(begin + SVO_ITEM_NODES, params.leaf_count);
    const svo_surface surface = SVO_SURFACE;
    svo_lists lists;
    svo_lists_open(&lists, surface, fragments, links, heads, begin, end);
    for (uint leaf = begin; leaf < end; ++leaf) {
        svo_sums sums = svo_no_sums();
        if (params.first_chunk == 0u) {
            sums = svo_load_sums(leaf, weights, color_sums, normal_sums);
#ifdef SVO_AREAS
            sums.areas = svo_load_areas(leaf, area_sums);
#endif
        }
        svo_lists_sum(&lists, leaf, params, &sums);
        svo_store_sums(sums, leaf, weights, color_sums, normal_sums);
#ifdef SVO_AREAS
        svo_keep_areas(sums.areas, leaf, area_sums);
#endif
    }
}

/* What svo_k_gather_level reads and writes besides the lists. */
typedef struct svo_gathered {
    __global const uchar *masks;
    __global const uint *first_child;
    svo_payload payload;
    __global ulong *weights, *color_sums;
    __global long *normal_sums;
    __global ushort *areas;
} svo_gathered;

/* Sums up the leaves of some nodes of the level. lists: of those leaves; leaf: the first of them. */
SVO_CALLED void svo_gather_nodes(svo_lists *lists, const svo_gathered *to, uint begin, uint end, uint leaf,
                                 svo_filter_params params)
{
    for (uint index = begin; index < end; ++index) {
        const uint node = params.level_begin + index;
        const uint leaf_end = leaf + popcount((uint)to->masks[node]);
        svo_sums sums = svo_no_sums();
        for (; leaf < leaf_end; ++leaf) {
            svo_sums part = svo_no_sums();
            svo_lists_sum(lists, leaf - params.leaf_begin, params, &part);
            svo_store_payload(part, leaf - params.payload_begin, to->payload, params.fill_shift);
#ifdef SVO_AREAS
            svo_store_areas(part.areas, leaf - params.leaf_begin, to->areas);
#endif
            sums = svo_join_sums(sums, part);
        }
        svo_store_sums(sums, index, to->weights, to->color_sums, to->normal_sums);
        if (params.payload_begin == 0u) {
            svo_store_root(sums, node, to->payload, params.fill_shift);
        }
    }
}

__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void
svo_k_gather_level(__global const uint *fragments, __global const uint *links, __global const uint *heads,
                   SVO_SURFACE_PARAMETERS, __global ulong *weights, __global ulong *color_sums,
                   __global long *normal_sums, __global const uchar *masks, __global const uint *first_child,
                   __global uint *colors, __global short *normals, __global ushort *fills,
                   __global const svo_build_state *state, svo_filter_params params SVO_AND_AREAS(ushort, areas))
{
    svo_make_current(&params, state);
    const uint begin = params.first_index + (uint)get_global_id(0) * SVO_ITEM_NODES;
    const uint end = min(begin + SVO_ITEM_NODES, params.level_count);
    if (begin >= end) {
        return;
    }
    const uint last = params.level_begin + end - 1u;
    const uint leaf = first_child[params.level_begin + begin];
    const uint last_leaf = first_child[last] + popcount((uint)masks[last]);
    const svo_surface surface = SVO_SURFACE;
    svo_lists lists;
    svo_lists_open(&lists, surface, fragments, links, heads, leaf - params.leaf_begin, last_leaf - params.leaf_begin);
    svo_gathered to = {masks, first_child, {colors, normals, fills}, weights, color_sums, normal_sums, 0};
#ifdef SVO_AREAS
    to.areas = areas;
#endif
    svo_gather_nodes(&lists, &to, begin, end, leaf, params);
}

#endif

#ifdef SVO_AREAS

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_round_areas(__global const ulong *area_sums, __global ushort *areas, __global const svo_build_state *state,
                  svo_filter_params params)
{
    svo_make_current(&params, state);
    const uint leaf = params.first_index + (uint)get_global_id(0);
    if (leaf < params.leaf_count) {
        svo_store_areas(svo_load_areas(leaf, area_sums), leaf, areas);
    }
}

#endif

#ifdef SVO_NODE_PAYLOAD

/* The sums of a level, indexed from its first node. */
typedef struct svo_level_sums {
    __global ulong *weights, *color;
    __global long *normal;
} svo_level_sums;

/* index: from the level's first node; payload is indexed from the first node that has payload. */
SVO_CALLED void svo_filter_node(uint index, __global const uchar *masks, __global const uint *first_child,
                                svo_level_sums children, svo_level_sums nodes, svo_payload payload,
                                svo_filter_params params)
{
    const uint node = params.level_begin + index;
    const uint begin = first_child[node];
    const uint end = begin + popcount((uint)masks[node]);
    svo_sums sums = svo_no_sums();
    for (uint child = begin; child < end; ++child) {
        const svo_sums part =
            svo_load_sums(child - params.child_begin, children.weights, children.color, children.normal);
        svo_store_payload(part, child - params.payload_begin, payload, params.fill_shift);
        sums = svo_join_sums(sums, part);
    }
    svo_store_sums(sums, index, nodes.weights, nodes.color, nodes.normal);
    if (params.payload_begin == 0u) {
        svo_store_root(sums, node, payload, params.fill_shift);
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_filter(__global const uchar *masks, __global const uint *first_child, __global ulong *child_weights,
             __global ulong *child_color_sums, __global long *child_normal_sums, __global ulong *weights,
             __global ulong *color_sums, __global long *normal_sums, __global uint *colors, __global short *normals,
             __global ushort *fills, __global const svo_build_state *state, svo_filter_params params)
{
    svo_make_current(&params, state);
    const uint index = params.first_index + (uint)get_global_id(0);
    if (index < params.level_count) {
        const svo_level_sums children = {child_weights, child_color_sums, child_normal_sums};
        const svo_level_sums nodes = {weights, color_sums, normal_sums};
        const svo_payload payload = {colors, normals, fills};
        svo_filter_node(index, masks, first_child, children, nodes, payload, params);
    }
}

/* The first of a group's work-items that share a top level, and how many do. On CPUs one does, without barriers, which
   take PoCL a fifth of a second to compile. */
#ifdef SVO_PAIR_LANES
#define SVO_TOP_ITEM  0u
#define SVO_TOP_ITEMS 1u
#else
#define SVO_TOP_ITEM  ((uint)get_local_id(0))
#define SVO_TOP_ITEMS SVO_GROUP_ITEMS
#endif

/* params.level: the first of the levels, which is at most SVO_TOP_LEVEL. Launch: one group. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_filter_top(__global const uchar *masks, __global const uint *first_child, __global ulong *child_weights,
                 __global ulong *child_color_sums, __global long *child_normal_sums, __global ulong *weights,
                 __global ulong *color_sums, __global long *normal_sums, __global uint *colors, __global short *normals,
                 __global ushort *fills, __global const svo_build_state *state, svo_filter_params params)
{
    svo_level_sums children = {child_weights, child_color_sums, child_normal_sums};
    svo_level_sums nodes = {weights, color_sums, normal_sums};
    const svo_payload payload = {colors, normals, fills};
    const uint last = max(params.payload_level, 1u) - 1u; /* nodes write the payload of their children */
#ifdef SVO_PAIR_LANES
    if (get_local_id(0) != 0u) {
        return;
    }
#endif
    for (uint level = params.level + 1u; level-- > last;) {
        svo_filter_params current = params; /* of which drivers may have one for all work-items */
        current.level = level;
        current.fill_shift += 2u * (params.level - level);
        svo_make_current(&current, state);
        for (uint index = SVO_TOP_ITEM; index < current.level_count; index += SVO_TOP_ITEMS) {
            svo_filter_node(index, masks, first_child, children, nodes, payload, current);
        }
#ifndef SVO_PAIR_LANES
        barrier(CLK_GLOBAL_MEM_FENCE);
#endif
        const svo_level_sums above = children;
        children = nodes;
        nodes = above;
    }
}

#endif

#endif
