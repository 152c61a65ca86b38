/* SPDX-License-Identifier: MIT */
/*
 * Inner nodes of a changed tree whose radiance is made anew: below them or, for bricks, beside them are leaves whose
 * radiance is new, came or went, or that boxes touch. The others copy theirs from the light before.
 *
 *   svo_k_light_renewed       per inner node of a level, from the deepest level upwards: which of its children have
 *                             such leaves; tells the bricks that see them
 *   svo_k_light_leaves_again  per node above the leaves: the radiance of its lit leaves; bricks have none
 *
 * Launch: one work-item per node, rounded up to whole groups. No atomics: who writes a word writes the same. No local
 * memory.
 */
#include "light/kept_light.clh"
#include "light/nodes.clh"
#include "light/radiance.clh"
#include "shared/nodes.clh"

#ifdef SVO_LIGHT_BRICKS

/* Whether a neighbor of a node, -1, 0 or 1 along each axis, touches one of its children. */
static bool svo_touches_child(int3 step, uint children)
{
    bool touches = false;
    for (uint octant = 0; octant < 8u; ++octant) {
        const int3 side = 2 * (int3)((int)(octant & 1u), (int)(octant >> 1 & 1u), (int)(octant >> 2)) - 1;
        touches = touches || ((children >> octant & 1u) != 0u && all(step == 0 || step == side));
    }
    return touches;
}

/* Bricks have samples of leaves half a node away: those of neighbors that touch a child. */
static void svo_tell_bricks(__global const uchar *child_mask, __global const uint *first_child, ulong code, uint level,
                            uint children, __global uint *fresh)
{
    uint cell[3];
    uint around[27];
    svo_deinterleave(code, cell);
    svo_light_around(child_mask, first_child, (int3)((int)cell[0], (int)cell[1], (int)cell[2]), level, around);
    for (int k = 0; k < 27; ++k) {
        const int3 step = (int3)(k % 3, k / 3 % 3, k / 9) - 1;
        if (around[k] != SVO_NO_NODE && svo_touches_child(step, children)) {
            fresh[around[k]] = 1u;
        }
    }
}

#endif

/* renewed: of nodes above the leaves, the octants of their leaves that are new or went; receives those of all nodes.
   codes, fresh: of bricks. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_renewed(__global const uchar *child_mask, __global const uint *first_child, __global const uint *origins,
                    __global const ulong *codes, __global uint *renewed, __global uint *fresh, svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count) {
        return;
    }
    const uint node = params.first + item;
    const uint mask = child_mask[node];
    uint children = params.level + 1u == params.depth ? renewed[node] : 0u;
    uint child = first_child[node];
    for (uint octant = 0; octant < 8u && params.level + 1u < params.depth; ++octant) {
        if ((mask >> octant & 1u) != 0u) {
            children |= renewed[child] != 0u ? 1u << octant : 0u;
            ++child;
        }
    }
    children = origins[node] == SVO_NO_NODE ? mask : children;
    renewed[node] = children;
#ifdef SVO_LIGHT_BRICKS
    if (children != 0u) {
        svo_tell_bricks(child_mask, first_child, codes[node], params.level, children, fresh);
    }
#else
    (void)codes;
    (void)fresh;
#endif
}

#ifndef SVO_LIGHT_BRICKS

/* The words of a leaf from its values, and its opacities. */
static void svo_store_leaf(__global const uint *values, uint slot, __global const ushort *opacities, uint leaf,
                           __global uint *words)
{
#ifdef SVO_LIGHT_FACES
    for (uint direction = 0; direction < 6u; ++direction) {
        words[direction] = svo_radiance_encode(vload3(6u * (size_t)slot + direction, values));
    }
    (void)opacities;
    (void)leaf;
#else
    words[0] = svo_radiance_encode(svo_radiance_times(vload3(slot, values), opacities[leaf]));
#endif
}

/* old_child: of the tree before. slots, values: as svo_light_value_place has them. words: of a node. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_leaves_again(__global const uchar *child_mask, __global const uint *first_child,
                         __global const uint *old_child, __global const uint *slots, __global const uint *values,
                         __global const ushort *opacities, __global const uint *lit, SVO_KEPT_LIGHT_PARAMETERS,
                         __global uint *radiance, svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count) {
        return;
    }
    const uint node = params.first + item;
    const uint begin = first_child[node];
    const uint end = begin + popcount((uint)child_mask[node]);
    const bool stays = svo_light_stays(origins, fresh, node);
    const uint old_begin = stays ? old_child[origins[node]] : 0u;
    for (uint leaf = begin; leaf < end; ++leaf) {
        if (lit[leaf] == SVO_NO_NODE) {
            continue;
        }
        if (stays) {
            svo_copy_radiance(old_radiance, old_lit[old_begin + (leaf - begin)], radiance, lit[leaf], params.elements);
        } else {
            svo_store_leaf(values, slots[leaf - params.leaf_begin], opacities, leaf,
                           radiance + params.elements * (size_t)lit[leaf]);
        }
    }
}

#endif
