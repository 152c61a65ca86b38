/* SPDX-License-Identifier: MIT */
/*
 * The part of a tree's grid that is occupied, on one level, for the boxes of its instances. The options of read.clh
 * select how nodes are read.
 *
 * Launch: one work-item per cell of the level, one dimension, rounded up to whole groups. Each walks down from the root
 * to its cell. Reads the nodes; writes the bounds of the tree: least x, y, z, and one past the greatest, which the host
 * sets to the empty box before. Atomics: least and greatest numbers, which no order changes. No local memory.
 */
#include "shared/scene_layout.h"

#include "rays/read.clh"

/* Whether the cell of a level holds a node, or lies in a leaf. */
static bool svo_scene_is_occupied(const svo_cast_nodes *nodes, uint3 cell, uint level)
{
    svo_cast_node node = SVO_CAST_ROOT(nodes);
    for (uint left = level; left > 0u; --left) {
        const uint3 bits = cell >> (left - 1u) & 1u;
        svo_cast_node child;
        const uint kind = svo_cast_open(nodes, node, bits.x | bits.y << 1 | bits.z << 2, &child);
        if (kind != SVO_CHILD_NODE) {
            return kind != SVO_CHILD_NONE;
        }
        node = child;
    }
    return true;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_scene_bounds(SVO_NODES_PARAMETERS, __global const svo_scene_tree *trees, uint tree, uint level,
                   __global int *all_bounds)
{
    const uint item = (uint)get_global_id(0);
    const uint last = (1u << level) - 1u;
    const uint3 cell = (uint3)(item & last, item >> level & last, item >> 2u * level);
    if (cell.z > last) {
        return;
    }
    SVO_NODES_MAKE(nodes);
    svo_cast_shift(&nodes, trees[tree].begin);
    if (!svo_scene_is_occupied(&nodes, cell, level)) {
        return;
    }
    volatile __global int *bounds = all_bounds + 6u * tree;
    atomic_min(bounds, (int)cell.x);
    atomic_min(bounds + 1, (int)cell.y);
    atomic_min(bounds + 2, (int)cell.z);
    atomic_max(bounds + 3, (int)cell.x + 1);
    atomic_max(bounds + 4, (int)cell.y + 1);
    atomic_max(bounds + 5, (int)cell.z + 1);
}
