/* SPDX-License-Identifier: MIT */
/*
 * Merges full leaves: a node whose eight children are leaves becomes a leaf if their payload is equal, or if all of it
 * stays within a tolerance of what the node stores. One pass from the bottom to the top, then one back that drops what
 * lies below the new leaves.
 *
 *   svo_k_minimize_places   per inner node: where the payload of its inner children is
 *   svo_k_minimize_merge    per inner node of a level, from the deepest level up: its leaves, and whether it merges
 *   svo_k_minimize_keep     per inner node of a level, from the root down: which inner children remain
 *   scan.cl                 the new indices of nodes and of their children's payload
 *   svo_k_minimize_nodes    per inner node: its new arrays, and the old place of each new payload
 *   gather.cl               the new payload
 *
 * A merged node keeps the color, the normal and the material that it has had as an inner node. Tested against them are
 * the least and the greatest value of each component over all leaves of the tree below, which are handed up from level
 * to level: differences of differences would add tolerances up. A fill says how much surface is in a node of its own
 * size, so it cannot be compared across levels; a merged node stores the middle of its leaves' fills, which is their
 * value if they are equal.
 *
 * SVO_COMPARE: some payload is compared; SVO_COLOR, SVO_NORMAL, SVO_MATERIAL and SVO_FILL say which.
 * Launch: one work-item per element, rounded up to whole groups. No atomics, no local memory.
 */
#include "shared/layout.h"

/* The payload that is compared, by place. */
#define SVO_MINIMIZE_PAYLOAD                                                                       \
    __global const uchar *colors, __global const short *normals, __global const ushort *materials, \
        __global ushort *fills

#ifdef SVO_COMPARE

/* The least and the greatest payload of leaves. */
typedef struct svo_bounds {
    uchar4 color_least, color_greatest;
    short4 normal_least, normal_greatest;
    ushort fill_least, fill_greatest;
    uint material; /* SVO_NO_NODE: several */
} svo_bounds;

typedef char svo_bounds_bytes[sizeof(svo_bounds) == SVO_MINIMIZE_BOUNDS_BYTES ? 1 : -1];

/* The bounds of one leaf. What is not compared is 0. */
static svo_bounds svo_bounds_of_leaf(uint place, SVO_MINIMIZE_PAYLOAD)
{
    svo_bounds bounds;
    bounds.color_least = (uchar4)(0);
    bounds.normal_least = (short4)(0);
    bounds.fill_least = 0;
    bounds.material = 0u;
#ifdef SVO_COLOR
    bounds.color_least = vload4(place, colors);
#endif
#ifdef SVO_NORMAL
    bounds.normal_least.xyz = vload3(place, normals);
#endif
#ifdef SVO_FILL
    bounds.fill_least = fills[place];
#endif
#ifdef SVO_MATERIAL
    bounds.material = materials[place];
#endif
    bounds.color_greatest = bounds.color_least;
    bounds.normal_greatest = bounds.normal_least;
    bounds.fill_greatest = bounds.fill_least;
    (void)place;
    (void)colors;
    (void)normals;
    (void)materials;
    (void)fills;
    return bounds;
}

static svo_bounds svo_join_bounds(svo_bounds a, svo_bounds b)
{
    a.color_least = min(a.color_least, b.color_least);
    a.color_greatest = max(a.color_greatest, b.color_greatest);
    a.normal_least = min(a.normal_least, b.normal_least);
    a.normal_greatest = max(a.normal_greatest, b.normal_greatest);
    a.fill_least = min(a.fill_least, b.fill_least);
    a.fill_greatest = max(a.fill_greatest, b.fill_greatest);
    a.material = a.material == b.material ? a.material : SVO_NO_NODE;
    return a;
}

/* Whether all payload within the bounds is near enough to what the node at a place would store. */
static bool svo_is_near(svo_bounds bounds, uint place, svo_minimize_params params, SVO_MINIMIZE_PAYLOAD)
{
    bool is_near = bounds.material != SVO_NO_NODE;
#ifdef SVO_COLOR
    const int4 color = convert_int4(vload4(place, colors));
    const int4 color_tolerance =
        (int4)((int)(params.color_tolerance & 255u), (int)(params.color_tolerance >> 8 & 255u),
               (int)(params.color_tolerance >> 16 & 255u), (int)(params.color_tolerance >> 24));
    is_near = is_near && all(convert_int4(bounds.color_greatest) - color <= color_tolerance) &&
              all(color - convert_int4(bounds.color_least) <= color_tolerance);
#endif
#ifdef SVO_NORMAL
    const int3 normal = convert_int3(vload3(place, normals));
    const int3 normal_tolerance = (int3)((int)params.normal_tolerance);
    is_near = is_near && all(convert_int3(bounds.normal_greatest.xyz) - normal <= normal_tolerance) &&
              all(normal - convert_int3(bounds.normal_least.xyz) <= normal_tolerance);
#endif
#ifdef SVO_FILL
    is_near = is_near && (uint)bounds.fill_greatest - (uint)bounds.fill_least <= 2u * params.fill_tolerance;
#endif
#ifdef SVO_MATERIAL
    is_near = is_near && bounds.material == materials[place];
#endif
    (void)place;
    (void)params;
    (void)colors;
    (void)normals;
    (void)materials;
    (void)fills;
    return is_near;
}

#else

typedef void svo_bounds;

#endif

/* The place of each inner node's payload; the host sets that of the root. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_minimize_places(__global const uchar *valid, __global const uchar *leaf, __global const uint *first_inner,
                      __global const uint *first_payload, __global uint *places, svo_minimize_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.node_count) {
        return;
    }
    const uint node = params.first_node + item;
    const uint leaves = (uint)leaf[node];
    uint place = first_payload[node] - params.payload_begin;
    uint child = first_inner[node];
    for (uint octant = 0; octant < 8u; ++octant) {
        if ((valid[node] >> octant & 1u) != 0u) {
            if ((leaves >> octant & 1u) == 0u) {
                places[child] = place;
                ++child;
            }
            ++place;
        }
    }
}

/* below, bounds: of the merged nodes of the level below and of this one, from the level's first node on. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_minimize_merge(__global const uchar *valid, __global const uchar *leaf, __global const uint *first_inner,
                     __global const uint *first_payload, __global const uint *places, SVO_MINIMIZE_PAYLOAD,
                     __global const svo_bounds *below, __global svo_bounds *bounds, __global uchar *merged,
                     __global uchar *leaves, svo_minimize_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.node_count) {
        return;
    }
    const uint node = params.first_node + item;
    const uint mask = valid[node];
    const uint own = (uint)leaf[node];
    uint ended = own;
    uint child = first_inner[node];
    for (uint octant = 0; octant < 8u; ++octant) {
        if (((mask & ~own) >> octant & 1u) != 0u) {
            ended |= (uint)merged[child] << octant;
            ++child;
        }
    }
    leaves[node] = (uchar)ended;
    merged[node] = 0;
    if (ended != 255u || params.merge == 0u) {
        return;
    }
#ifdef SVO_COMPARE
    uint inner = first_inner[node] - params.child_first;
    const uint place = first_payload[node] - params.payload_begin;
    svo_bounds joined;
    for (uint octant = 0; octant < 8u; ++octant) {
        svo_bounds next;
        if ((own >> octant & 1u) != 0u) {
            next = svo_bounds_of_leaf(place + octant, colors, normals, materials, fills);
        } else {
            next = below[inner];
            ++inner;
        }
        joined = octant == 0u ? next : svo_join_bounds(joined, next);
    }
    if (!svo_is_near(joined, places[node], params, colors, normals, materials, fills)) {
        return;
    }
    bounds[item] = joined;
#ifdef SVO_FILL
    fills[places[node]] = (ushort)(((uint)joined.fill_least + joined.fill_greatest) / 2u);
#endif
#else
    (void)first_payload;
    (void)places;
    (void)colors;
    (void)normals;
    (void)materials;
    (void)fills;
    (void)below;
    (void)bounds;
#endif
    merged[node] = 1;
}

/* kept: 1 for inner nodes that remain; the host sets that of the root. counts: the children of those. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_minimize_keep(__global const uchar *valid, __global const uchar *leaf, __global const uint *first_inner,
                    __global const uchar *merged, __global uint *kept, __global uint *counts,
                    svo_minimize_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.node_count) {
        return;
    }
    const uint node = params.first_node + item;
    const uint end = first_inner[node] + popcount((uint)valid[node] & ~(uint)leaf[node]);
    const uint keep = kept[node];
    counts[node] = keep != 0u ? popcount((uint)valid[node]) : 0u;
    for (uint child = first_inner[node]; child < end; ++child) {
        kept[child] = keep != 0u && merged[child] == 0 ? 1u : 0u;
    }
}

/* inner_sums, child_sums: the exclusive sums of kept and of counts. Nodes and leaves together are numbered in
   breadth-first order, the root 0: first_payload. params.new_payload_begin is the first with payload. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_minimize_nodes(__global const uchar *valid, __global const uchar *leaves, __global const uint *first_inner,
                     __global const uint *first_payload, __global const uint *kept, __global const uint *inner_sums,
                     __global const uint *child_sums, __global uchar *new_valid, __global uchar *new_leaf,
                     __global uint *new_first_inner, __global uint *new_first_payload, __global uint *origins,
                     svo_minimize_params params)
{
    const uint node = (uint)get_global_id(0);
    if (node >= params.node_count || kept[node] == 0u) {
        return;
    }
    const uint target = inner_sums[node];
    const uint mask = valid[node];
    const uint first = child_sums[node] + 1u;
    new_valid[target] = (uchar)mask;
    new_leaf[target] = leaves[node];
    new_first_inner[target] = inner_sums[min(first_inner[node], params.node_count)];
    new_first_payload[target] = first;
    if (origins != 0 && first >= params.new_payload_begin) {
        const uint from = first_payload[node] - params.payload_begin;
        const uint to = first - params.new_payload_begin;
        for (uint k = 0; k < popcount(mask); ++k) {
            origins[to + k] = from + k;
        }
    }
}
