/* SPDX-License-Identifier: MIT */
/*
 * Which parts of the surface may be nearest to a cell's voxels: from the candidates of a cell to those of its eight
 * children, breadth-first from the root. Candidates are nodes of the octree on the cell's own level; every node holds
 * surface. So the distance from any voxel of a cell to the surface is at most the largest one to any point of a node,
 * and a node that is farther from the whole cell than that of another one cannot hold the nearest point. A child's
 * candidates are among the children of its parent's, and with a reach those within it: then there are at most 27 where
 * cells are as wide as the reach.
 *
 * Distances are those from the box of the cell's voxel centers, in widths of a cell, and squared. A margin covers the
 * rounding of floats.
 *
 * Launch: both, one work-item per child of a cell, rounded up to whole groups. svo_k_sdf_count writes the bound and the
 * number of candidates of each child, and whether there are any; the host adds these up, and svo_k_sdf_refine writes
 * the children that have candidates, in Morton order. No atomics, no local memory.
 */
#include "shared/sdf_layout.h"

#pragma OPENCL FP_CONTRACT OFF

#define SVO_SDF_MARGIN (1.0f + 0x1p-20f)

/* A child of a cell, and what is near it. */
typedef struct svo_sdf_child {
    int4 place; /* w: 0 */
    float inset; /* from the cell's faces to the first centers of voxels */
    float bound; /* squared distance: farther nodes are no candidates */
} svo_sdf_child;

static void svo_sdf_begin_child(__global const int4 *cells, uint item, const svo_sdf_params *params,
                                svo_sdf_child *child)
{
    const uint octant = item & 7u;
    const float width = (float)(1u << (params->depth - params->level - 1u)); /* of a child, in voxels */
    child->place = 2 * cells[params->first + (item >> 3)] +
                   (int4)((int)(octant & 1u), (int)(octant >> 1 & 1u), (int)(octant >> 2), 0);
    child->place.w = 0;
    child->inset = 0.5f / width;
    child->bound = params->reach / width * (params->reach / width) * SVO_SDF_MARGIN;
}

static float svo_sdf_square(float4 away)
{
    return away.x * away.x + away.y * away.y + away.z * away.z;
}

/* The squared distance to a node of the level above. */
static float svo_sdf_near_parent(const svo_sdf_child *child, int4 node)
{
    const float4 below = convert_float4(2 * node - child->place) - 1.0f + child->inset;
    const float4 above = convert_float4(child->place - 2 * node) - 2.0f + child->inset;
    return svo_sdf_square(max(max(below, above), (float4)(0.0f)));
}

static float4 svo_sdf_away(const svo_sdf_child *child, int4 node)
{
    return fabs(convert_float4(node - child->place));
}

static float svo_sdf_near(const svo_sdf_child *child, int4 node)
{
    return svo_sdf_square(max(svo_sdf_away(child, node) - 1.0f + child->inset, (float4)(0.0f)));
}

/* The largest squared distance to any point of a node. */
static float svo_sdf_far(const svo_sdf_child *child, int4 node)
{
    return svo_sdf_square(svo_sdf_away(child, node) + 1.0f - child->inset);
}

/* A node's child in an octant; w: to be set. */
static int4 svo_sdf_below(int4 node, uint octant)
{
    return 2 * node + (int4)((int)(octant & 1u), (int)(octant >> 1 & 1u), (int)(octant >> 2), 0);
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_sdf_count(__global const uchar *child_mask, __global const int4 *cells, __global const uint *begin,
                __global const int4 *candidates, __global float *bounds, __global uint *counts, __global uint *exist,
                svo_sdf_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= 8u * params.count) {
        return;
    }
    const uint first = begin[params.first + (item >> 3)];
    const uint end = begin[params.first + (item >> 3) + 1u];
    svo_sdf_child child;
    uint count = 0;
    svo_sdf_begin_child(cells, item, &params, &child);
    for (uint i = first; i < end; ++i) {
        const int4 node = candidates[i];
        if (svo_sdf_near_parent(&child, node) > child.bound) {
            continue;
        }
        const uint mask = child_mask[node.w];
        for (uint octant = 0; octant < 8u; ++octant) {
            if ((mask >> octant & 1u) != 0u) {
                child.bound = min(child.bound, svo_sdf_far(&child, svo_sdf_below(node, octant)) * SVO_SDF_MARGIN);
            }
        }
    }
    for (uint i = first; i < end; ++i) {
        const int4 node = candidates[i];
        if (svo_sdf_near_parent(&child, node) > child.bound) {
            continue;
        }
        const uint mask = child_mask[node.w];
        for (uint octant = 0; octant < 8u; ++octant) {
            const bool is_near = svo_sdf_near(&child, svo_sdf_below(node, octant)) <= child.bound;
            count += is_near ? mask >> octant & 1u : 0u;
        }
    }
    bounds[item] = child.bound;
    counts[item] = count;
    exist[item] = count > 0u ? 1u : 0u;
}

/* sums, places: those of counts and exist before each child. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_sdf_refine(__global const uchar *child_mask, __global const uint *first_child, __global const int4 *cells,
                 __global const uint *begin, __global const int4 *candidates, __global const float *bounds,
                 __global const uint *sums, __global const uint *places, __global int4 *child_cells,
                 __global uint *child_begin, __global int4 *child_candidates, svo_sdf_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= 8u * params.count) {
        return;
    }
    const uint place = places[item];
    uint to = sums[item];
    svo_sdf_child child;
    if (item + 1u == 8u * params.count) {
        child_begin[places[item + 1u]] = sums[item + 1u];
    }
    if (places[item + 1u] == place) {
        return;
    }
    svo_sdf_begin_child(cells, item, &params, &child);
    child.bound = bounds[item];
    child_cells[place] = child.place;
    child_begin[place] = to;
    const uint end = begin[params.first + (item >> 3) + 1u];
    for (uint i = begin[params.first + (item >> 3)]; i < end; ++i) {
        const int4 node = candidates[i];
        if (svo_sdf_near_parent(&child, node) > child.bound) {
            continue;
        }
        const uint mask = child_mask[node.w];
        int index = (int)first_child[node.w];
        for (uint octant = 0; octant < 8u; ++octant) {
            if ((mask >> octant & 1u) == 0u) {
                continue;
            }
            int4 below = svo_sdf_below(node, octant);
            below.w = index++;
            if (svo_sdf_near(&child, below) <= child.bound) {
                child_candidates[to++] = below;
            }
        }
    }
}
