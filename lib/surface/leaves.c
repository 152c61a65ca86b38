/* SPDX-License-Identifier: MIT */
/*
 * The last step to a surface: each vertex gets color and normal of the leaf whose center is nearest; of several, of the
 * first in the order of leaves. The search goes down from the root, into the nearest child first, and leaves out what
 * is farther than the best leaf.
 */
#include "surface/leaves.h"

#include <math.h>

#include "core/tree.h"
#include "svocl/nodes.h"

/* Seven siblings on each level, and the way down. */
#define STACK_MAX (8 * SVO_LEVELS_MAX)

#define NORMAL_ONE 32767.0

typedef struct open_node {
    uint32_t index;
    uint32_t level;
    uint32_t cell[3];
    double squared; /* of the distance to its box; voxels */
} open_node;

typedef struct search {
    const uint8_t *masks;
    const uint32_t *first_child;
    uint32_t depth;
    double at[3]; /* voxels */
    uint32_t best; /* node */
    double best_squared; /* of the distance to its center */
    open_node stack[STACK_MAX];
    size_t count;
} search;

/* ---- checks ---- */

static bool holds(const svo_tree *tree, svo_tree_buffer buffer)
{
    return tree->info.payload_level <= tree->info.depth && tree->host[buffer] != NULL;
}

svo_status svo_i_surface_check_tree(const svo_surface_options *options, svo_message *message)
{
    static const char function[] = "svo_surface_create";
    const svo_tree *tree = options->tree;
    if ((options->parts & (SVO_SURFACE_COLORS | SVO_SURFACE_LEAF_NORMALS)) == 0) {
        return SVO_OK;
    }
    if (tree == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: options.tree is NULL; parts %u need one", function,
                          options->parts);
    }
    const char *undefined = svo_i_tree_undefined(tree);
    if (undefined != NULL || !tree->downloaded) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s", function,
                          undefined != NULL ? undefined : "the tree has no host arrays; call svo_tree_download first");
    }
    if (tree->info.leaf_count == 0) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: the tree has 0 leaves; parts %u need at least 1",
                          function, options->parts);
    }
    if ((options->parts & SVO_SURFACE_COLORS) != 0 && !holds(tree, SVO_TREE_COLORS)) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: the tree's leaves have no colors", function);
    }
    if ((options->parts & SVO_SURFACE_LEAF_NORMALS) != 0 && !holds(tree, SVO_TREE_NORMALS)) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: the tree's leaves have no normals", function);
    }
    return SVO_OK;
}

/* ---- the nearest leaf ---- */

/* To the box of a node, or to the center of a leaf. */
static double squared_distance(const search *s, uint32_t level, const uint32_t cell[3])
{
    const double width = (double)(UINT32_C(1) << (s->depth - level));
    double squared = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = (double)cell[axis] * width;
        const double away = level == s->depth ? s->at[axis] - (low + 0.5)
                                              : fmax(fmax(low - s->at[axis], s->at[axis] - (low + width)), 0.0);
        squared += away * away;
    }
    return squared;
}

static void take_leaf(search *s, const open_node *leaf)
{
    if (leaf->squared < s->best_squared || (leaf->squared == s->best_squared && leaf->index < s->best)) {
        s->best = leaf->index;
        s->best_squared = leaf->squared;
    }
}

/* Opens the children of a node: the farthest first, so that the nearest is taken next. */
static void open_children(search *s, const open_node *node)
{
    const size_t begin = s->count;
    uint32_t child = s->first_child[node->index];
    for (uint32_t octant = 0; octant < 8; ++octant) {
        if ((s->masks[node->index] >> octant & 1u) == 0) {
            continue;
        }
        open_node opened = {.index = child++, .level = node->level + 1};
        for (unsigned axis = 0; axis < 3; ++axis) {
            opened.cell[axis] = node->cell[axis] << 1 | (octant >> axis & 1u);
        }
        opened.squared = squared_distance(s, opened.level, opened.cell);
        size_t place = s->count++;
        for (; place > begin && s->stack[place - 1].squared < opened.squared; --place) {
            s->stack[place] = s->stack[place - 1];
        }
        s->stack[place] = opened;
    }
}

static uint32_t find_nearest(search *s)
{
    s->best = UINT32_MAX;
    s->best_squared = INFINITY;
    s->count = 1;
    s->stack[0] = (open_node){.index = 0};
    while (s->count > 0) {
        const open_node node = s->stack[--s->count];
        if (node.level == s->depth) {
            take_leaf(s, &node);
        } else if (node.squared <= s->best_squared) {
            open_children(s, &node);
        }
    }
    return s->best;
}

/* ---- what is taken ---- */

static svo_status make_arrays(svo_i_surface_work *work, uint32_t parts)
{
    svo_surface *surface = work->surface;
    if ((parts & SVO_SURFACE_COLORS) != 0) {
        surface->colors = svo_i_alloc_zeroed(&surface->memory, work->vertex_count, 4);
    }
    if ((parts & SVO_SURFACE_LEAF_NORMALS) != 0) {
        surface->normals = svo_i_alloc_zeroed(&surface->memory, work->vertex_count, 3 * sizeof *surface->normals);
    }
    const bool is_made = ((parts & SVO_SURFACE_COLORS) == 0 || surface->colors != NULL) &&
                         ((parts & SVO_SURFACE_LEAF_NORMALS) == 0 || surface->normals != NULL);
    return is_made ? SVO_OK
                   : svo_i_fail(work->message, SVO_OUT_OF_HOST_MEMORY, "svo_surface_create: no memory for %zu vertices",
                                work->vertex_count);
}

static void take_payload(const svo_surface_options *options, size_t payload, size_t vertex, svo_surface *surface)
{
    const uint8_t *colors = options->tree->host[SVO_TREE_COLORS];
    const int16_t *normals = options->tree->host[SVO_TREE_NORMALS];
    if ((options->parts & SVO_SURFACE_COLORS) != 0) {
        for (size_t i = 0; i < 4; ++i) {
            surface->colors[4 * vertex + i] = colors[4 * payload + i];
        }
    }
    if ((options->parts & SVO_SURFACE_LEAF_NORMALS) != 0) {
        for (size_t axis = 0; axis < 3; ++axis) {
            surface->normals[3 * vertex + axis] = (float)((double)normals[3 * payload + axis] / NORMAL_ONE);
        }
    }
}

svo_status svo_i_surface_take_leaves(svo_i_surface_work *work, const svo_surface_options *options)
{
    const svo_tree *tree = options->tree;
    svo_grid grid;
    search s;
    if ((options->parts & (SVO_SURFACE_COLORS | SVO_SURFACE_LEAF_NORMALS)) == 0 || work->vertex_count == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(make_arrays(work, options->parts));
    SVO_I_TRY(svo_tree_get_grid(tree, &grid));
    s.masks = tree->host[SVO_TREE_CHILD_MASK];
    s.first_child = tree->host[SVO_TREE_FIRST_CHILD];
    s.depth = grid.depth;
    const double per_voxel = ldexp(grid.edge, -(int)grid.depth);
    const size_t first = tree->info.level_begin[tree->info.payload_level];
    for (size_t vertex = 0; vertex < work->vertex_count; ++vertex) {
        for (size_t axis = 0; axis < 3; ++axis) {
            s.at[axis] = ((double)work->surface->positions[3 * vertex + axis] - grid.origin[axis]) / per_voxel;
        }
        take_payload(options, find_nearest(&s) - first, vertex, work->surface);
    }
    return SVO_OK;
}
