/* SPDX-License-Identifier: MIT */
/* Codes of nodes from masks alone: nodes are breadth-first without gaps, so children follow in order. */
#include "light/cells.h"

#include "svocl/nodes.h"

/* The most masks that are read for the bounds of the leaves. */
#define BOUNDS_NODES_MAX (UINT32_C(1) << 18)

/* Replaces the codes of a level by those of the next one, in place: from the end, since a node's children come no
   earlier in theirs than it does in its own. */
static void descend(const uint8_t *masks, uint64_t parents, uint64_t *codes, uint64_t children)
{
    uint64_t to = children;
    for (uint64_t parent = parents; parent-- > 0;) {
        const uint64_t code = codes[parent];
        for (uint64_t octant = 8; octant-- > 0;) {
            if ((masks[parent] >> octant & 1) != 0) {
                codes[--to] = code << 3 | octant;
            }
        }
    }
}

svo_status svo_i_codes_of_level(svo_i_device_work *work, const svo_tree *tree, uint32_t level, uint64_t **codes)
{
    const uint32_t *begin = tree->info.level_begin;
    svo_status status = SVO_OK;
    uint8_t *masks = svo_i_alloc_zeroed(&tree->device->memory, (size_t)begin[level] + 1, 1);
    *codes = svo_i_alloc_zeroed(&tree->device->memory, (size_t)begin[level + 1] - begin[level] + 1, sizeof **codes);
    if (masks == NULL || *codes == NULL) {
        status = svo_i_device_fail(tree->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the cells of %u nodes",
                                   work->function, begin[level + 1]);
        goto cleanup;
    }
    SVO_I_TRY_CLEANUP(svo_i_work_read(work, tree->buffers[SVO_TREE_CHILD_MASK], 0, masks, begin[level]));
    for (uint32_t l = 0; l < level; ++l) {
        descend(masks + begin[l], begin[l + 1] - begin[l], *codes, begin[l + 2] - begin[l + 1]);
    }

cleanup:
    svo_i_free(masks);
    if (status != SVO_OK) {
        svo_i_free(*codes);
        *codes = NULL;
    }
    return status;
}

static void find_bounds(const uint64_t *codes, uint64_t count, uint32_t low[3], uint32_t high[3])
{
    low[0] = low[1] = low[2] = UINT32_MAX;
    high[0] = high[1] = high[2] = 0;
    for (uint64_t i = 0; i < count; ++i) {
        uint32_t cell[3];
        svo_code_to_cell(codes[i], cell);
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = cell[axis] < low[axis] ? cell[axis] : low[axis];
            high[axis] = cell[axis] > high[axis] ? cell[axis] : high[axis];
        }
    }
}

/* The deepest level whose cells follow from few enough masks. */
static uint32_t bounds_level(const svo_tree_info *info)
{
    uint32_t level = 0;
    while (level < info->depth && info->level_begin[level + 1] <= BOUNDS_NODES_MAX) {
        ++level;
    }
    return level;
}

svo_status svo_i_lit_box_of_tree(svo_i_device_work *work, const svo_tree *tree, svo_i_lit_box *box)
{
    const svo_tree_info *info = &tree->info;
    const uint32_t level = bounds_level(info);
    svo_grid grid = {.depth = 0};
    uint64_t *codes = NULL;
    uint32_t low[3];
    uint32_t high[3];
    double unused[3];
    SVO_I_TRY(svo_tree_get_grid(tree, &grid));
    SVO_I_TRY(svo_i_codes_of_level(work, tree, level, &codes));
    find_bounds(codes, info->level_begin[level + 1] - info->level_begin[level], low, high);
    svo_i_free(codes);
    svo_grid_cell_box(&grid, level, low, box->low, unused);
    svo_grid_cell_box(&grid, level, high, unused, box->high);
    box->leaf_edge = svo_grid_cell_edge(&grid, grid.depth);
    return SVO_OK;
}
