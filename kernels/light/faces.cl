/* SPDX-License-Identifier: MIT */
/*
 * Six opacities a node, for rays along +x, -x, +y, -y, +z, -z (after Crassin et al., "Interactive Indirect Illumination
 * Using Voxel Cone Tracing", 2011), and beside them how much of its face the node's surface covers, seen that way.
 *
 *   svo_k_light_face_leaves       per leaf: opacities and covers
 *   svo_k_light_face_level        per inner node of a level, from the deepest level upwards: through a pair of children
 *                                 that lie behind each other passes what passes through both; mean over the four pairs
 *   svo_k_light_face_extinctions  per value, at last: opacities to extinctions, in place
 *
 * and of a changed tree, after svo_k_light_keep, with the opacities of inner nodes beside their extinctions, which say
 * too little of small ones:
 *
 *   svo_k_light_face_leaves_again  per node above the leaves: copies what the light before has of its leaves, or makes
 *                                  it
 *   svo_k_light_face_level_again   per inner node without an origin of a level, from the deepest level upwards
 *
 * Launch: one work-item per node or value, rounded up to whole groups. No atomics, no local memory.
 */
#include "light/extinction.clh"
#include "light/nodes.clh"
#include "light/opacity.clh"

#ifdef SVO_LIGHT_FACES

static ushort svo_face_cover(uint alpha, uint area)
{
    return (ushort)((2u * area * alpha + 255u) / 510u);
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_face_leaves(__global const uchar *colors, __global const ushort *areas, __global ushort *opacities,
                        __global ushort *covers, svo_light_step params)
{
    const uint leaf = (uint)get_global_id(0);
    if (leaf >= params.count) {
        return;
    }
    const uint alpha = svo_leaf_alpha(colors, leaf, params);
    const size_t to = 6u * (size_t)(params.leaf_begin + leaf);
    for (uint direction = 0; direction < 6u; ++direction) {
        const uint area = svo_leaf_area(areas, leaf, direction, params.flags);
        opacities[to + direction] = (ushort)svo_leaf_opacity(alpha, area);
        covers[to + direction] = svo_face_cover(alpha, svo_leaf_front(areas, leaf, direction));
    }
}

/* The opacities in one direction of eight cells, to that of the node. */
static uint svo_face_opacity(const uint *cells, uint axis)
{
    ulong passes = 0;
    for (uint octant = 0; octant < 8u; ++octant) {
        if ((octant >> axis & 1u) == 0u) {
            passes += (ulong)(SVO_OPACITY_ONE - cells[octant]) * (SVO_OPACITY_ONE - cells[octant | 1u << axis]);
        }
    }
    return SVO_OPACITY_ONE - (uint)((passes + 2u * SVO_OPACITY_ONE) / (4u * SVO_OPACITY_ONE));
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_face_level(__global const uchar *child_mask, __global const uint *first_child, __global ushort *opacities,
                       __global ushort *covers, svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count) {
        return;
    }
    const uint node = params.first + item;
    const uint mask = child_mask[node];
    const uint first = first_child[node];
    for (uint direction = 0; direction < 6u; ++direction) {
        uint cells[8];
        uint cover = 2u;
        uint child = first;
        for (uint octant = 0; octant < 8u; ++octant) {
            const size_t at = 6u * (size_t)child + direction;
            const bool occupied = (mask >> octant & 1u) != 0u;
            cells[octant] = occupied ? opacities[at] : 0u;
            cover += occupied ? covers[at] : 0u;
            child += occupied ? 1u : 0u;
        }
        opacities[6u * (size_t)node + direction] = (ushort)svo_face_opacity(cells, direction >> 1);
        covers[6u * (size_t)node + direction] = (ushort)min(cover / 4u, 65535u);
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_face_extinctions(__global ushort *opacities, svo_light_step params)
{
    const size_t at = get_global_id(0);
    if (at < 6u * (size_t)params.count) {
        opacities[at] = (ushort)svo_extinction_of(opacities[at]);
    }
}

/* old_child, old_opacities, old_covers: of the tree before and its light. opacities: extinctions, as the old ones. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_face_leaves_again(__global const uchar *child_mask, __global const uint *first_child,
                              __global const uint *origins, __global const uint *old_child,
                              __global const uchar *colors, __global const ushort *areas,
                              __global const ushort *old_opacities, __global const ushort *old_covers,
                              __global ushort *opacities, __global ushort *covers, svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count) {
        return;
    }
    const uint node = params.first + item;
    const uint values = 6u * popcount((uint)child_mask[node]);
    const size_t to = 6u * (size_t)first_child[node];
    const uint first_leaf = first_child[node] - params.leaf_begin;
    const uint origin = origins[node];
    if (origin != SVO_NO_NODE) {
        const size_t from = 6u * (size_t)old_child[origin];
        for (uint k = 0; k < values; ++k) {
            opacities[to + k] = old_opacities[from + k];
            covers[to + k] = old_covers[from + k];
        }
        return;
    }
    for (uint k = 0; k < values; ++k) {
        const uint alpha = svo_leaf_alpha(colors, first_leaf + k / 6u, params);
        const uint area = svo_leaf_area(areas, first_leaf + k / 6u, k % 6u, params.flags);
        opacities[to + k] = (ushort)svo_extinction_of(svo_leaf_opacity(alpha, area));
        covers[to + k] = svo_face_cover(alpha, svo_leaf_front(areas, first_leaf + k / 6u, k % 6u));
    }
}

/* node_opacities: of inner nodes. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_face_level_again(__global const uchar *child_mask, __global const uint *first_child,
                             __global const uint *origins, __global const uchar *colors, __global const ushort *areas,
                             __global ushort *node_opacities, __global ushort *opacities, __global ushort *covers,
                             svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    const uint node = params.first + item;
    if (item >= params.count || svo_light_is_kept(origins, node)) {
        return;
    }
    const uint mask = child_mask[node];
    const bool above_leaves = params.level + 1u == params.depth;
    for (uint direction = 0; direction < 6u; ++direction) {
        uint cells[8];
        uint cover = 2u;
        uint child = first_child[node];
        for (uint octant = 0; octant < 8u; ++octant) {
            cells[octant] = 0u;
            if ((mask >> octant & 1u) == 0u) {
                continue;
            }
            const uint leaf = child - params.leaf_begin;
            cells[octant] = above_leaves ? svo_leaf_opacity(svo_leaf_alpha(colors, leaf, params),
                                                            svo_leaf_area(areas, leaf, direction, params.flags))
                                         : node_opacities[6u * (size_t)child + direction];
            cover += covers[6u * (size_t)child + direction];
            ++child;
        }
        const size_t to = 6u * (size_t)node + direction;
        const uint opacity = svo_face_opacity(cells, direction >> 1);
        node_opacities[to] = (ushort)opacity;
        opacities[to] = (ushort)svo_extinction_of(opacity);
        covers[to] = (ushort)min(cover / 4u, 65535u);
    }
}

#endif
