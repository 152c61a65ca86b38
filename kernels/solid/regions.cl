/* SPDX-License-Identifier: MIT */
/*
 * Which empty cells of a closed mesh are inside. Between the centers of two empty cells that share a face no surface
 * lies, so both have the same winding number: cells that are connected by faces make a region, and one line of one cell
 * decides for all of it. So the work is linear in the nodes, whatever the width of the mesh.
 *
 * Regions are found by a union-find structure whose roots are the smallest members (Jaiganesh and Burtscher, "A
 * High-Performance Connected Components Implementation for GPUs", 2018). A member is a part of a node: its empty
 * children that are connected within the node, named 8 node + the lowest octant. Nodes meet by links: what lies beside
 * a node in the six directions, from the links of its parent.
 *
 * Launch: svo_k_solid_join, one work-item per inner node of a level, levels in order down to that above the deepest:
 * gives its inner children their links, and joins their parts with those beside them. svo_k_solid_roots, one per inner
 * node: lists the regions. svo_k_solid_probe, one per region: decides it. svo_k_solid_spread, one per inner node of a
 * level: tells its empty children. All are rounded up to whole groups. Atomics: a root gets its parent by an exchange
 * that fails if it has one; which roots remain, and all sums, do not depend on their order. No local memory.
 */
#include "shared/nodes.clh"
#include "solid/column.clh"
#include "solid/voxel_sums.clh"

/* Links: a node, a part with SVO_LINK_PART added, or nothing. */
#define SVO_LINK_PART    0x80000000u
#define SVO_LINK_OUTSIDE 0xffffffffu

/* In place of a parent, which is 1 above the member, of decided roots. */
#define SVO_REGION_OUTSIDE 0xfffffffeu
#define SVO_REGION_INSIDE  0xffffffffu

/* The octants of some that are connected by faces with one of them. No two octants of a part are more than four steps
   from each other. */
static uint svo_part_of(uint octants, uint octant)
{
    uint part = 1u << octant;
    for (uint step = 0; step < 4u; ++step) {
        part |= (part & 0x55u) << 1 | (part & 0xaau) >> 1 | (part & 0x33u) << 2 | (part & 0xccu) >> 2 |
                (part & 0x0fu) << 4 | (part & 0xf0u) >> 4;
        part &= octants;
    }
    return part;
}

static uint svo_lowest_octant(uint octants)
{
    return popcount((octants & 0u - octants) - 1u);
}

static uint svo_member(uint node, uint part)
{
    return 8u * node + svo_lowest_octant(part);
}

/* ---- joining ---- */

/* The root of a member's region. Shortens the way for later ones. */
static uint svo_find_region(volatile __global uint *parents, uint member)
{
    for (;;) {
        const uint parent = parents[member];
        if (parent == 0u || parent >= SVO_REGION_OUTSIDE) {
            return member;
        }
        const uint above = parents[parent - 1u];
        if (above == 0u || above >= SVO_REGION_OUTSIDE) {
            return parent - 1u;
        }
        parents[member] = above;
        member = above - 1u;
    }
}

static void svo_join(volatile __global uint *parents, uint a, uint b)
{
    for (;;) {
        a = svo_find_region(parents, a);
        b = svo_find_region(parents, b);
        if (a == b || atomic_cmpxchg(parents + max(a, b), 0u, min(a, b) + 1u) == 0u) {
            return;
        }
    }
}

/* What a node has in an octant: an inner node, or a part that is empty. */
static uint svo_link_to(const svo_solid_tree *tree, uint node, uint octant)
{
    const uint mask = tree->child_mask[node];
    return (mask >> octant & 1u) != 0u ? svo_child_at(tree, node, octant)
                                       : SVO_LINK_PART | svo_member(node, svo_part_of(~mask & 255u, octant));
}

/* What lies beside a child in a direction. links: of its parent. */
static uint svo_link_of_child(const svo_solid_tree *tree, uint node, __global const uint *links, uint octant,
                              uint direction)
{
    const uint axis = direction >> 1;
    const uint across = octant ^ 1u << axis;
    if ((octant >> axis & 1u) != (direction & 1u)) {
        return svo_link_to(tree, node, across);
    }
    const uint link = node == 0u ? SVO_LINK_OUTSIDE : links[6u * (size_t)node + direction];
    return link >= SVO_LINK_PART ? link : svo_link_to(tree, link, across);
}

/* Joins the parts of a node with what lies beside it: an empty part, or a node in direction +axis. */
static void svo_join_across(const svo_solid_tree *tree, volatile __global uint *parents, uint node, uint link,
                            uint direction)
{
    const uint step = 1u << (direction >> 1);
    const uint upper = step == 1u ? 0xaau : step == 2u ? 0xccu : 0xf0u;
    const uint empty = ~(uint)tree->child_mask[node] & 255u;
    const bool meets_part = link >= SVO_LINK_PART;
    const uint beside = meets_part ? 0u : ~(uint)tree->child_mask[link] & 255u;
    uint left = empty & ((direction & 1u) != 0u ? upper : ~upper);
    if (link == SVO_LINK_OUTSIDE || (!meets_part && (direction & 1u) == 0u)) {
        return;
    }
    left &= meets_part ? 255u : beside << step;
    while (left != 0u) {
        const uint octant = svo_lowest_octant(left);
        const uint own = svo_part_of(empty, octant);
        const uint other = meets_part ? 0u : svo_part_of(beside, octant ^ step);
        svo_join(parents, svo_member(node, own), meets_part ? link & ~SVO_LINK_PART : svo_member(link, other));
        left &= ~(meets_part ? own : own & other << step); /* these meet no others */
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_solid_join(__global const uchar *child_mask, __global const uint *first_child, __global uint *links,
                 volatile __global uint *parents, svo_solid_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count) {
        return;
    }
    const svo_solid_tree tree = {child_mask, first_child, 0, 0, params.depth, params.leaf_begin, params.leaf_count};
    const uint node = params.first + item;
    const bool has_links = params.level + 2u < params.depth; /* its children's children are inner nodes, some of them */
    for (uint octant = 0; octant < 8u; ++octant) {
        if ((child_mask[node] >> octant & 1u) == 0u) {
            continue;
        }
        const uint child = svo_child_at(&tree, node, octant);
        for (uint direction = 0; direction < 6u; ++direction) {
            const uint link = svo_link_of_child(&tree, node, links, octant, direction);
            if (has_links) {
                links[6u * (size_t)child + direction] = link;
            }
            svo_join_across(&tree, parents, child, link, direction);
        }
    }
}

/* ---- deciding ---- */

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_solid_roots(__global const uchar *child_mask, volatile __global uint *parents, __global uint *roots,
                  volatile __global uint *counters, svo_solid_params params)
{
    const uint node = (uint)get_global_id(0);
    if (node >= params.count) {
        return;
    }
    const uint empty = ~(uint)child_mask[node] & 255u;
    for (uint left = empty; left != 0u;) {
        const uint part = svo_part_of(empty, svo_lowest_octant(left));
        const uint member = svo_member(node, part);
        left &= ~part;
        if (parents[member] == 0u) {
            const uint place = atomic_inc(counters + SVO_SOLID_REGIONS);
            if (place < params.region_max) {
                roots[place] = member;
            }
        }
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_solid_probe(__global const uchar *child_mask, __global const uint *first_child, __global const int *vertices,
                  __global const uint *indices, __global const uint *positions, __global const uint *list_begin,
                  __global const uint *list, __global const uint *roots, __global uint *parents, svo_decide_params grid,
                  svo_solid_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count) {
        return;
    }
    const svo_solid_tree tree = {child_mask, first_child, 0, 0, params.depth, params.leaf_begin, params.leaf_count};
    const svo_crossing_mesh mesh = {vertices, indices, positions, &grid};
    const uint member = roots[item];
    uint sums[3] = {0, 0, 0};
    svo_node place;
    svo_column_walk walk;
    svo_walk_up(child_mask, first_child, params.leaf_begin, member / 8u, &place);
    const uint cell_log2 = params.depth - place.level - 1u;
    for (uint axis = 0; axis < 3u; ++axis) {
        const uint cell = place.cell[axis] << 1 | (member >> axis & 1u);
        place.cell[axis] = (cell << cell_log2) + (1u << cell_log2 >> 1);
    }
    svo_walk_begin(&tree, place.cell, cell_log2, &walk);
    for (uint leaf = svo_walk_on(&tree, 0u, &walk); leaf != SVO_SOLID_NO_LEAF; leaf = svo_walk_on(&tree, 0u, &walk)) {
        for (uint i = list_begin[leaf]; i < list_begin[leaf + 1u]; ++i) {
            svo_add_crossings(&mesh, list[i], walk.at, &params, 1u, false, sums);
        }
    }
    parents[member] = svo_sum_is_inside(sums[0], params.rule) ? SVO_REGION_INSIDE : SVO_REGION_OUTSIDE;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_solid_spread(__global const uchar *child_mask, volatile __global uint *parents, __global uchar *inside_mask,
                   volatile __global uint *counters, svo_solid_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count) {
        return;
    }
    const uint node = params.first + item;
    const uint empty = ~(uint)child_mask[node] & 255u;
    uint inside = 0;
    for (uint left = empty; left != 0u;) {
        const uint part = svo_part_of(empty, svo_lowest_octant(left));
        const uint root = svo_find_region(parents, svo_member(node, part));
        inside |= parents[root] == SVO_REGION_INSIDE ? part : 0u;
        left &= ~part;
    }
    inside_mask[node] = (uchar)inside;
    if (inside != 0u) {
        atomic_add(counters + SVO_SOLID_INSIDE, popcount(inside));
    }
    if (empty != 0u) {
        atomic_add(counters + SVO_SOLID_TESTS, popcount(empty));
    }
}
