/* SPDX-License-Identifier: MIT */
/*
 * The octree of a sorted list of voxels, in canonical order, so that tests can compare the arrays of the library
 * element by element; and the inverse, from masks to voxels.
 */
#include "oracle.h"

#include <stdlib.h>

/* Nodes of a level are the distinct prefixes of the leaves' codes. */
static uint64_t count_prefixes(const oracle_pairs *pairs, unsigned shift)
{
    uint64_t count = 0;

    for (size_t i = 0; i < pairs->count; i++)
        count += i == 0 || pairs->pairs[i].code >> shift != pairs->pairs[i - 1].code >> shift;
    return count;
}

/* Sets level_begin and the counts; false if they do not fit. */
static bool count_levels(const oracle_pairs *pairs, unsigned depth, oracle_tree *tree)
{
    uint64_t total = 0;

    tree->depth = depth;
    for (unsigned level = 0; level <= depth; level++) {
        uint64_t count = level == 0 ? 1 : count_prefixes(pairs, 3 * (depth - level));

        tree->level_begin[level] = (uint32_t)total;
        total += count;
        if (total > UINT32_MAX)
            return false;
    }
    tree->level_begin[depth + 1] = (uint32_t)total;
    tree->node_count = (uint32_t)total;
    tree->inner_count = tree->level_begin[depth];
    return true;
}

/* The masks of the nodes whose children are the distinct prefixes after `shift` bits. */
static void fill_masks(const oracle_pairs *pairs, unsigned shift, uint8_t *masks)
{
    size_t node = 0;

    for (size_t i = 0; i < pairs->count; i++) {
        uint64_t child = pairs->pairs[i].code >> shift;

        if (i > 0 && child >> 3 != pairs->pairs[i - 1].code >> shift >> 3)
            node++;
        masks[node] = (uint8_t)(masks[node] | 1u << (child & 7));
    }
}

static uint32_t count_bits(uint8_t mask)
{
    uint32_t count = 0;

    for (; mask; mask = (uint8_t)(mask & (mask - 1)))
        count++;
    return count;
}

bool oracle_tree_make(const oracle_pairs *pairs, unsigned depth, oracle_tree *out)
{
    oracle_tree tree = {0};

    *out = tree;
    if (depth > ORACLE_DEPTH_MAX || !count_levels(pairs, depth, &tree))
        return false;
    /* One more, so that a tree of a single leaf (depth 0) has arrays too. */
    tree.child_mask = calloc((size_t)tree.inner_count + 1, sizeof(*tree.child_mask));
    tree.first_child = calloc((size_t)tree.inner_count + 1, sizeof(*tree.first_child));
    if (!tree.child_mask || !tree.first_child) {
        oracle_tree_free(&tree);
        return false;
    }
    for (unsigned level = 0; level < depth; level++)
        fill_masks(pairs, 3 * (depth - 1 - level), tree.child_mask + tree.level_begin[level]);
    /* Breadth-first: the children of all nodes follow one another, from node 1 on. */
    for (uint32_t node = 0, next = 1; node < tree.inner_count; node++) {
        tree.first_child[node] = next;
        next += count_bits(tree.child_mask[node]);
    }
    *out = tree;
    return true;
}

void oracle_tree_free(oracle_tree *tree)
{
    free(tree->child_mask);
    free(tree->first_child);
    *tree = (oracle_tree){0};
}

/* Replaces the node_count codes by those of their child_count children, in place: no node is without children, so
   from the end on no code is overwritten before it was read. */
static void expand_codes(const uint8_t *masks, uint64_t node_count, uint64_t child_count, uint64_t *codes)
{
    for (uint64_t node = node_count; node-- > 0;) {
        uint64_t code = codes[node];

        for (unsigned octant = 8; octant-- > 0;)
            if (masks[node] >> octant & 1)
                codes[--child_count] = code << 3 | octant;
    }
}

bool oracle_leaf_codes(const uint8_t *child_mask, uint64_t inner_count, unsigned depth, uint64_t leaf_count,
                       uint64_t *codes)
{
    uint64_t node = 0, level_count = 1;

    if (leaf_count == 0) {
        for (; node < inner_count; node++)
            if (child_mask[node] != 0)
                return false;
        return inner_count == 1;
    }
    codes[0] = 0;
    for (unsigned level = 0; level < depth; level++) {
        uint64_t child_count = 0;

        if (level_count > inner_count - node)
            return false;
        for (uint64_t i = 0; i < level_count; i++) {
            if (child_mask[node + i] == 0)
                return false;
            child_count += count_bits(child_mask[node + i]);
        }
        if (child_count > leaf_count)
            return false;
        expand_codes(child_mask + node, level_count, child_count, codes);
        node += level_count;
        level_count = child_count;
    }
    return node == inner_count && level_count == leaf_count;
}
