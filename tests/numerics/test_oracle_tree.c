/* SPDX-License-Identifier: MIT */
/*
 * Tests the lists of tools/lab/reference: Morton codes, the sort, the comparison of two lists, and the canonical tree
 * of a list against one written by hand, against a walk from its root, and against the trees of other depths.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "oracle.h"
#include "support/suite.h"

static uint64_t next_random(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return *state >> 33;
}

static void codes_and_boxes_fit(void **state)
{
    oracle_box box;

    (void)state;
    assert_int_equal(oracle_voxel_code(1, 0, 0, 12), 1);
    assert_int_equal(oracle_voxel_code(0, 1, 0, 12), 2);
    assert_int_equal(oracle_voxel_code(0, 0, 1, 12), 4);
    assert_int_equal(oracle_voxel_code(5, 3, 6, 3), 0563); /* octal: one digit per level */
    assert_int_equal(oracle_voxel_code(4095, 4095, 4095, 12), (UINT64_C(1) << 36) - 1);
    oracle_voxel_box(oracle_voxel_code(5, 3, 6, 3), 3, 20, &box);
    assert_int_equal(box.width, 1 << 17);
    assert_int_equal(box.corner[0], 5 << 17);
    assert_int_equal(box.corner[1], 3 << 17);
    assert_int_equal(box.corner[2], 6 << 17);
}

static int pair_order(const void *a, const void *b)
{
    const oracle_pair *p = a, *q = b;

    if (p->code != q->code)
        return p->code < q->code ? -1 : 1;
    return (p->triangle > q->triangle) - (p->triangle < q->triangle);
}

static void sort_orders_by_code_then_triangle(void **state)
{
    enum { COUNT = 20000 };
    oracle_pair *pairs = malloc(COUNT * sizeof(*pairs)), *expected = malloc(COUNT * sizeof(*pairs));
    uint64_t seed = 5;

    (void)state;
    assert_true(pairs && expected);
    for (unsigned bits = 1; bits <= 31; bits += 5) {
        for (size_t i = 0; i < COUNT; i++)
            pairs[i] =
                (oracle_pair){next_random(&seed) >> (31 - bits) << bits, (uint32_t)next_random(&seed) >> (31 - bits)};
        memcpy(expected, pairs, COUNT * sizeof(*pairs));
        qsort(expected, COUNT, sizeof(*expected), pair_order);
        assert_true(oracle_pairs_sort(pairs, COUNT));
        for (size_t i = 0; i < COUNT; i++)
            assert_int_equal(pair_order(&pairs[i], &expected[i]), 0);
    }
    assert_true(oracle_pairs_sort(pairs, 1));
    assert_true(oracle_pairs_sort(NULL, 0));
    free(pairs);
    free(expected);
}

static void comparison_counts_voxels_and_pairs(void **state)
{
    oracle_pair expected_pairs[] = {{1, 0}, {1, 4}, {2, 0}, {5, 1}, {5, 2}, {9, 0}};
    oracle_pair actual_pairs[] = {{1, 0}, {1, 5}, {3, 0}, {5, 1}, {5, 1}, {5, 2}, {10, 0}, {10, 1}};
    const oracle_pairs expected = {expected_pairs, 6}, actual = {actual_pairs, 8}, none = {NULL, 0};
    oracle_difference difference;

    (void)state;
    oracle_compare(&expected, &actual, &difference);
    assert_int_equal(difference.missed_pairs, 3); /* (1, 4), (2, 0), (9, 0) */
    assert_int_equal(difference.surplus_pairs, 5); /* (1, 5), (3, 0), (5, 1) again, (10, 0), (10, 1) */
    assert_int_equal(difference.missed_voxels, 2); /* 2, 9 */
    assert_int_equal(difference.surplus_voxels, 2); /* 3, 10 */
    oracle_compare(&expected, &none, &difference);
    assert_int_equal(difference.missed_pairs, 6);
    assert_int_equal(difference.missed_voxels, 4);
    assert_int_equal(difference.surplus_pairs + difference.surplus_voxels, 0);
    oracle_compare(&none, &actual, &difference);
    assert_int_equal(difference.surplus_pairs, 8);
    assert_int_equal(difference.surplus_voxels, 4);
    assert_int_equal(difference.missed_pairs + difference.missed_voxels, 0);
    oracle_compare(&actual, &actual, &difference);
    assert_int_equal(difference.missed_pairs + difference.surplus_pairs, 0);
    assert_int_equal(difference.missed_voxels + difference.surplus_voxels, 0);
}

/* Depth 2: octant 0 holds leaves 0 and 7, octant 5 holds leaf 3 (of two triangles), octant 6 holds leaves 1, 2 and
   4. */
static void tree_equals_the_one_written_by_hand(void **state)
{
    oracle_pair list[] = {{000, 1}, {007, 0}, {053, 0}, {053, 2}, {061, 0}, {062, 0}, {064, 3}};
    const oracle_pairs pairs = {list, 7};
    const uint32_t level_begin[ORACLE_LEVELS_MAX] = {0, 1, 4, 10};
    const uint8_t masks[] = {0x61, 0x81, 0x08, 0x16};
    const uint32_t first[] = {1, 4, 6, 7};
    oracle_tree tree;

    (void)state;
    assert_true(oracle_tree_make(&pairs, 2, &tree));
    assert_int_equal(tree.node_count, 10);
    assert_int_equal(tree.inner_count, 4);
    assert_memory_equal(tree.level_begin, level_begin, sizeof(level_begin));
    assert_memory_equal(tree.child_mask, masks, sizeof(masks));
    assert_memory_equal(tree.first_child, first, sizeof(first));
    oracle_tree_free(&tree);
}

static void empty_tree_is_a_root_without_children(void **state)
{
    const oracle_pairs none = {NULL, 0};
    oracle_tree tree;

    (void)state;
    for (unsigned depth = 1; depth <= 12; depth++) {
        assert_true(oracle_tree_make(&none, depth, &tree));
        assert_int_equal(tree.node_count, 1);
        assert_int_equal(tree.inner_count, 1);
        assert_int_equal(tree.child_mask[0], 0);
        assert_int_equal(tree.level_begin[0], 0);
        for (unsigned level = 1; level <= depth + 1; level++)
            assert_int_equal(tree.level_begin[level], 1);
        assert_true(oracle_leaf_codes(tree.child_mask, tree.inner_count, depth, 0, NULL));
        oracle_tree_free(&tree);
    }
}

static oracle_pairs statue_like_pairs(unsigned depth)
{
    static const int32_t vertices[] = {1000,   2000,    3000,    1048575, 90000,  70000,
                                       500000, 1000000, 1048575, 0,       524288, 524288};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3, 3, 3, 1};
    const oracle_mesh mesh = {vertices, indices, NULL, 3};
    const oracle_request request = {depth, 20, ORACLE_HALF_OPEN, ORACLE_SAT};
    oracle_pairs pairs;

    assert_true(oracle_enumerate(&mesh, &request, &pairs));
    assert_in_range(pairs.count, 1, SIZE_MAX);
    return pairs;
}

/* Descends from the root by mask and first child, as a user of the tree does; false if there is no such leaf. */
static bool find_leaf(const oracle_tree *tree, uint64_t code, uint32_t *leaf)
{
    uint32_t node = 0;

    for (unsigned level = 0; level < tree->depth; level++) {
        unsigned octant = code >> 3 * (tree->depth - 1 - level) & 7;
        unsigned mask = tree->child_mask[node];

        if (!(mask >> octant & 1))
            return false;
        node = tree->first_child[node];
        for (unsigned o = 0; o < octant; o++)
            node += mask >> o & 1;
    }
    *leaf = node;
    return true;
}

static void tree_has_exactly_the_leaves_of_the_list(void **state)
{
    (void)state;
    for (unsigned depth = 1; depth <= 6; depth++) {
        oracle_pairs pairs = statue_like_pairs(depth);
        oracle_tree tree;
        size_t i = 0;
        uint32_t expected_leaf;

        assert_true(oracle_tree_make(&pairs, depth, &tree));
        assert_int_equal(tree.node_count - tree.inner_count, oracle_pairs_voxel_count(&pairs));
        expected_leaf = tree.level_begin[depth];
        for (uint64_t code = 0; code < UINT64_C(1) << 3 * depth; code++) {
            bool is_listed = i < pairs.count && pairs.pairs[i].code == code;
            uint32_t leaf = 0;

            assert_int_equal(find_leaf(&tree, code, &leaf), is_listed);
            if (is_listed)
                assert_int_equal(leaf, expected_leaf++);
            while (i < pairs.count && pairs.pairs[i].code == code)
                i++;
        }
        oracle_tree_free(&tree);
        oracle_pairs_free(&pairs);
    }
}

/* Nodes of the tree of a smaller depth are the upper levels of a deeper one. */
static void trees_nest(void **state)
{
    oracle_pairs deep_pairs = statue_like_pairs(9);
    oracle_tree deep;

    (void)state;
    assert_true(oracle_tree_make(&deep_pairs, 9, &deep));
    for (unsigned depth = 1; depth < 9; depth++) {
        oracle_pairs pairs = statue_like_pairs(depth);
        oracle_tree tree;

        assert_true(oracle_tree_make(&pairs, depth, &tree));
        assert_memory_equal(tree.level_begin, deep.level_begin, (depth + 2) * sizeof(uint32_t));
        assert_memory_equal(tree.child_mask, deep.child_mask, tree.inner_count);
        assert_memory_equal(tree.first_child, deep.first_child, tree.inner_count * sizeof(uint32_t));
        oracle_tree_free(&tree);
        oracle_pairs_free(&pairs);
    }
    oracle_tree_free(&deep);
    oracle_pairs_free(&deep_pairs);
}

static void leaf_codes_are_recovered_from_the_masks(void **state)
{
    oracle_pairs pairs = statue_like_pairs(8);
    uint64_t leaf_count = oracle_pairs_voxel_count(&pairs), leaf = 0;
    uint64_t *codes = malloc(leaf_count * sizeof(*codes));
    oracle_tree tree;

    (void)state;
    assert_non_null(codes);
    assert_true(oracle_tree_make(&pairs, 8, &tree));
    assert_true(oracle_leaf_codes(tree.child_mask, tree.inner_count, 8, leaf_count, codes));
    for (size_t i = 0; i < pairs.count; i++)
        if (i == 0 || pairs.pairs[i].code != pairs.pairs[i - 1].code)
            assert_int_equal(codes[leaf++], pairs.pairs[i].code);
    assert_int_equal(leaf, leaf_count);

    assert_false(oracle_leaf_codes(tree.child_mask, tree.inner_count - 1, 8, leaf_count, codes));
    assert_false(oracle_leaf_codes(tree.child_mask, tree.inner_count, 8, leaf_count - 1, codes));
    assert_false(oracle_leaf_codes(tree.child_mask, tree.inner_count, 7, leaf_count, codes));
    assert_false(oracle_leaf_codes(tree.child_mask, tree.inner_count, 8, 0, codes));
    tree.child_mask[tree.inner_count - 1] = 0;
    assert_false(oracle_leaf_codes(tree.child_mask, tree.inner_count, 8, leaf_count, codes));
    oracle_tree_free(&tree);
    oracle_pairs_free(&pairs);
    free(codes);
}

static void requests_out_of_range_are_refused(void **state)
{
    static const int32_t vertices[9];
    const oracle_mesh mesh = {vertices, NULL, NULL, 1};
    const oracle_request requests[] = {{17, 24, ORACLE_HALF_OPEN, ORACLE_SAT},
                                       {12, 11, ORACLE_HALF_OPEN, ORACLE_SAT},
                                       {12, 25, ORACLE_HALF_OPEN, ORACLE_SAT}};
    oracle_pairs pairs;

    (void)state;
    for (size_t i = 0; i < 3; i++) {
        assert_false(oracle_enumerate(&mesh, &requests[i], &pairs));
        assert_null(pairs.pairs);
        assert_int_equal(pairs.count, 0);
    }
}

TEST_GROUP(oracle_tree)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(codes_and_boxes_fit),
        cmocka_unit_test(sort_orders_by_code_then_triangle),
        cmocka_unit_test(comparison_counts_voxels_and_pairs),
        cmocka_unit_test(tree_equals_the_one_written_by_hand),
        cmocka_unit_test(empty_tree_is_a_root_without_children),
        cmocka_unit_test(tree_has_exactly_the_leaves_of_the_list),
        cmocka_unit_test(trees_nest),
        cmocka_unit_test(leaf_codes_are_recovered_from_the_masks),
        cmocka_unit_test(requests_out_of_range_are_refused),
    };

    return cmocka_run_group_tests_name("oracle_tree", tests, NULL, NULL);
}
