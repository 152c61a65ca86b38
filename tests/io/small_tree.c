/* SPDX-License-Identifier: MIT */
/* Trees made by hand, with every array and without a device, for tests of files. */
#include "small_tree.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <string.h>

#include "svocl/plan.h"

/* An array that a tree owns. */
static void *allocate_array(size_t bytes)
{
    void *memory = svo_i_alloc_zeroed(NULL, 1, bytes);
    assert_non_null(memory);
    return memory;
}

/* Fills the arrays parallel to nodes and leaves with values that differ per element. */
static void fill_payload(svo_tree *tree)
{
    svo_tree_info *info = &tree->info;
    uint8_t *colors = allocate_array(info->node_count * 4);
    int16_t *normals = allocate_array(info->node_count * 6);
    uint16_t *materials = allocate_array(info->node_count * 2);
    uint16_t *fills = allocate_array(info->node_count * 2);
    uint16_t *areas = allocate_array(info->leaf_count * 12);
    for (uint64_t i = 0; i < info->node_count; ++i) {
        memset(colors + 4 * i, (int)(i * 7 % 256), 4);
        normals[3 * i] = (int16_t)(i * 100);
        materials[i] = (uint16_t)(i * 11);
        fills[i] = (uint16_t)(i * 13 + 1);
    }
    for (uint64_t i = 0; i < info->leaf_count * 6; ++i) {
        areas[i] = (uint16_t)(i * 17 + 1);
    }
    tree->host[SVO_TREE_COLORS] = colors;
    tree->host[SVO_TREE_NORMALS] = normals;
    tree->host[SVO_TREE_MATERIALS] = materials;
    tree->host[SVO_TREE_FILLS] = fills;
    tree->host[SVO_TREE_AREAS] = areas;

    /* Leaf k meets triangle 0 and, if k is odd, triangle 1. */
    info->vertex_count = 4;
    info->list_triangle_count = 2;
    uint32_t *list_begin = allocate_array((info->leaf_count + 1) * sizeof *list_begin);
    uint32_t *list = allocate_array(2 * info->leaf_count * sizeof *list);
    uint32_t count = 0;
    for (uint32_t leaf = 0; leaf < info->leaf_count; ++leaf) {
        list[count++] = 0;
        if (leaf % 2 == 1) {
            list[count++] = 1;
        }
        list_begin[leaf + 1] = count;
    }
    info->list_count = count;
    info->fragments = count;
    tree->host[SVO_TREE_LIST_BEGIN] = list_begin;
    tree->host[SVO_TREE_LIST] = list;
    int32_t *vertices = allocate_array(12 * sizeof *vertices);
    uint32_t *indices = allocate_array(6 * sizeof *indices);
    uint32_t *triangle_ids = allocate_array(2 * sizeof *triangle_ids);
    memcpy(vertices, (const int32_t[]){0, 0, 0, 9, 0, 0, 0, 9, 0, 0, 0, -9}, 12 * sizeof *vertices);
    memcpy(indices, (const uint32_t[]){0, 1, 2, 1, 2, 3}, 6 * sizeof *indices);
    memcpy(triangle_ids, (const uint32_t[]){1, 4}, 2 * sizeof *triangle_ids);
    float *positions = allocate_array(12 * sizeof *positions);
    for (int i = 0; i < 12; ++i) {
        positions[i] = (float)vertices[i] / 3.0f;
    }
    info->positions = SVO_POSITIONS_FLOAT;
    tree->host[SVO_TREE_POSITIONS] = positions;
    tree->host[SVO_TREE_VERTICES] = vertices;
    tree->host[SVO_TREE_INDICES] = indices;
    tree->host[SVO_TREE_TRIANGLE_IDS] = triangle_ids;
}

/* Codes of the parents: unique and in order. Returns their count; masks[i] gets parent i's children. */
static size_t raise_level(const uint32_t *codes, size_t count, uint32_t *parents, uint8_t *masks)
{
    size_t parent_count = 0;
    for (size_t i = 0; i < count; ++i) {
        if (parent_count == 0 || parents[parent_count - 1] != codes[i] >> 3) {
            parents[parent_count] = codes[i] >> 3;
            masks[parent_count++] = 0;
        }
        masks[parent_count - 1] |= (uint8_t)(1u << (codes[i] & 7));
    }
    return parent_count;
}

svo_tree *small_tree_make(const uint32_t *codes, size_t count, uint32_t need)
{
    uint32_t levels[SMALL_TREE_DEPTH + 1][512];
    uint8_t masks[SMALL_TREE_DEPTH + 1][512] = {{0}};
    size_t counts[SMALL_TREE_DEPTH + 1] = {1, 0, 0, count};
    memcpy(levels[SMALL_TREE_DEPTH], codes, count * sizeof *codes);
    for (int level = SMALL_TREE_DEPTH; level > 0 && count > 0; --level) {
        counts[level - 1] = raise_level(levels[level], counts[level], levels[level - 1], masks[level - 1]);
    }
    svo_tree *tree = svo_i_tree_new(NULL);
    assert_non_null(tree);
    svo_tree_info *info = &tree->info;
    *info = (svo_tree_info){.depth = SMALL_TREE_DEPTH,
                            .snap_bits = 20,
                            .need = ((uint32_t)SVO_NEED_ALL),
                            .edge = 2,
                            .scale = 3,
                            .triangles = 9};
    for (int level = 0; level <= SMALL_TREE_DEPTH; ++level) {
        info->level_begin[level + 1] = info->level_begin[level] + (uint32_t)counts[level];
    }
    info->inner_count = info->level_begin[SMALL_TREE_DEPTH];
    info->node_count = info->level_begin[SMALL_TREE_DEPTH + 1];
    info->leaf_count = info->node_count - info->inner_count;
    uint8_t *child_mask = allocate_array(info->inner_count);
    uint32_t *first_child = allocate_array(info->inner_count * sizeof *first_child);
    uint32_t next_child = 1;
    size_t node = 0;
    for (int level = 0; level < SMALL_TREE_DEPTH; ++level) {
        for (size_t i = 0; i < counts[level]; ++i, ++node) {
            child_mask[node] = masks[level][i];
            first_child[node] = next_child;
            next_child += (uint32_t)__builtin_popcount(masks[level][i]);
        }
    }
    tree->host[SVO_TREE_CHILD_MASK] = child_mask;
    tree->host[SVO_TREE_FIRST_CHILD] = first_child;
    fill_payload(tree);
    info->need = need;
    info->positions = (need & SVO_NEED_RAYS) != 0 ? SVO_POSITIONS_FLOAT : SVO_POSITIONS_ROUNDED;
    for (int i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        if (!svo_i_tree_holds(info, (svo_tree_buffer)i)) {
            svo_i_free(tree->host[i]);
            tree->host[i] = NULL;
        }
    }
    if ((need & SVO_NEED_RAYS) == 0) {
        info->list_count = info->vertex_count = info->list_triangle_count = 0;
    }
    tree->downloaded = true;
    return tree;
}

svo_tree *small_tree(uint32_t need)
{
    return small_tree_make((const uint32_t[]){0, 1, 9, 200, 511}, 5, need);
}

void assert_same_tree(const svo_tree *a, const svo_tree *b)
{
    assert_memory_equal(&a->info, &b->info, sizeof a->info);
    for (int i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        const size_t bytes = svo_i_tree_holds(&a->info, (svo_tree_buffer)i)
                                 ? (size_t)svo_i_tree_element_count(&a->info, (svo_tree_buffer)i) *
                                       svo_i_tree_element_bytes((svo_tree_buffer)i)
                                 : 0;
        if (bytes == 0) {
            assert_null(b->host[i]);
        } else {
            assert_memory_equal(a->host[i], b->host[i], bytes);
        }
    }
    char hash_a[SVO_HASH_TEXT_BYTES], hash_b[SVO_HASH_TEXT_BYTES];
    assert_int_equal(svo_tree_hash(a, SVO_HASH_ALL, hash_a), SVO_OK);
    assert_int_equal(svo_tree_hash(b, SVO_HASH_ALL, hash_b), SVO_OK);
    assert_string_equal(hash_a, hash_b);
}
