/* SPDX-License-Identifier: MIT */
/* Builds the tree of the exact reference and compares it with a built one, for verify and stress. */
#include "support/tree_check.h"

#include <stdlib.h>

bool tree_check_list_pairs(const svo_tree_info *info, const svo_tree_arrays *arrays, oracle_pairs *out,
                           uint64_t *empty_leaf_count)
{
    uint64_t *codes = malloc((size_t)info->leaf_count * sizeof *codes + 1);
    out->pairs = malloc((size_t)info->list_count * sizeof *out->pairs + 1);
    out->count = 0;
    *empty_leaf_count = 0;
    bool good = codes != NULL && out->pairs != NULL;
    good = good && oracle_leaf_codes(arrays->child_mask, info->inner_count, info->depth, info->leaf_count, codes);
    for (uint64_t leaf = 0; good && leaf < info->leaf_count; ++leaf) {
        const uint32_t begin = arrays->list_begin[leaf];
        const uint32_t end = arrays->list_begin[leaf + 1];
        good = begin <= end && end <= info->list_count && out->count + (end - begin) <= info->list_count;
        *empty_leaf_count += begin == end;
        for (uint32_t i = begin; good && i < end; ++i) {
            good = arrays->list[i] < info->list_triangle_count;
            if (good) {
                out->pairs[out->count++] = (oracle_pair){codes[leaf], arrays->triangle_ids[arrays->list[i]]};
            }
        }
    }
    free(codes);
    good = good && oracle_pairs_sort(out->pairs, out->count);
    if (!good) {
        oracle_pairs_free(out);
    }
    return good;
}

static bool count_node_differences(const oracle_pairs *expected, const svo_tree_info *info,
                                   const svo_tree_arrays *arrays, uint64_t *count)
{
    oracle_tree tree;
    if (!oracle_tree_make(expected, info->depth, &tree)) {
        return false;
    }
    *count = 0;
    for (unsigned level = 0; level <= info->depth + 1; ++level) {
        *count += tree.level_begin[level] != info->level_begin[level];
    }
    for (uint64_t i = 0; i < tree.inner_count && i < info->inner_count; ++i) {
        *count += tree.child_mask[i] != arrays->child_mask[i] || tree.first_child[i] != arrays->first_child[i];
    }
    oracle_tree_free(&tree);
    return true;
}

bool tree_check(const svo_tree_info *info, const svo_tree_arrays *arrays, tree_differences *found)
{
    const oracle_mesh mesh = {arrays->vertices, arrays->indices, arrays->triangle_ids,
                              (size_t)info->list_triangle_count};
    const oracle_request request = {info->depth, info->snap_bits, (oracle_coverage)info->coverage, ORACLE_SAT};
    *found = (tree_differences){0};
    oracle_pairs expected = {0};
    oracle_pairs actual = {0};
    uint64_t empty_leaf_count = 0;
    bool good = oracle_enumerate(&mesh, &request, &expected) &&
                tree_check_list_pairs(info, arrays, &actual, &empty_leaf_count) &&
                count_node_differences(&expected, info, arrays, &found->node_differences);
    if (good) {
        oracle_compare(&expected, &actual, &found->difference);
        found->difference.surplus_voxels += empty_leaf_count;
        found->expected_voxels = oracle_pairs_voxel_count(&expected);
        found->expected_pairs = expected.count;
        found->built_voxels = info->leaf_count;
        found->built_pairs = actual.count;
    }
    oracle_pairs_free(&expected);
    oracle_pairs_free(&actual);
    return good;
}

bool tree_check_is_exact(const tree_differences *found)
{
    const oracle_difference *d = &found->difference;
    return d->missed_voxels == 0 && d->surplus_voxels == 0 && d->missed_pairs == 0 && d->surplus_pairs == 0 &&
           found->node_differences == 0;
}
