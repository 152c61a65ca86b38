/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: arbitrary bytes as a .svo file. Either they are refused with a one-line message, or the tree is well
 * formed: array lengths match the header, the masks form a tree, every list entry and index is in range.
 */
#include <string.h>

#include "fuzz.h"
#include "oracle.h"
#include "svocl/io.h"
#include "svocl/plan.h"

#define NAME "input"

static void check_refusal(svo_status status, const svo_tree *tree, const svo_message *message)
{
    REQUIRE(status == SVO_FILE_DAMAGED || status == SVO_OUT_OF_HOST_MEMORY);
    REQUIRE(tree == NULL);
    REQUIRE(strncmp(message->text, NAME ": ", strlen(NAME ": ")) == 0);
    REQUIRE(strchr(message->text, '\n') == NULL);
}

/* Reads an array to its end, so that a sanitizer detects one that is too short. */
static void read_array(const void *array, uint64_t byte_count)
{
    static volatile uint8_t sink;
    const uint8_t *bytes = array;
    REQUIRE(bytes != NULL || byte_count == 0);
    for (uint64_t i = 0; i < byte_count; ++i) {
        sink = (uint8_t)(sink ^ bytes[i]);
    }
}

static void read_arrays(const svo_tree_info *info, const svo_tree_arrays *arrays)
{
    read_array(arrays->child_mask, info->inner_count);
    read_array(arrays->first_child, info->inner_count * 4);
    if ((info->need & SVO_NEED_COLOR) != 0) {
        read_array(arrays->colors, info->node_count * 4);
    }
    if ((info->need & SVO_NEED_NORMAL) != 0) {
        read_array(arrays->normals, info->node_count * 6);
    }
    if ((info->need & SVO_NEED_MATERIAL) != 0) {
        read_array(arrays->materials, info->node_count * 2);
    }
    if ((info->need & SVO_NEED_FILL) != 0) {
        read_array(arrays->fills, info->node_count * 2);
    }
    if ((info->need & SVO_NEED_PROJECTED_AREA) != 0) {
        read_array(arrays->areas, info->leaf_count * 12);
    }
    if ((info->need & SVO_NEED_RAYS) != 0) {
        read_array(arrays->list_begin, (info->leaf_count + 1) * 4);
        read_array(arrays->list, info->list_count * 4);
        read_array(arrays->vertices, info->vertex_count * 12);
        read_array(arrays->indices, info->list_triangle_count * 12);
        read_array(arrays->triangle_ids, info->list_triangle_count * 4);
    }
}

/* Whether the masks describe a tree of the given depth, by a traversal that shares no code with the reader. */
static void check_masks(const svo_tree_info *info, const svo_tree_arrays *arrays)
{
    REQUIRE(info->depth >= SVO_DEPTH_MIN && info->depth <= SVO_DEPTH_MAX);
    REQUIRE(info->node_count == info->inner_count + info->leaf_count && info->inner_count > 0);
    REQUIRE(info->level_begin[info->depth + 1] == info->node_count);
    uint64_t *codes = calloc((size_t)info->leaf_count + 1, sizeof *codes);
    REQUIRE(codes != NULL);
    REQUIRE(oracle_leaf_codes(arrays->child_mask, info->inner_count, info->depth, info->leaf_count, codes));
    free(codes);
    uint64_t next_child = 1;
    for (uint64_t node = 0; node < info->inner_count; ++node) {
        REQUIRE(arrays->first_child[node] == next_child);
        for (unsigned octant = 0; octant < 8; ++octant) {
            next_child += arrays->child_mask[node] >> octant & 1u;
        }
    }
}

/* Reads the coordinates of the triangles of each leaf, as a ray caster does. */
static void check_lists(const svo_tree_info *info, const svo_tree_arrays *arrays)
{
    REQUIRE(arrays->list_begin[0] == 0 && arrays->list_begin[info->leaf_count] == info->list_count);
    for (uint64_t leaf = 0; leaf < info->leaf_count; ++leaf) {
        REQUIRE(arrays->list_begin[leaf] <= arrays->list_begin[leaf + 1]);
    }
    for (uint64_t i = 0; i < info->list_count; ++i) {
        const uint32_t triangle = arrays->list[i];
        REQUIRE(triangle < info->list_triangle_count);
        REQUIRE(arrays->triangle_ids[triangle] < info->triangles);
        for (size_t corner = 0; corner < 9; ++corner) {
            const uint32_t vertex = arrays->indices[(size_t)triangle * 3 + corner / 3];
            REQUIRE(vertex < info->vertex_count);
            REQUIRE(abs(arrays->vertices[(size_t)vertex * 3 + corner % 3]) < 1 << 29);
        }
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t byte_count)
{
    static const uint8_t nothing;
    svo_tree *tree = NULL;
    svo_message message = {""};
    const svo_status status =
        svo_tree_load(svo_from_memory(data != NULL ? data : &nothing, byte_count, NAME), NULL, &tree, &message);
    if (status != SVO_OK) {
        check_refusal(status, tree, &message);
        return 0;
    }
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    char hash[SVO_HASH_TEXT_BYTES];
    svo_tree_get_info(tree, &info);
    svo_tree_get_arrays(tree, &arrays);
    read_arrays(&info, &arrays);
    check_masks(&info, &arrays);
    if ((info.need & SVO_NEED_RAYS) != 0) {
        check_lists(&info, &arrays);
    }
    REQUIRE(svo_tree_hash(tree, SVO_HASH_ALL, hash) == SVO_OK && strlen(hash) == SVO_HASH_TEXT_BYTES - 1);
    REQUIRE(svo_tree_hash(tree, SVO_HASH_NODES, hash) == SVO_OK && strlen(hash) == SVO_HASH_TEXT_BYTES - 1);
    svo_tree_destroy(&tree);
    REQUIRE(tree == NULL);
    return 0;
}
