/* SPDX-License-Identifier: MIT */
/*
 * Merging of full leaves (svo_compact_options.minimize): which nodes merge and what they store, against a recursion on
 * the host that looks at every voxel below every node; closed forms; and tolerances, measured at every voxel.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "support/counting.h"
#include "support/fixture.h"
#include "support/meshes.h"
#include "support/suite.h"
#include "voxel_mesh.h"

static void succeed(const fixture *opened, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), svo_device_message(opened->device));
    }
}

#define SOME_PAYLOAD (SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_MATERIAL)
#define ALL_PAYLOAD  (SOME_PAYLOAD | SVO_NEED_FILL)

/* ---- voxels ---- */

typedef struct voxel_list {
    voxel *voxels;
    size_t count;
    unsigned depth;
} voxel_list;

/* Sets the payload of a voxel. */
typedef void paint(voxel *one, void *user);

static voxel_list full_grid(unsigned depth, paint *painter, void *user)
{
    voxel_list list = {.count = (size_t)1 << 3 * depth, .depth = depth};
    list.voxels = calloc(list.count, sizeof *list.voxels);
    assert_non_null(list.voxels);
    for (size_t code = 0; code < list.count; ++code) {
        list.voxels[code] = (voxel){.rgba = {200, 100, 50, 255}, .normal = {0, 0, 1}, .width = 0.5};
        svo_code_to_cell(code, list.voxels[code].cell);
        if (painter != NULL) {
            painter(&list.voxels[code], user);
        }
    }
    return list;
}

static void build_list(const fixture *opened, const voxel_list *list, uint32_t need, uint32_t payload_level, built *out)
{
    voxel_mesh made;
    voxel_mesh_make(list->voxels, list->count, list->depth, &made);
    made.options.need = need;
    made.options.payload_level = payload_level;
    fixture_build(opened, &made.mesh, list->depth, &made.options, out);
    assert_int_equal(out->info.leaf_count, list->count);
    voxel_mesh_free(&made);
}

/* ---- the recursion ---- */

/* What the recursion finds. Values are by component: red, green, blue, alpha, x, y, z, fill. */
enum { COMPONENTS = 8, FILL = 7 };

typedef struct expected {
    const built *tree;
    const svo_compact_options *options;
    uint32_t varying; /* svo_need bits of payload that is held and not constant */
    uint64_t level_inner[SVO_LEVELS_MAX], level_leaf[SVO_LEVELS_MAX];
    int32_t (*stored)[COMPONENTS]; /* by voxel: what it has after merging */
} expected;

static void values_of(const expected *job, uint32_t node, int32_t values[COMPONENTS])
{
    const svo_tree_info *info = &job->tree->info;
    const svo_tree_arrays *arrays = &job->tree->arrays;
    const size_t at = node - info->level_begin[info->payload_level];
    memset(values, 0, COMPONENTS * sizeof *values);
    for (size_t channel = 0; channel < 4 && (job->varying & SVO_NEED_COLOR) != 0; ++channel) {
        values[channel] = arrays->colors[4 * at + channel];
    }
    for (size_t axis = 0; axis < 3 && (job->varying & SVO_NEED_NORMAL) != 0; ++axis) {
        values[4 + axis] = arrays->normals[3 * at + axis];
    }
    if ((job->varying & SVO_NEED_FILL) != 0) {
        values[FILL] = arrays->fills[at];
    }
}

static int32_t tolerance_of(const expected *job, int component)
{
    const svo_compact_options *options = job->options;
    return (int32_t)(component < 4      ? options->color_tolerance[component]
                     : component < FILL ? options->normal_tolerance
                                        : options->fill_tolerance);
}

/* The voxels below a node lie side by side. */
static void voxels_below(const expected *job, uint32_t node, uint32_t level, uint32_t *first, uint32_t *end)
{
    const svo_tree_arrays *arrays = &job->tree->arrays;
    uint32_t last = node;
    *first = node;
    for (; level < job->tree->info.depth; ++level) {
        unsigned children = 0;
        for (unsigned octant = 0; octant < 8; ++octant) {
            children += arrays->child_mask[last] >> octant & 1;
        }
        *first = arrays->first_child[*first];
        last = arrays->first_child[last] + children - 1;
    }
    *end = last + 1;
}

/* Whether every voxel below is near enough to what the node would store, which is returned too. */
static int is_near(const expected *job, uint32_t node, uint32_t level, int32_t stored[COMPONENTS])
{
    const uint16_t *materials = job->tree->arrays.materials;
    const uint32_t begin = job->tree->info.level_begin[job->tree->info.payload_level];
    uint32_t first;
    uint32_t end;
    int32_t least_fill = INT32_MAX;
    int32_t most_fill = 0;
    voxels_below(job, node, level, &first, &end);
    values_of(job, node, stored);
    for (uint32_t one = first; one < end; ++one) {
        int32_t values[COMPONENTS];
        values_of(job, one, values);
        least_fill = values[FILL] < least_fill ? values[FILL] : least_fill;
        most_fill = values[FILL] > most_fill ? values[FILL] : most_fill;
        for (int c = 0; c < FILL; ++c) {
            if (abs(values[c] - stored[c]) > tolerance_of(job, c)) {
                return 0;
            }
        }
        if ((job->varying & SVO_NEED_MATERIAL) != 0 && materials[one - begin] != materials[node - begin]) {
            return 0;
        }
    }
    stored[FILL] = (least_fill + most_fill) / 2;
    return most_fill - least_fill <= 2 * tolerance_of(job, FILL);
}

/* Counts the subtree of a node into levels and returns whether it became a leaf; parents then take its counts back. */
static int merge_node(expected *job, uint32_t node, uint32_t level)
{
    const svo_tree_info *info = &job->tree->info;
    const svo_tree_arrays *arrays = &job->tree->arrays;
    int32_t stored[COMPONENTS];
    if (level == info->depth) {
        ++job->level_leaf[level];
        values_of(job, node, job->stored[node - info->inner_count]);
        return 1;
    }
    int full = arrays->child_mask[node] == 255;
    uint32_t child = arrays->first_child[node];
    for (unsigned octant = 0; octant < 8; ++octant) {
        if ((arrays->child_mask[node] >> octant & 1) != 0) {
            full = merge_node(job, child, level + 1) != 0 && full;
            ++child;
        }
    }
    if (!full || level == 0 || (job->varying != 0 && level < info->payload_level) ||
        (job->varying != 0 && !is_near(job, node, level, stored))) {
        ++job->level_inner[level];
        return 0;
    }
    job->level_leaf[level + 1] -= 8;
    ++job->level_leaf[level];
    uint32_t first;
    uint32_t end;
    voxels_below(job, node, level, &first, &end);
    for (uint32_t one = first; one < end && job->varying != 0; ++one) {
        memcpy(job->stored[one - info->inner_count], stored, sizeof stored);
    }
    return 1;
}

/* ---- comparing ---- */

static void compare_counts(const expected *job, const svo_compact_info *info)
{
    for (uint32_t level = 0; level <= info->depth; ++level) {
        assert_int_equal(info->level_inner[level], job->level_inner[level]);
        assert_int_equal(info->level_leaf[level], job->level_leaf[level]);
    }
    assert_int_equal(info->voxel_count, job->tree->info.leaf_count);
    assert_int_equal(info->minimized, 1);
}

/* Every voxel has what the recursion says, and is within the tolerance of what it was. Its material is the same. */
static void compare_voxels(const expected *job, svo_tree *expanded)
{
    built after = {.tree = expanded, .info = SVO_TREE_INFO_INIT, .arrays = SVO_TREE_ARRAYS_INIT};
    const svo_tree_info *info = &job->tree->info;
    assert_int_equal(svo_tree_get_info(expanded, &after.info), SVO_OK);
    assert_int_equal(svo_tree_get_arrays(expanded, &after.arrays), SVO_OK);
    const expected reader = {.tree = &after, .varying = job->varying};
    for (uint32_t one = (uint32_t)info->inner_count; one < info->node_count; ++one) {
        int32_t was[COMPONENTS];
        int32_t is[COMPONENTS];
        values_of(job, one, was);
        values_of(&reader, one, is);
        for (int c = 0; c < COMPONENTS; ++c) {
            assert_int_equal(is[c], job->stored[one - info->inner_count][c]);
            assert_in_range(abs(is[c] - was[c]), 0, tolerance_of(job, c));
        }
    }
    if ((job->varying & SVO_NEED_MATERIAL) != 0) {
        const size_t leaves = (size_t)(info->inner_count - info->level_begin[info->payload_level]);
        assert_memory_equal(after.arrays.materials + leaves, job->tree->arrays.materials + leaves,
                            2 * (size_t)info->leaf_count);
    }
}

/* Merges a tree in every form. same: expanding gives back all payload of all levels too. Returns the leaves. */
static uint64_t check_tree(const fixture *opened, const built *tree, svo_compact_options options, int same)
{
    expected job = {.tree = tree, .options = &options, .varying = tree->info.need & ~tree->info.constant};
    uint64_t leaves = 0;
    job.stored = calloc((size_t)tree->info.leaf_count + 1, sizeof *job.stored);
    assert_non_null(job.stored);
    (void)merge_node(&job, 0, 0);
    options.struct_size = sizeof options;
    options.minimize = 1;
    for (int form = 0; form < SVO_FORM_COUNT; ++form) {
        svo_compact *compact = NULL;
        svo_tree *expanded = NULL;
        svo_compact_info info = SVO_COMPACT_INFO_INIT;
        char hash[SVO_HASH_TEXT_BYTES];
        options.form = (svo_form)form;
        succeed(opened, svo_compact_create(opened->device, tree->tree, &options, opened->queue, &compact));
        succeed(opened, svo_compact_get_info(compact, &info));
        compare_counts(&job, &info);
        leaves = info.leaf_count;
        succeed(opened, svo_compact_expand(compact, opened->queue, &expanded));
        succeed(opened, svo_tree_download(expanded, opened->queue));
        succeed(opened, svo_tree_hash(expanded, same ? SVO_HASH_ALL : SVO_HASH_NODES, hash));
        assert_string_equal(hash, same ? tree->hash : tree->nodes_hash);
        if (job.varying != 0) {
            compare_voxels(&job, expanded);
        }
        svo_tree_destroy(&expanded);
        svo_compact_destroy(&compact);
    }
    free(job.stored);
    return leaves;
}

static const svo_compact_options exact = {.minimize = 1};

/* ---- tests ---- */

/* The root stays an inner node. */
static void a_full_tree_is_eight_leaves(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (unsigned depth = 1; depth <= 5; ++depth) {
        const uint32_t needs[] = {SVO_NEED_NONE, SOME_PAYLOAD};
        voxel_list list = full_grid(depth, NULL, NULL);
        for (int i = 0; i < 2; ++i) {
            built tree;
            build_list(&opened, &list, needs[i], 0, &tree);
            assert_int_equal(check_tree(&opened, &tree, exact, 1), 8);
            built_destroy(&tree);
        }
        free(list.voxels);
    }
}

/* Aligned blocks, each of one color, one normal and one material, with holes. */
static voxel_list random_blocks(uint64_t seed, unsigned depth)
{
    uint64_t random = seed;
    voxel_list list = full_grid(depth, NULL, NULL);
    for (int block = 0; block < 60; ++block) {
        const unsigned level = random_below(&random, depth);
        const size_t width = (size_t)1 << 3 * level;
        const size_t first = random_below(&random, (uint32_t)(list.count / width)) * width;
        voxel painted = {.width = 0.1 + 0.1 * random_below(&random, 3), .material = (uint16_t)random_below(&random, 3)};
        for (unsigned channel = 0; channel < 4; ++channel) {
            painted.rgba[channel] = (uint8_t)random_below(&random, 256);
            painted.normal[channel % 3] = (float)random_unit(&random) - 0.5f;
        }
        for (size_t code = first; code < first + width; ++code) {
            memcpy(painted.cell, list.voxels[code].cell, sizeof painted.cell);
            list.voxels[code] = painted;
        }
    }
    /* Holes: whole blocks and single voxels. */
    size_t kept = 0;
    const uint32_t hole = random_below(&random, 8);
    for (size_t code = 0; code < list.count; ++code) {
        if (code / (list.count / 8) != hole && (code >> 9 != 1 || random_below(&random, 50) > 0)) {
            list.voxels[kept] = list.voxels[code];
            ++kept;
        }
    }
    list.count = kept;
    return list;
}

static void blocks_of_one_payload_merge(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const uint32_t needs[] = {SVO_NEED_NONE, SVO_NEED_COLOR, SOME_PAYLOAD, ALL_PAYLOAD};
    for (unsigned turn = 0; turn < 12; ++turn) {
        const unsigned depth = 3 + turn % 3;
        const uint32_t need = needs[turn % 4];
        voxel_list list = random_blocks(turn + 1, depth);
        built tree;
        build_list(&opened, &list, need, 0, &tree);
        const uint64_t leaves = check_tree(&opened, &tree, exact, (need & SVO_NEED_FILL) == 0);
        assert_true(leaves < tree.info.leaf_count / 2);
        built_destroy(&tree);
        free(list.voxels);
    }
}

/* Payload that differs a little from voxel to voxel. */
static void noisy(voxel *one, void *user)
{
    uint64_t *random = user;
    for (unsigned channel = 0; channel < 4; ++channel) {
        one->rgba[channel] = (uint8_t)(100 + 3 * (one->cell[0] + one->cell[1]) + random_below(random, 5));
    }
    one->normal[0] = 0.01f * (float)random_unit(random);
    one->width = 0.5 + 0.02 * random_unit(random);
}

static void merged_voxels_stay_within_the_tolerances(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    uint64_t random = 9;
    voxel_list list = full_grid(4, noisy, &random);
    const uint32_t colors[] = {0, 2, 5, 12, 40, 255};
    uint64_t leaves_before = list.count + 1;
    built tree;
    build_list(&opened, &list, ALL_PAYLOAD, 0, &tree);
    for (size_t i = 0; i < sizeof colors / sizeof colors[0]; ++i) {
        svo_compact_options options = {.normal_tolerance = 40 * colors[i], .fill_tolerance = 10 * colors[i]};
        for (int channel = 0; channel < 4; ++channel) {
            options.color_tolerance[channel] = colors[i];
        }
        const uint64_t leaves = check_tree(&opened, &tree, options, 0);
        assert_in_range(leaves, 8, leaves_before);
        leaves_before = leaves;
    }
    assert_int_equal(leaves_before, 8);
    built_destroy(&tree);
    free(list.voxels);
}

/* Red rises by 4 with each voxel along x. */
static void ramp(voxel *one, void *user)
{
    (void)user;
    one->rgba[0] = (uint8_t)(4 * one->cell[0]);
}

/* On a ramp of four a voxel, the values of two voxels are 2 away from their mean, and the means of two such pairs 4
   away from theirs. A test of children's means alone, with a tolerance of 4, would merge both levels, and voxels would
   be 6 away. So only pairs merge. */
static void tolerances_do_not_add_up(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    voxel_list list = full_grid(4, ramp, NULL);
    built tree;
    build_list(&opened, &list, SVO_NEED_COLOR, 0, &tree);
    const uint32_t tolerances[] = {1, 2, 4, 5, 6};
    const uint64_t leaves[] = {4096, 512, 512, 512, 64};
    for (size_t i = 0; i < sizeof leaves / sizeof leaves[0]; ++i) {
        const svo_compact_options options = {.color_tolerance = {tolerances[i], 0, 0, 0}};
        assert_int_equal(check_tree(&opened, &tree, options, 0), leaves[i]);
    }
    built_destroy(&tree);
    free(list.voxels);
}

/* Nodes above the payload's first level have no place for payload, unless it is the same everywhere. */
static void nodes_without_payload_do_not_merge(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (uint32_t payload_level = 0; payload_level <= 4; ++payload_level) {
        const uint64_t widths[] = {1, 1, 2, 3, 4};
        built tree;
        voxel_list list = full_grid(4, ramp, NULL);
        build_list(&opened, &list, SVO_NEED_COLOR, payload_level, &tree);
        const svo_compact_options options = {.color_tolerance = {255, 0, 0, 0}};
        const uint64_t leaves = check_tree(&opened, &tree, options, 0);
        assert_int_equal(leaves, UINT64_C(1) << 3 * widths[payload_level]);
        built_destroy(&tree);
        free(list.voxels);
        list = full_grid(4, NULL, NULL);
        build_list(&opened, &list, SVO_NEED_COLOR, payload_level, &tree);
        if (tree.info.constant == SVO_NEED_COLOR) {
            assert_int_equal(check_tree(&opened, &tree, exact, 1), 8);
        }
        built_destroy(&tree);
        free(list.voxels);
    }
}

/* One voxel of another material. */
static void one_other_material(voxel *one, void *user)
{
    (void)user;
    one->material = one->cell[0] == 7 && one->cell[1] == 2 && one->cell[2] == 5 ? 3 : 1;
}

static void materials_never_mix(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_compact_options options = {.normal_tolerance = 65534, .fill_tolerance = 65535};
    voxel_list list = full_grid(3, one_other_material, NULL);
    built tree;
    for (int channel = 0; channel < 4; ++channel) {
        options.color_tolerance[channel] = 255;
    }
    build_list(&opened, &list, SOME_PAYLOAD, 0, &tree);
    /* Seven octants merge; of the eighth, seven of eight. */
    assert_int_equal(check_tree(&opened, &tree, options, 0), 7 + 7 + 8);
    built_destroy(&tree);
    free(list.voxels);
}

static void tolerances_out_of_range_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    voxel_list list = full_grid(1, NULL, NULL);
    built tree;
    build_list(&opened, &list, SVO_NEED_COLOR, 0, &tree);
    const struct {
        svo_compact_options options;
        const char *message;
    } wrong[] = {
        {{.color_tolerance = {256, 0, 0, 0}}, "svo_compact_create: options.color_tolerance 256 is above 255"},
        {{.color_tolerance = {0, 0, 0, 1000}}, "svo_compact_create: options.color_tolerance 1000 is above 255"},
        {{.normal_tolerance = 65535}, "svo_compact_create: options.normal_tolerance 65535 is above 65534"},
        {{.fill_tolerance = 65536}, "svo_compact_create: options.fill_tolerance 65536 is above 65535"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        svo_compact_options options = wrong[i].options;
        svo_compact *compact = NULL;
        options.struct_size = sizeof options;
        options.minimize = 1;
        assert_int_equal(svo_compact_create(opened.device, tree.tree, &options, opened.queue, &compact),
                         SVO_INVALID_ARGUMENT);
        assert_string_equal(svo_device_message(opened.device), wrong[i].message);
        assert_null(compact);
    }
    built_destroy(&tree);
    free(list.voxels);
}

/* The root becomes no leaf, and has the fill of a node, not of the voxels in it. */
static void the_root_keeps_its_fill(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_compact_options options = {
        .struct_size = sizeof options, .form = SVO_FORM_IMPLIED, .minimize = 1, .fill_tolerance = 65535};
    const voxel_list list = full_grid(1, NULL, NULL);
    svo_compact_arrays arrays = SVO_COMPACT_ARRAYS_INIT;
    svo_compact *compact = NULL;
    built tree;
    build_list(&opened, &list, ALL_PAYLOAD, 0, &tree);
    succeed(&opened, svo_compact_create(opened.device, tree.tree, &options, opened.queue, &compact));
    succeed(&opened, svo_compact_download(compact, opened.queue));
    succeed(&opened, svo_compact_get_arrays(compact, &arrays));
    assert_int_not_equal(tree.arrays.fills[0], tree.arrays.fills[1]);
    assert_int_equal(arrays.fills[0], tree.arrays.fills[0]);
    svo_compact_destroy(&compact);
    built_destroy(&tree);
    free(list.voxels);
}

/* The counts of all levels come to the host at once. */
static void waits_do_not_grow_with_the_depth(void **state)
{
    static const unsigned depths[2] = {2, 6};
    const fixture opened = fixture_cl_of_group(state);
    const svo_compact_options options = {.struct_size = sizeof options, .form = SVO_FORM_DESCRIPTOR, .minimize = 1};
    uint64_t waits[2];
    for (int i = 0; i < 2; ++i) {
        const voxel_list list = full_grid(depths[i], NULL, NULL);
        svo_compact *compact = NULL;
        built tree;
        build_list(&opened, &list, SVO_NEED_COLOR, 0, &tree);
        counting_begin();
        assert_int_equal(svo_compact_create(opened.device, tree.tree, &options, opened.queue, &compact), SVO_OK);
        waits[i] = counting_read().waits;
        svo_compact_destroy(&compact);
        built_destroy(&tree);
        free(list.voxels);
    }
    assert_in_range(waits[0], 1, UINT64_MAX);
    assert_int_equal(waits[0], waits[1]);
}

TEST_GROUP(minimize)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_full_tree_is_eight_leaves),
        cmocka_unit_test(blocks_of_one_payload_merge),
        cmocka_unit_test(merged_voxels_stay_within_the_tolerances),
        cmocka_unit_test(tolerances_do_not_add_up),
        cmocka_unit_test(nodes_without_payload_do_not_merge),
        cmocka_unit_test(materials_never_mix),
        cmocka_unit_test(tolerances_out_of_range_are_refused),
        cmocka_unit_test(the_root_keeps_its_fill),
        cmocka_unit_test(waits_do_not_grow_with_the_depth),
    };
    return cmocka_run_group_tests_name("minimize", tests, fixture_group_setup, fixture_group_teardown);
}
