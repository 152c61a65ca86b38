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
 * Launch: one work-item per node or value, rounded up to whole groups. No atomics, no local memory.
 */
#include "light/extinction.clh"
#include "light/opacity.clh"

#ifdef SVO_LIGHT_FACES

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
        const uint area = svo_leaf_area(areas, leaf, direction);
        opacities[to + direction] = (ushort)svo_leaf_opacity(alpha, area);
        covers[to + direction] = (ushort)((2u * area * alpha + 255u) / 510u);
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

#endif
