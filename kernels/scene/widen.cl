/* SPDX-License-Identifier: MIT */
/*
 * The wide hierarchy of CPUs from the binary one: eight boxes are met at once. A node takes the children of its binary
 * node and opens, as long as there is room, the one with the largest surface, which rays are the likeliest to enter
 * (Wald, Benthin and Boulos, "Getting Rid of Packets", 2008). So a node with fewer than eight children has instances
 * alone. The boxes are those of the binary nodes, bit for bit.
 *
 * Launch: one work-item, which writes the nodes in the order of their levels: those that wait are its list. Reads the
 * hierarchy; writes the wide one. No atomics, no local memory.
 */
#include "shared/scene_layout.h"

/* The children of a wide node, while it is made. */
typedef struct svo_scene_group {
    uint count;
    uint child[SVO_SCENE_WIDTH]; /* as svo_scene_node.child */
    uint box[SVO_SCENE_WIDTH]; /* in all boxes of the hierarchy */
    float surface[SVO_SCENE_WIDTH]; /* below 0: an instance, which cannot be opened */
} svo_scene_group;

/* Puts a child of a binary node in a place of the group. */
static void svo_scene_put(__global const svo_scene_node *nodes, uint node, uint side, uint place,
                          svo_scene_group *group)
{
    __global const float *box = nodes[node].box + SVO_SCENE_BOUNDS * side;
    const float3 size = vload3(1, box) - vload3(0, box);
    const uint child = nodes[node].child[side];
    const float surface = size.x * size.y + size.y * size.z + size.z * size.x;
    group->child[place] = child;
    group->box[place] = 2u * node + side;
    group->surface[place] = (child & SVO_SCENE_LEAF) != 0u ? -1.0f : surface;
}

/* The largest of the group that can be opened; group->count: none. */
static uint svo_scene_largest_of(const svo_scene_group *group)
{
    uint largest = group->count;
    float surface = -1.0f;
    for (uint k = 0u; k < group->count; ++k) {
        if (group->surface[k] > surface) {
            surface = group->surface[k];
            largest = k;
        }
    }
    return largest;
}

static void svo_scene_gather(__global const svo_scene_node *nodes, uint node, svo_scene_group *group)
{
    group->count = 2u;
    svo_scene_put(nodes, node, 0u, 0u, group);
    svo_scene_put(nodes, node, 1u, 1u, group);
    while (group->count < SVO_SCENE_WIDTH) {
        const uint open = svo_scene_largest_of(group);
        if (open == group->count) {
            return;
        }
        const uint opened = group->child[open];
        svo_scene_put(nodes, opened, 0u, open, group);
        svo_scene_put(nodes, opened, 1u, group->count, group);
        ++group->count;
    }
}

/* Writes a node, and the list's next entries. Returns how many nodes there are then. */
static uint svo_scene_write(__global const svo_scene_node *nodes, const svo_scene_group *group,
                            __global svo_scene_wide *wide, uint at, uint count)
{
    for (uint k = 0u; k < SVO_SCENE_WIDTH; ++k) {
        const bool is_there = k < group->count;
        const uint box = is_there ? group->box[k] : 0u;
        for (uint axis = 0u; axis < 3u; ++axis) {
            __global const float *bounds = nodes[box >> 1].box + SVO_SCENE_BOUNDS * (box & 1u) + axis;
            wide[at].low[SVO_SCENE_WIDTH * axis + k] = is_there ? bounds[0] : FLT_MAX;
            wide[at].high[SVO_SCENE_WIDTH * axis + k] = is_there ? bounds[3] : -FLT_MAX;
        }
        const uint child = is_there ? group->child[k] : SVO_NO_NODE;
        const bool waits = (child & SVO_SCENE_LEAF) == 0u;
        wide[at].child[k] = waits ? count : child;
        if (waits) {
            wide[count++].child[0] = child;
        }
    }
    return count;
}

__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void svo_k_scene_widen(__global const svo_scene_node *nodes,
                                                                               __global svo_scene_wide *wide)
{
    uint count = 1u;
    wide[0].child[0] = 0u;
    for (uint at = 0u; at < count; ++at) {
        svo_scene_group group;
        svo_scene_gather(nodes, wide[at].child[0], &group);
        count = svo_scene_write(nodes, &group, wide, at, count);
    }
}
