/* SPDX-License-Identifier: MIT */
/*
 * Radiance from the lit leaves upwards, for the nodes alone where there is any.
 *
 *   svo_k_light_mark_leaves   per lit leaf: a 1
 *   svo_k_light_mark_level    per inner node of a level, from the deepest level upwards: whether a leaf below is lit
 *   svo_k_light_mark_bricks   per inner node of a level: whether a cell that touches the node is lit, so that samples
 *                             of its brick can be
 *   svo_k_light_places        per node: from the exclusive sums of the marks to places in the radiance buffer
 *   svo_k_light_lit_faces     per lit leaf: stores its radiance
 *   svo_k_light_lit_voxels    the same for one value a node
 *   svo_k_light_face_light    per lit node of a level, upwards: what leaves the front of a pair of children, and what
 *                             leaves the back as far as the front lets it pass; mean over the four pairs
 *   svo_k_light_voxel_light   per lit node of a level, upwards: the mean over its eight cells
 *
 * Launch: one work-item per node or lit leaf, rounded up to whole groups. No atomics, no local memory.
 */
#include "light/extinction.clh"
#include "light/kept_light.clh"
#include "light/nodes.clh"
#include "light/opacity.clh"
#include "light/radiance.clh"
#include "shared/nodes.clh"

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_mark_leaves(__global const uint *leaves, __global uint *marks, svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    if (item < params.count) {
        marks[params.leaf_begin + leaves[item]] = 1u;
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_mark_level(__global const uchar *child_mask, __global const uint *first_child, __global uint *marks,
                       svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count) {
        return;
    }
    const uint node = params.first + item;
    const uint end = first_child[node] + popcount((uint)child_mask[node]);
    uint lit = 0u;
    for (uint child = first_child[node]; child < end; ++child) {
        lit |= marks[child];
    }
    marks[node] = lit;
}

/* lit: SVO_NO_NODE where there is no radiance. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_places(__global const uint *marks, __global const uint *sums, __global uint *lit, svo_light_step params)
{
    const uint node = (uint)get_global_id(0);
    if (node < params.count) {
        lit[node] = marks[node] != 0u ? sums[node] : SVO_NO_NODE;
    }
}

#ifdef SVO_LIGHT_BRICKS

/* Whether a cell that touches the node, of its children's size, is lit. */
static bool svo_is_lit_beside(__global const uchar *child_mask, __global const uint *first_child,
                              __global const ulong *codes, __global const uint *marks, uint node, uint level)
{
    uint at[3];
    uint around[27];
    uint cells[64];
    svo_deinterleave(codes[node], at);
    svo_light_around(child_mask, first_child, (int3)((int)at[0], (int)at[1], (int)at[2]), level, around);
    for (uint k = 0; k < 27u; ++k) {
        /* What is dark has no lit children. */
        around[k] = around[k] != SVO_NO_NODE && marks[around[k]] != 0u ? around[k] : SVO_NO_NODE;
    }
    svo_light_children_around(child_mask, first_child, around, cells);
    bool lit = false;
    for (uint k = 0; k < 64u; ++k) {
        lit = lit || (cells[k] != SVO_NO_NODE && marks[cells[k]] != 0u);
    }
    return lit;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_mark_bricks(__global const uchar *child_mask, __global const uint *first_child, __global const ulong *codes,
                        __global const uint *marks, SVO_KEPT_LIGHT_PARAMETERS, __global uint *brick_marks,
                        svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count) {
        return;
    }
    const uint node = params.first + item;
    (void)old_radiance;
    if (svo_light_stays(origins, fresh, node)) {
        brick_marks[node] = old_lit[origins[node]] != SVO_NO_NODE ? 1u : 0u;
        return;
    }
    brick_marks[node] =
        marks[node] != 0u || svo_is_lit_beside(child_mask, first_child, codes, marks, node, params.level);
}

#endif

#ifdef SVO_LIGHT_FACES

/* slots: of svo_light_value_place. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_lit_faces(__global const uint *leaves, __global const uint *slots, __global const uint *values,
                      __global const uint *lit, __global uint *radiance, svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count) {
        return;
    }
    const size_t from = 6u * (size_t)svo_light_value_place(leaves, slots, item);
    const size_t place = 6u * (size_t)lit[params.leaf_begin + leaves[item]];
    for (uint direction = 0; direction < 6u; ++direction) {
        radiance[place + direction] = svo_radiance_encode(vload3(from + direction, values));
    }
}

/* Adds the light of a node's child to the six sums of the node, which are its radiance times 4 * 65535. On each axis
   the child is in front for one direction, and for the other behind the child on the other side. place: of its
   words. */
static void svo_add_face_light(const uint *children, uint octant, uint place, __global const ushort *extinctions,
                               __global const uint *radiance, ulong3 *sums)
{
    __global const uint *words = radiance + 6u * (size_t)place;
    for (uint axis = 0; axis < 3u; ++axis) {
        const uint front = 2u * axis + (octant >> axis & 1u);
        const uint back = front ^ 1u;
        const uint before = children[octant ^ 1u << axis];
        const uint passing =
            before != SVO_NO_NODE ? svo_passing_of(extinctions[6u * (size_t)before + back]) : SVO_OPACITY_ONE;
        sums[front] += convert_ulong3(svo_radiance_decode(words[front])) * (ulong)SVO_OPACITY_ONE;
        sums[back] += convert_ulong3(svo_radiance_decode(words[back])) * (ulong)passing;
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_face_light(__global const uchar *child_mask, __global const uint *first_child,
                       __global const ushort *extinctions, __global const uint *lit, SVO_KEPT_LIGHT_PARAMETERS,
                       __global uint *radiance, svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    const uint node = params.first + item;
    if (item >= params.count || lit[node] == SVO_NO_NODE) {
        return;
    }
    if (svo_light_stays(origins, fresh, node)) {
        svo_copy_radiance(old_radiance, old_lit[origins[node]], radiance, lit[node], 6u);
        return;
    }
    uint children[8];
    ulong3 sums[6];
    for (uint octant = 0; octant < 8u; ++octant) {
        children[octant] = svo_light_child(child_mask, first_child, node, octant);
    }
    for (uint direction = 0; direction < 6u; ++direction) {
        sums[direction] = (ulong3)(2ul * SVO_OPACITY_ONE);
    }
    for (uint octant = 0; octant < 8u; ++octant) {
        const uint place = children[octant] != SVO_NO_NODE ? lit[children[octant]] : SVO_NO_NODE;
        if (place != SVO_NO_NODE) {
            svo_add_face_light(children, octant, place, extinctions, radiance, sums);
        }
    }
    for (uint direction = 0; direction < 6u; ++direction) {
        radiance[6u * (size_t)lit[node] + direction] =
            svo_radiance_encode(convert_uint3_sat(sums[direction] / (4ul * SVO_OPACITY_ONE)));
    }
}

#endif

#ifdef SVO_LIGHT_VOXELS

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_lit_voxels(__global const uint *leaves, __global const uint *slots, __global const uint *values,
                       __global const ushort *opacities, __global const uint *lit, __global uint *radiance,
                       svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    if (item < params.count) {
        const uint node = params.leaf_begin + leaves[item];
        const uint3 value = vload3(svo_light_value_place(leaves, slots, item), values);
        radiance[lit[node]] = svo_radiance_encode(svo_radiance_times(value, opacities[node]));
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_voxel_light(__global const uchar *child_mask, __global const uint *first_child, __global const uint *lit,
                        SVO_KEPT_LIGHT_PARAMETERS, __global uint *radiance, svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    const uint node = params.first + item;
    if (item >= params.count || lit[node] == SVO_NO_NODE) {
        return;
    }
    if (svo_light_stays(origins, fresh, node)) {
        svo_copy_radiance(old_radiance, old_lit[origins[node]], radiance, lit[node], 1u);
        return;
    }
    const uint end = first_child[node] + popcount((uint)child_mask[node]);
    ulong3 sum = (ulong3)(4ul);
    for (uint child = first_child[node]; child < end; ++child) {
        sum += lit[child] != SVO_NO_NODE ? convert_ulong3(svo_radiance_decode(radiance[lit[child]])) : (ulong3)(0ul);
    }
    radiance[lit[node]] = svo_radiance_encode(convert_uint3(sum / 8ul));
}

#endif
