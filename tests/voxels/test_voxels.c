/* SPDX-License-Identifier: MIT */
/*
 * Voxels to trees and back: lists against a search, trees against sums over the given voxels on every level, places in
 * the world, and what trees without triangles can and cannot do.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scenes.h"
#include "support/fixture.h"
#include "support/meshes.h"
#include "support/payload_reference.h"
#include "support/suite.h"

enum { COUNT = 3000 };

static void succeed(const fixture *opened, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), svo_device_message(opened->device));
    }
}

static svo_voxels *make(const svo_voxels_source *source)
{
    svo_voxels *made = NULL;
    svo_message message = {""};
    if (svo_voxels_create(source, &made, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return made;
}

static svo_voxels_info info_of(const svo_voxels *voxels)
{
    svo_voxels_info info = SVO_VOXELS_INFO_INIT;
    assert_int_equal(svo_voxels_get_info(voxels, &info), SVO_OK);
    return info;
}

/* Voxels of random colors and few materials, dense enough to fill nodes, some more than once. */
static void fill_random(uint64_t seed, svo_voxel voxels[COUNT])
{
    for (int i = 0; i < COUNT; ++i) {
        const uint32_t color = random_word(&seed);
        voxels[i] = (svo_voxel){.x = (int32_t)random_below(&seed, 21) - 40,
                                .y = (int32_t)random_below(&seed, 9) + 1000,
                                .z = (int32_t)random_below(&seed, 33) - 3,
                                .material = (uint16_t)(random_below(&seed, 4) * 1000)};
        memcpy(voxels[i].rgba, &color, 4);
        voxels[i].rgba[3] |= 1; /* what does not show has no color */
    }
}

/* A normal that the voxel's color tells, so that it is known wherever the voxel goes. */
static void normal_of(const svo_voxel *voxel, int16_t normal[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        normal[axis] = (int16_t)((voxel->rgba[axis] - 128) * 147);
    }
}

static svo_voxels *make_random(uint64_t seed)
{
    svo_voxel voxels[COUNT];
    fill_random(seed, voxels);
    svo_voxels_source source = SVO_VOXELS_SOURCE_INIT;
    source.voxels = voxels;
    source.voxel_count = COUNT;
    return make(&source);
}

static svo_voxels *make_random_with_normals(uint64_t seed)
{
    svo_voxel voxels[COUNT];
    int16_t normals[3 * COUNT];
    fill_random(seed, voxels);
    for (int i = 0; i < COUNT; ++i) {
        normal_of(&voxels[i], normals + 3 * (size_t)i);
    }
    svo_voxels_source source = SVO_VOXELS_SOURCE_INIT;
    source.voxels = voxels;
    source.voxel_count = COUNT;
    source.normals = normals;
    return make(&source);
}

static void check_normals(const svo_voxels *voxels)
{
    for (size_t i = 0; i < info_of(voxels).voxel_count; ++i) {
        int16_t normal[3];
        normal_of(&svo_voxels_get(voxels)[i], normal);
        assert_memory_equal(svo_voxels_get_normals(voxels) + 3 * i, normal, sizeof normal);
    }
}

static svo_tree *build(const fixture *opened, const svo_voxels *voxels, unsigned depth, const svo_plan_options *options)
{
    svo_tree *tree = NULL;
    succeed(opened, svo_voxels_build(opened->device, voxels, depth, options, opened->queue, &tree, NULL));
    succeed(opened, svo_tree_download(tree, opened->queue));
    return tree;
}

static void hash_of(const svo_tree *tree, char hash[SVO_HASH_TEXT_BYTES])
{
    assert_int_equal(svo_tree_hash(tree, SVO_HASH_ALL, hash), SVO_OK);
}

/* ---- lists ---- */

static void lists_keep_the_last_voxel_of_each_place(void **state)
{
    (void)state;
    svo_voxel given[COUNT];
    fill_random(1, given);
    svo_voxels_source source = SVO_VOXELS_SOURCE_INIT;
    source.voxels = given;
    source.voxel_count = COUNT;
    svo_voxels *made = make(&source);
    const svo_voxels_info info = info_of(made);
    const svo_voxel *voxels = svo_voxels_get(made);
    uint64_t before = 0;
    size_t distinct = 0;
    for (int i = 0; i < COUNT; ++i) {
        bool last = true;
        for (int k = i + 1; k < COUNT && last; ++k) {
            last = memcmp(&given[i], &given[k], offsetof(svo_voxel, rgba)) != 0;
        }
        bool found = !last;
        for (size_t k = 0; k < info.voxel_count && !found; ++k) {
            found = memcmp(&given[i], &voxels[k], sizeof given[i]) == 0;
        }
        distinct += last ? 1 : 0;
        assert_true(found);
    }
    assert_int_equal(info.voxel_count, distinct);
    assert_int_equal(info.given_count, COUNT);
    for (size_t i = 0; i < info.voxel_count; ++i) {
        const uint32_t cell[3] = {(uint32_t)(voxels[i].x - info.low[0]), (uint32_t)(voxels[i].y - info.low[1]),
                                  (uint32_t)(voxels[i].z - info.low[2])};
        const uint64_t code = svo_cell_to_code(cell) + 1;
        assert_true(code > before);
        before = code;
    }
    assert_int_equal(info.low[0], -40);
    assert_int_equal(info.high[1], 1009);
    assert_int_equal(info.depth, 6);
    assert_int_equal(info.material_count, 3001);
    svo_voxels_destroy(&made);
    assert_null(made);
    svo_voxels_destroy(&made);
    svo_voxels_destroy(NULL);
}

static void expect_refused(const svo_voxels_source *source, const char *words)
{
    svo_voxels *made = NULL;
    svo_message message = {""};
    const svo_status status = svo_voxels_create(source, &made, &message);
    if (status != SVO_INVALID_ARGUMENT || strstr(message.text, words) == NULL ||
        strncmp(message.text, "svo_voxels_create: ", 19) != 0) {
        fail_msg("%s '%s', expected '%s'", svo_name(SVO_NAME_STATUS, status), message.text, words);
    }
    assert_null(made);
}

static void lists_refuse_what_is_out_of_range(void **state)
{
    (void)state;
    svo_voxel voxels[2] = {{.x = 1}, {.x = 2}};
    svo_voxel_property property = {1, "key", "value"};
    svo_voxels *made = NULL;
    const svo_voxels_source good = {
        .struct_size = sizeof good, .voxels = voxels, .voxel_count = 2, .properties = &property, .property_count = 1};
    svo_voxels_source source = good;
    assert_int_equal(svo_voxels_create(NULL, &made, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_voxels_create(&good, NULL, NULL), SVO_INVALID_ARGUMENT);
    source.struct_size = 1;
    expect_refused(&source, "source.struct_size is 1");
    source = good;
    source.voxel_count = (uint64_t)SVO_VOXELS_MAX + 1;
    expect_refused(&source, "source.voxel_count 2147483649 is above 2147483648");
    source = good;
    voxels[1].reserved = 3;
    expect_refused(&source, "source.voxels[1].reserved 3 is not 0");
    voxels[1].reserved = 0;
    source.voxels = NULL;
    expect_refused(&source, "source.voxels is NULL");
    source = good;
    source.properties = NULL;
    expect_refused(&source, "source.properties is NULL");
    source = good;
    source.origin[1] = NAN;
    expect_refused(&source, "source.origin[1] nan is not finite");
    source = good;
    source.voxel_edge = -1.0;
    expect_refused(&source, "source.voxel_edge -1 is not finite and at least 0");
    property.key = "";
    expect_refused(&good, "source.properties[0] has no key");
    property = (svo_voxel_property){65535, "key", "value"};
    expect_refused(&good, "a material above 65534");
    property.material = 0;
    voxels[1].x = 1 + SVO_VOXELS_EXTENT_MAX;
    expect_refused(&good, "x coordinates 1 .. 2097153 span more than 2097152 voxels");
    voxels[1] = (svo_voxel){.y = (1 << 30) + 1};
    expect_refused(&good, "y coordinates 0 .. 1073741825 are not in");
    voxels[1] = (svo_voxel){.material = 65535};
    expect_refused(&good, "a voxel's material 65535 is above 65534");
}

/* ---- trees ---- */

/* A node's sums over the given voxels. */
typedef struct sums {
    uint64_t code, count, materials[4]; /* materials: of 0, 1000, 2000, 3000 */
    uint64_t color[4]; /* red, green and blue times alpha */
    int64_t normal[3];
} sums;

/* Sums the voxels of each node of a level; voxels are sorted by code. Returns how many nodes there are. */
static size_t sum_level(const svo_voxels *voxels, uint32_t shift, sums *nodes)
{
    const svo_voxels_info info = info_of(voxels);
    size_t count = 0;
    for (size_t i = 0; i < info.voxel_count; ++i) {
        const svo_voxel *voxel = &svo_voxels_get(voxels)[i];
        const uint32_t cell[3] = {(uint32_t)(voxel->x - info.low[0]), (uint32_t)(voxel->y - info.low[1]),
                                  (uint32_t)(voxel->z - info.low[2])};
        const uint64_t code = svo_cell_to_code(cell) >> (3 * shift);
        if (count == 0 || nodes[count - 1].code != code) {
            nodes[count++] = (sums){.code = code};
        }
        ++nodes[count - 1].count;
        ++nodes[count - 1].materials[voxel->material / 1000];
        for (int channel = 0; channel < 4; ++channel) {
            nodes[count - 1].color[channel] += voxel->rgba[channel] * (channel < 3 ? voxel->rgba[3] : 1U);
        }
        for (size_t axis = 0; axis < 3; ++axis) {
            nodes[count - 1].normal[axis] += svo_voxels_get_normals(voxels)[3 * i + axis];
        }
    }
    return count;
}

static void check_node(const svo_tree *tree, const svo_tree_arrays *arrays, uint32_t level, const sums *expected)
{
    svo_node node = {.index = 0};
    uint32_t cell[3];
    svo_code_to_cell(expected->code, cell);
    assert_int_equal(svo_tree_find_cell(tree, level, cell, &node), SVO_OK);
    assert_int_equal(node.level, level);
    uint16_t heaviest = 0;
    for (uint16_t m = 1; m < 4; ++m) {
        heaviest = expected->materials[m] > expected->materials[heaviest] ? m : heaviest;
    }
    assert_int_equal(arrays->materials[node.index], 1000 * heaviest);
    for (size_t axis = 0; axis < 3; ++axis) {
        const double mean = (double)expected->normal[axis] / (double)expected->count;
        assert_int_equal(arrays->normals[3 * (size_t)node.index + axis], (int)floor(mean + 0.5));
    }
    for (int channel = 0; channel < 4; ++channel) {
        const uint64_t by = channel < 3 && expected->color[3] > 0 ? expected->color[3] : expected->count;
        const uint64_t rounded = (2 * expected->color[channel] + by) / (2 * by);
        const uint64_t mean = channel < 3 ? rounded : payload_alpha(rounded, expected->color[3], expected->count);
        if (arrays->colors[4 * (size_t)node.index + (size_t)channel] != mean) {
            fail_msg("level %u node %u channel %d: %d, expected %llu", level, node.index, channel,
                     arrays->colors[4 * (size_t)node.index + (size_t)channel], (unsigned long long)mean);
        }
    }
}

static void trees_have_the_means_of_their_voxels(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_voxels *voxels = make_random_with_normals(2);
    svo_tree *tree = build(&opened, voxels, 0, NULL);
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    svo_voxels *leaves = NULL;
    check_normals(voxels);
    assert_int_equal(svo_tree_get_voxels(tree, &leaves, NULL), SVO_OK);
    check_normals(leaves);
    svo_voxels_destroy(&leaves);
    sums *nodes = calloc(COUNT, sizeof *nodes);
    assert_non_null(nodes);
    assert_int_equal(svo_tree_get_info(tree, &info), SVO_OK);
    assert_int_equal(svo_tree_get_arrays(tree, &arrays), SVO_OK);
    assert_int_equal(info.depth, 6);
    assert_int_equal(info.triangles, 0);
    assert_int_equal(info.is_exact, 1);
    assert_int_equal(info.leaf_count, info_of(voxels).voxel_count);
    for (uint32_t level = 0; level <= info.depth; ++level) {
        const size_t count = sum_level(voxels, info.depth - level, nodes);
        assert_int_equal(info.level_begin[level + 1] - info.level_begin[level], count);
        for (size_t i = 0; i < count; ++i) {
            check_node(tree, &arrays, level, &nodes[i]);
        }
    }
    free(nodes);
    svo_tree_destroy(&tree);
    svo_voxels_destroy(&voxels);
}

static void both_builders_and_deeper_grids_agree(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    char sorted[SVO_HASH_TEXT_BYTES];
    char other[SVO_HASH_TEXT_BYTES];
    svo_voxels *voxels = make_random(3);
    svo_tree *tree = build(&opened, voxels, 0, NULL);
    hash_of(tree, sorted);
    svo_tree_destroy(&tree);
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    options.builder = SVO_BUILDER_CL;
    tree = build(&opened, voxels, 6, &options);
    hash_of(tree, other);
    assert_string_equal(sorted, other);
    svo_tree_destroy(&tree);
    tree = build(&opened, voxels, 13, NULL); /* above 12 the grid has other units */
    svo_voxels *back = NULL;
    assert_int_equal(svo_tree_get_voxels(tree, &back, NULL), SVO_OK);
    assert_int_equal(info_of(back).voxel_count, info_of(voxels).voxel_count);
    assert_memory_equal(svo_voxels_get(back), svo_voxels_get(voxels), sizeof(svo_voxel) * info_of(voxels).voxel_count);
    svo_voxels_destroy(&back);
    svo_tree_destroy(&tree);
    svo_voxels_destroy(&voxels);
}

/* The voxels of a tree are those it was built from, and make the same tree; the centers of voxels lie in their leaves
   exactly. */
static void voxels_come_back(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const double edges[] = {0.0, 1.0, 0.1, 3.0};
    svo_voxel given[COUNT];
    fill_random(4, given);
    for (size_t i = 0; i < sizeof edges / sizeof edges[0]; ++i) {
        char first[SVO_HASH_TEXT_BYTES];
        char second[SVO_HASH_TEXT_BYTES];
        svo_voxels_source source = SVO_VOXELS_SOURCE_INIT;
        source.voxels = given;
        source.voxel_count = COUNT;
        source.voxel_edge = edges[i];
        source.origin[1] = edges[i] > 1.0 ? 0.3 : 0.0;
        svo_voxels *voxels = make(&source);
        svo_voxels *back = NULL;
        svo_tree *tree = build(&opened, voxels, 0, NULL);
        hash_of(tree, first);
        assert_int_equal(svo_tree_get_voxels(tree, &back, NULL), SVO_OK);
        svo_tree *again = build(&opened, back, 0, NULL);
        hash_of(again, second);
        assert_string_equal(first, second);
        const svo_voxels_info info = info_of(voxels);
        if (edges[i] <= 0.0) {
            assert_memory_equal(svo_voxels_get(back), svo_voxels_get(voxels), sizeof(svo_voxel) * info.voxel_count);
        }
        for (size_t k = 0; k < info.voxel_count; k += 17) {
            const svo_voxel *voxel = &svo_voxels_get(voxels)[k];
            const double center[3] = {info.origin[0] + (voxel->x + 0.5) * info.voxel_edge,
                                      info.origin[1] + (voxel->y + 0.5) * info.voxel_edge,
                                      info.origin[2] + (voxel->z + 0.5) * info.voxel_edge};
            svo_node node = {.index = 0};
            assert_int_equal(svo_tree_find_point(tree, center, &node), SVO_OK);
            assert_int_equal(node.level, info.depth);
            assert_int_equal(node.cell[0], voxel->x - info.low[0]);
            assert_int_equal(node.cell[2], voxel->z - info.low[2]);
        }
        svo_tree_destroy(&again);
        svo_tree_destroy(&tree);
        svo_voxels_destroy(&back);
        svo_voxels_destroy(&voxels);
    }
}

static void trees_of_meshes_give_their_leaves(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    struct scene *knot = fixture_scene("knot:500");
    built tree;
    fixture_build(&opened, scene_mesh(knot), 6, NULL, &tree);
    svo_voxels *voxels = NULL;
    assert_int_equal(svo_tree_get_voxels(tree.tree, &voxels, NULL), SVO_OK);
    const svo_voxels_info info = info_of(voxels);
    svo_grid grid;
    assert_int_equal(svo_tree_get_grid(tree.tree, &grid), SVO_OK);
    assert_int_equal(info.voxel_count, tree.info.leaf_count);
    assert_true(info.voxel_edge == svo_grid_cell_edge(&grid, 6));
    assert_memory_equal(info.origin, tree.info.origin, sizeof info.origin);
    for (uint32_t k = 0; k < info.voxel_count; ++k) {
        svo_node node = {.index = 0};
        const svo_voxel *voxel = &svo_voxels_get(voxels)[k];
        assert_int_equal(svo_tree_find_node(tree.tree, (uint32_t)tree.info.inner_count + k, &node), SVO_OK);
        assert_int_equal(voxel->x, node.cell[0]);
        assert_int_equal(voxel->y, node.cell[1]);
        assert_int_equal(voxel->z, node.cell[2]);
        assert_memory_equal(voxel->rgba, tree.arrays.colors + 4 * (size_t)node.index, 4);
    }
    svo_voxels_destroy(&voxels);
    built_destroy(&tree);
    scene_destroy(&knot);
}

/* A tree whose leaves begin inside the grid gives the list that its voxels make in any order. */
static void leaves_inside_a_grid_are_sorted_from_their_least_corner(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    struct scene *knot = fixture_scene("knot:500");
    built fitted;
    built tree;
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    fixture_build(&opened, scene_mesh(knot), 6, NULL, &fitted);
    options.edge = 2.0 * fitted.info.edge;
    for (int axis = 0; axis < 3; ++axis) {
        options.origin[axis] = fitted.info.origin[axis] - 0.24 * fitted.info.edge;
    }
    fixture_build(&opened, scene_mesh(knot), 6, &options, &tree);
    svo_voxels *leaves = NULL;
    assert_int_equal(svo_tree_get_voxels(tree.tree, &leaves, NULL), SVO_OK);
    const svo_voxels_info info = info_of(leaves);
    assert_true(info.low[0] % 2 != 0 || info.low[1] % 2 != 0 || info.low[2] % 2 != 0);
    assert_int_equal(info.voxel_count, tree.info.leaf_count);
    svo_voxels_source source = SVO_VOXELS_SOURCE_INIT;
    source.voxels = svo_voxels_get(leaves);
    source.voxel_count = info.voxel_count;
    svo_voxels *sorted = make(&source);
    assert_memory_equal(svo_voxels_get(leaves), svo_voxels_get(sorted), sizeof(svo_voxel) * info.voxel_count);
    svo_voxels_destroy(&sorted);
    svo_voxels_destroy(&leaves);
    built_destroy(&tree);
    built_destroy(&fitted);
    scene_destroy(&knot);
}

static void empty_and_single_lists_build(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (uint64_t count = 0; count < 3; ++count) { /* of the last, nothing shows */
        const svo_voxel one = {.x = -7, .y = 5, .z = 1 << 20, .rgba = {1, 2, 3, count == 2 ? 0 : 4}, .material = 65534};
        const bool shows = count < 2;
        svo_voxels_source source = SVO_VOXELS_SOURCE_INIT;
        svo_tree_info info = SVO_TREE_INFO_INIT;
        svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
        source.voxels = &one;
        source.voxel_count = count > 0 ? 1 : 0;
        svo_voxels *voxels = make(&source);
        svo_voxels *back = NULL;
        svo_tree *tree = build(&opened, voxels, 0, NULL);
        assert_int_equal(svo_tree_get_info(tree, &info), SVO_OK);
        assert_int_equal(svo_tree_get_arrays(tree, &arrays), SVO_OK);
        assert_int_equal(info.depth, 1);
        assert_int_equal(info.leaf_count, source.voxel_count);
        assert_int_equal(svo_tree_get_voxels(tree, &back, NULL), SVO_OK);
        assert_int_equal(info_of(back).voxel_count, source.voxel_count);
        if (count > 0) {
            svo_voxel expected = one;
            memset(expected.rgba, 0, shows ? 0 : sizeof expected.rgba);
            assert_memory_equal(svo_voxels_get(back), &expected, sizeof expected);
            assert_memory_equal(arrays.colors, expected.rgba, 4);
        }
        svo_voxels_destroy(&back);
        svo_tree_destroy(&tree);
        svo_voxels_destroy(&voxels);
    }
}

static void needs_and_payload_levels(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const uint32_t needs[] = {SVO_NEED_COLOR, SVO_NEED_MATERIAL, SVO_NEED_NONE,
                                     (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_MATERIAL};
    svo_voxels *voxels = make_random(5);
    for (size_t i = 0; i < sizeof needs / sizeof needs[0]; ++i) {
        svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
        svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
        options.need = needs[i];
        options.payload_level = 6;
        svo_tree *tree = build(&opened, voxels, 0, &options);
        assert_int_equal(svo_tree_get_arrays(tree, &arrays), SVO_OK);
        assert_int_equal(arrays.colors != NULL, (needs[i] & SVO_NEED_COLOR) != 0);
        assert_int_equal(arrays.materials != NULL, (needs[i] & SVO_NEED_MATERIAL) != 0);
        svo_voxels *back = NULL;
        assert_int_equal(svo_tree_get_voxels(tree, &back, NULL), SVO_OK);
        for (size_t k = 0; k < info_of(voxels).voxel_count; ++k) {
            const svo_voxel *given = &svo_voxels_get(voxels)[k];
            const svo_voxel *got = &svo_voxels_get(back)[k];
            assert_int_equal(got->material, arrays.materials != NULL ? given->material : 0);
            assert_true(arrays.colors != NULL ? memcmp(got->rgba, given->rgba, 4) == 0 : got->rgba[2] == 255);
        }
        svo_voxels_destroy(&back);
        svo_tree_destroy(&tree);
    }
    svo_voxels_destroy(&voxels);
}

/* ---- what such trees can do ---- */

static void pictures_work_and_rays_on_triangles_do_not(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_voxels *voxels = make_random(6);
    svo_tree *tree = build(&opened, voxels, 0, NULL);
    uint8_t pixels[32 * 24 * 4] = {0};
    svo_render_options options = SVO_RENDER_OPTIONS_INIT;
    options.width = 32;
    options.height = 24;
    (void)svo_camera_fit(svo_tree_target(tree), 32.0f / 24.0f, &options.camera);
    succeed(&opened,
            svo_render(svo_tree_target(tree), &options, svo_in_host(pixels), &(svo_submit){.queue = opened.queue}));
    bool differs = false;
    for (size_t i = 4; i < sizeof pixels; ++i) {
        differs = differs || pixels[i] != pixels[i % 4];
    }
    assert_true(differs);
    assert_int_equal(svo_tree_make_bvh(tree, SVO_BVH_BEST, opened.queue), SVO_INVALID_ARGUMENT);
    svo_tree_destroy(&tree);
    svo_voxels_destroy(&voxels);
}

static void expect_no_plan(const fixture *opened, const svo_voxels *voxels, unsigned depth,
                           const svo_plan_options *options, const char *words)
{
    svo_tree *tree = NULL;
    svo_plan *plan = NULL;
    assert_int_equal(svo_voxels_plan(opened->device, voxels, depth, options, &plan), SVO_INVALID_ARGUMENT);
    assert_int_equal(strncmp(svo_device_message(opened->device), "svo_voxels_plan: ", 17), 0);
    assert_int_equal(svo_voxels_build(opened->device, voxels, depth, options, NULL, &tree, NULL), SVO_INVALID_ARGUMENT);
    if (strstr(svo_device_message(opened->device), words) == NULL ||
        strncmp(svo_device_message(opened->device), "svo_voxels_build: ", 18) != 0) {
        fail_msg("'%s', expected '%s'", svo_device_message(opened->device), words);
    }
    assert_null(plan);
    assert_null(tree);
}

static void arguments_are_checked(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_voxel wide[] = {{.x = 0}, {.x = 1 << 16}};
    svo_voxels_source source = SVO_VOXELS_SOURCE_INIT;
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    svo_plan *plan = NULL;
    svo_voxels *some = make_random(7);
    source.voxels = wide;
    source.voxel_count = 2;
    svo_voxels *too_wide = make(&source);
    assert_int_equal(info_of(too_wide).depth, 0);
    expect_no_plan(&opened, too_wide, 0, NULL, "the voxels span 65537 x 1 x 1, more than 2^16 along an axis");
    expect_no_plan(&opened, some, 5, NULL, "depth 5 is not in 6 .. 16, or 0");
    expect_no_plan(&opened, some, 17, NULL, "depth 17 is not in 6 .. 16, or 0");
    options.need = SVO_NEED_NORMAL;
    expect_no_plan(&opened, some, 0, &options, "options.need 0x2 is not made of color and material, or none");
    expect_no_plan(&opened, some, 0, &options, "none; the voxels have no normals");
    options.updatable = 1;
    svo_voxels *with_normals = make_random_with_normals(8);
    expect_no_plan(&opened, with_normals, 0, &options, "options.need has normal, and options.updatable is not 0");
    svo_voxels_destroy(&with_normals);
    options = (svo_plan_options)SVO_PLAN_OPTIONS_INIT;
    options.edge = 1.0;
    expect_no_plan(&opened, some, 0, &options, "options.edge is not 0");
    options.edge = 0.0;
    options.coverage = SVO_COVERAGE_CLOSED;
    expect_no_plan(&opened, some, 0, &options, "options.coverage is not 0");
    options.coverage = SVO_COVERAGE_HALF_OPEN;
    options.payload_level = 7;
    expect_no_plan(&opened, some, 0, &options, "payload_level 7");
    options.struct_size = 2;
    expect_no_plan(&opened, some, 0, &options, "options.struct_size is 2");
    expect_no_plan(&opened, NULL, 0, NULL, "voxels is NULL");
    assert_int_equal(svo_voxels_plan(opened.device, some, 0, NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_voxels_plan(NULL, some, 0, NULL, &plan), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_voxels_build(opened.device, some, 0, NULL, NULL, NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_voxels_get_info(NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_voxels_get_info(some, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_tree_get_voxels(NULL, NULL, NULL), SVO_INVALID_ARGUMENT);
    const double edges[] = {1e-310, 1e308, 1e300};
    for (int i = 0; i < 3; ++i) {
        const svo_voxel far[2] = {{.x = (1 << 30) - 1}, {.x = 1 << 30}};
        const svo_voxels_source beyond = {
            .struct_size = sizeof beyond, .voxels = far, .voxel_count = 2, .voxel_edge = edges[i]};
        svo_voxels *voxels = make(&beyond);
        expect_no_plan(&opened, voxels, 0, NULL, "is beyond doubles");
        svo_voxels_destroy(&voxels);
    }
    svo_tree *tree = NULL;
    svo_voxels *back = NULL;
    svo_message message = {""};
    succeed(&opened, svo_voxels_build(opened.device, some, 0, NULL, opened.queue, &tree, NULL));
    assert_int_equal(svo_tree_get_voxels(tree, &back, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_tree_get_voxels: the tree has no host arrays; call svo_tree_download first");
    svo_tree_destroy(&tree);
    svo_voxels_destroy(&some);
    svo_voxels_destroy(&too_wide);
}

TEST_GROUP(voxels)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lists_keep_the_last_voxel_of_each_place),
        cmocka_unit_test(lists_refuse_what_is_out_of_range),
        cmocka_unit_test(trees_have_the_means_of_their_voxels),
        cmocka_unit_test(both_builders_and_deeper_grids_agree),
        cmocka_unit_test(voxels_come_back),
        cmocka_unit_test(trees_of_meshes_give_their_leaves),
        cmocka_unit_test(leaves_inside_a_grid_are_sorted_from_their_least_corner),
        cmocka_unit_test(empty_and_single_lists_build),
        cmocka_unit_test(needs_and_payload_levels),
        cmocka_unit_test(pictures_work_and_rays_on_triangles_do_not),
        cmocka_unit_test(arguments_are_checked),
    };
    return cmocka_run_group_tests_name("voxels", tests, fixture_group_setup, fixture_group_teardown);
}
