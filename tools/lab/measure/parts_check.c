/* SPDX-License-Identifier: MIT */
/* Regions of a folder, chosen and compared. */
#include "measure/parts_check.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "measure/tree_check.h"

#define REGION_LEVELS 7u

typedef struct checker {
    const svo_parts *parts;
    svo_parts_tree *tree;
    const svo_mesh *mesh;
    svo_message *message;
    svo_tree_info info; /* of the whole tree */
    uint32_t level; /* of the regions */
    uint64_t random;
} checker;

static svo_status no_memory(const checker *c)
{
    (void)snprintf(c->message->text, sizeof c->message->text, "no memory to compare regions");
    return SVO_OUT_OF_HOST_MEMORY;
}

/* SplitMix64 (Steele et al., "Fast Splittable Pseudorandom Number Generators", 2014). */
static uint64_t below(checker *c, uint64_t count)
{
    uint64_t x = c->random += UINT64_C(0x9e3779b97f4a7c15);
    x = (x ^ x >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ x >> 27) * UINT64_C(0x94d049bb133111eb);
    return (x ^ x >> 31) % count;
}

/* ---- the choice of regions ---- */

/* The region of a vertex of a triangle. False: it is not in the grid. */
static bool choose_by_mesh(checker *c, uint64_t *code)
{
    const svo_mesh *mesh = c->mesh;
    if (mesh->triangle_count == 0) {
        return false;
    }
    const size_t corner = (size_t)below(c, 3 * (uint64_t)mesh->triangle_count);
    const size_t vertex = mesh->indices != NULL ? mesh->indices[corner] : corner;
    const double nodes = ldexp(1.0, (int)c->level);
    uint32_t cell[3] = {0};
    if (vertex >= mesh->vertex_count) {
        return false;
    }
    for (size_t axis = 0; axis < 3; ++axis) {
        const double x = mesh->positions_double != NULL ? mesh->positions_double[3 * vertex + axis]
                                                        : (double)mesh->positions[3 * vertex + axis];
        const double place = floor((x - c->info.origin[axis]) / c->info.edge * nodes);
        if (!(place >= 0.0 && place < nodes)) {
            return false;
        }
        cell[axis] = (uint32_t)place;
    }
    *code = oracle_voxel_code(cell[0], cell[1], cell[2], c->level);
    return true;
}

/* The codes of a region's leaves from its root, ascending; none where no node is. The caller frees them. */
static svo_status load_codes(const checker *c, const svo_parts_region *region, uint64_t **codes, uint64_t *count)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    svo_tree *tree = NULL;
    *codes = NULL;
    *count = 0;
    const svo_status status = svo_parts_tree_load(c->tree, region, &tree, c->message);
    if (status != SVO_OK) {
        return status == SVO_INVALID_ARGUMENT ? SVO_OK : status;
    }
    (void)svo_tree_get_info(tree, &info);
    (void)svo_tree_get_arrays(tree, &arrays);
    *count = info.leaf_count;
    *codes = malloc((size_t)info.leaf_count * sizeof **codes + 1);
    const bool good =
        *codes != NULL && oracle_leaf_codes(arrays.child_mask, info.inner_count, info.depth, info.leaf_count, *codes);
    svo_tree_destroy(&tree);
    return good ? SVO_OK : no_memory(c);
}

/* A region of a part: the one above it, or anywhere in it. */
static svo_status choose_by_parts(checker *c, uint64_t *code)
{
    svo_parts_entry part = SVO_PARTS_ENTRY_INIT;
    svo_parts_region region = SVO_PARTS_REGION_INIT;
    uint64_t *codes = NULL;
    uint64_t count = 0;
    *code = 0;
    if (svo_parts_count(c->parts) == 0) {
        return SVO_OK;
    }
    svo_status status = svo_parts_get(c->parts, (size_t)below(c, svo_parts_count(c->parts)), &part, c->message);
    if (status != SVO_OK || part.level >= c->level) {
        *code = status == SVO_OK ? part.code >> 3 * (part.level - c->level) : 0;
        return status;
    }
    region.level = part.level;
    region.code = part.code;
    region.last_level = c->level;
    status = load_codes(c, &region, &codes, &count);
    *code = part.code << 3 * (c->level - part.level) | (count > 0 ? codes[below(c, count)] : 0);
    free(codes);
    return status;
}

static svo_status choose(checker *c, size_t count, grid_node *nodes)
{
    for (size_t i = 0; i < count; ++i) {
        nodes[i].level = c->level;
        if (i % 2 == 0 || !choose_by_mesh(c, &nodes[i].code)) {
            const svo_status status = choose_by_parts(c, &nodes[i].code);
            if (status != SVO_OK) {
                return status;
            }
        }
    }
    return SVO_OK;
}

/* ---- the comparison ---- */

/* Adds what differs in a region. expected: sorted, a voxel as often as triangles touch it. codes: ascending, from the
   region's own root. */
static void compare(const grid_node *node, uint32_t depth, const oracle_pairs *expected, const uint64_t *codes,
                    uint64_t count, parts_differences *found)
{
    const uint64_t first = node->code << 3 * (depth - node->level);
    uint64_t built = 0;
    for (size_t i = 0; i < expected->count; ++i) {
        const uint64_t code = expected->pairs[i].code;
        if (i > 0 && code == expected->pairs[i - 1].code) {
            continue;
        }
        ++found->expected_voxels;
        for (; built < count && (first | codes[built]) < code; ++built) {
            ++found->surplus_voxels;
        }
        const bool is_there = built < count && (first | codes[built]) == code;
        found->missed_voxels += is_there ? 0 : 1;
        built += is_there ? 1 : 0;
    }
    found->surplus_voxels += count - built;
    found->built_voxels += count;
}

static svo_status check_region(const checker *c, const grid_node *node, const oracle_pairs *expected,
                               parts_differences *found)
{
    svo_parts_region region = SVO_PARTS_REGION_INIT;
    uint64_t *codes = NULL;
    uint64_t count = 0;
    region.level = node->level;
    region.code = node->code;
    const svo_status status = load_codes(c, &region, &codes, &count);
    if (status == SVO_OK) {
        compare(node, c->info.depth, expected, codes, count, found);
        ++found->regions;
    }
    free(codes);
    return status;
}

static svo_status check_regions(const checker *c, size_t count, const grid_node *nodes, const oracle_pairs *expected,
                                parts_differences *found)
{
    for (size_t i = 0; i < count; ++i) {
        const svo_status status = check_region(c, &nodes[i], &expected[i], found);
        if (status != SVO_OK) {
            return status;
        }
    }
    return SVO_OK;
}

static svo_status check_all(checker *c, size_t count, grid_node *nodes, oracle_pairs *expected,
                            parts_differences *found)
{
    svo_status status = choose(c, count, nodes);
    if (status != SVO_OK) {
        return status;
    }
    if (!mesh_list_pairs_below(c->mesh, &c->info, (oracle_coverage)c->info.coverage, nodes, count, expected)) {
        return no_memory(c);
    }
    status = check_regions(c, count, nodes, expected, found);
    for (size_t i = 0; i < count; ++i) {
        oracle_pairs_free(&expected[i]);
    }
    return status;
}

svo_status parts_check(const svo_parts *parts, svo_parts_tree *tree, const svo_mesh *mesh, size_t count, uint64_t seed,
                       parts_differences *found, svo_message *message)
{
    checker c = {.parts = parts, .tree = tree, .mesh = mesh, .message = message, .random = seed};
    svo_parts_tree_info info = SVO_PARTS_TREE_INFO_INIT;
    svo_status status = svo_parts_tree_get_info(tree, &info, message);
    grid_node *nodes = malloc(count * sizeof *nodes + 1);
    oracle_pairs *expected = malloc(count * sizeof *expected + 1);
    *found = (parts_differences){0};
    c.info = info.tree;
    c.level = info.tree.depth > REGION_LEVELS ? info.tree.depth - REGION_LEVELS : 0;
    if (status == SVO_OK) {
        status = nodes != NULL && expected != NULL ? check_all(&c, count, nodes, expected, found) : no_memory(&c);
    }
    free(nodes);
    free(expected);
    return status;
}
