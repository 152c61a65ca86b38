/* SPDX-License-Identifier: MIT */
/* A tree to voxels: the leaves with their places. They lie in Morton order from the grid's least corner on, which is
   the list's order too where they begin at that corner. */
#include <math.h>
#include <string.h>

#include "core/memory.h"
#include "core/tree.h"
#include "svocl/nodes.h"
#include "voxels/voxels.h"

static const char function[] = "svo_tree_get_voxels";

/* The payload of leaf k is at index of_leaves + k. */
static void fill_leaf(const svo_tree *tree, uint64_t leaf, const uint32_t cell[3], const int32_t offset[3],
                      svo_voxel *voxel)
{
    const uint64_t payload = tree->info.inner_count - tree->info.level_begin[tree->info.payload_level] + leaf;
    const uint8_t *colors = tree->host[SVO_TREE_COLORS];
    const uint16_t *materials = tree->host[SVO_TREE_MATERIALS];
    *voxel = (svo_voxel){.x = offset[0] + (int32_t)cell[0],
                         .y = offset[1] + (int32_t)cell[1],
                         .z = offset[2] + (int32_t)cell[2],
                         .rgba = {255, 255, 255, 255},
                         .material = materials != NULL ? materials[payload] : 0};
    if (colors != NULL) {
        memcpy(voxel->rgba, colors + 4 * payload, 4);
    }
}

/* Goes through the tree in depth-first order, which meets the leaves one after the other. */
static void fill_leaves(const svo_tree *tree, const int32_t offset[3], svo_voxel *voxels)
{
    const uint8_t *masks = tree->host[SVO_TREE_CHILD_MASK];
    const uint32_t *first_child = tree->host[SVO_TREE_FIRST_CHILD];
    const uint32_t depth = tree->info.depth;
    uint32_t nodes[SVO_LEVELS_MAX] = {0}; /* on the way from the root, and the children left to visit */
    uint32_t left[SVO_LEVELS_MAX] = {0};
    uint32_t cell[3] = {0, 0, 0};
    uint64_t leaf = 0;
    uint32_t level = 0;
    left[0] = masks[0];
    for (;;) {
        while (level > 0 && left[level] == 0) {
            --level;
        }
        if (left[level] == 0) {
            return;
        }
        const uint32_t octant = (uint32_t)__builtin_ctz(left[level]);
        left[level] &= left[level] - 1;
        const uint32_t shift = depth - level - 1;
        for (unsigned axis = 0; axis < 3; ++axis) {
            cell[axis] = (cell[axis] >> (shift + 1) << 1 | (octant >> axis & 1u)) << shift;
        }
        if (level + 1 == depth) {
            fill_leaf(tree, leaf, cell, offset, &voxels[leaf]);
            ++leaf;
            continue;
        }
        const uint32_t before = masks[nodes[level]] & ((1u << octant) - 1u);
        nodes[level + 1] = first_child[nodes[level]] + (uint32_t)__builtin_popcount(before);
        left[level + 1] = masks[nodes[level + 1]];
        ++level;
    }
}

/* Whether the grid's voxels are those of the world: one unit wide, from whole numbers on. */
static bool is_unit_grid(const svo_tree_info *info)
{
    bool whole =
        info->edge == ldexp(1.0, (int)info->depth) && info->scale == ldexp(1.0, (int)(info->snap_bits - info->depth));
    for (int axis = 0; axis < 3; ++axis) {
        whole = whole && rint(info->origin[axis]) == info->origin[axis] && fabs(info->origin[axis]) < 1 << 29;
    }
    return whole;
}

/* The width of a leaf. On a grid of the caller's it follows from edge, without the rounding of scale. */
static double leaf_edge(const svo_tree_info *info)
{
    const double units = ldexp(1.0, (int)info->snap_bits);
    return info->scale == units / info->edge ? ldexp(info->edge, -(int)info->depth)
                                             : ldexp(1.0, (int)(info->snap_bits - info->depth)) / info->scale;
}

svo_status svo_tree_get_voxels(const svo_tree *tree, svo_voxels **out, svo_message *message)
{
    if (tree == NULL || out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function, tree == NULL ? "tree" : "out");
    }
    const char *undefined = svo_i_tree_undefined(tree);
    if (undefined != NULL || !tree->downloaded) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s", function,
                          undefined != NULL ? undefined : "the tree has no host arrays; call svo_tree_download first");
    }
    const svo_tree_info *info = &tree->info;
    if (info->leaf_count > SVO_VOXELS_MAX) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: the tree has %llu leaves, above %u", function,
                          (unsigned long long)info->leaf_count, SVO_VOXELS_MAX);
    }
    /* Twice while the list is made. */
    const uint64_t needed_bytes = 2 * info->leaf_count * sizeof(svo_voxel);
    if (needed_bytes > svo_i_host_memory_bytes()) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: %llu voxels need %s, above the %s that are there",
                          function, (unsigned long long)info->leaf_count, svo_i_bytes(needed_bytes).text,
                          svo_i_bytes(svo_i_host_memory_bytes()).text);
    }
    const bool of_world = is_unit_grid(info);
    int32_t offset[3] = {0, 0, 0};
    svo_voxels_source source = {
        .struct_size = sizeof source, .voxel_count = info->leaf_count, .voxel_edge = of_world ? 1.0 : leaf_edge(info)};
    for (int axis = 0; axis < 3; ++axis) {
        offset[axis] = of_world ? (int32_t)info->origin[axis] : 0;
        source.origin[axis] = of_world ? 0.0 : info->origin[axis];
    }
    svo_voxel *voxels = svo_i_alloc_zeroed(&tree->memory, (size_t)info->leaf_count + 1, sizeof *voxels);
    if (voxels == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %llu voxels", function,
                          (unsigned long long)info->leaf_count);
    }
    fill_leaves(tree, offset, voxels);
    const svo_status status = svo_i_voxels_take(&tree->memory, &source, voxels, NULL, out, message);
    if (status != SVO_OK) {
        svo_i_message_rename(message, function);
    }
    return status;
}
