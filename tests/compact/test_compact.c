/* SPDX-License-Identifier: MIT */
/*
 * Compact trees: every word, place and payload against an encoder on the host, sizes in closed form, and expanding back
 * to the same hash.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "compact_reference.h"
#include "core/compact.h"
#include "core/tree.h"
#include "scenes.h"
#include "support/fixture.h"
#include "support/meshes.h"
#include "support/suite.h"

#define PAYLOAD \
    ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_MATERIAL | (uint32_t)SVO_NEED_FILL)

/* ---- masks ---- */

static uint8_t full_mask(void *user, uint32_t level, uint64_t code)
{
    (void)user;
    (void)level;
    (void)code;
    return 255;
}

/* Half of the leaves. user: the depth. */
static uint8_t half_mask(void *user, uint32_t level, uint64_t code)
{
    return level + 1 == *(const uint32_t *)user ? 0x5a : full_mask(NULL, level, code);
}

static uint8_t empty_mask(void *user, uint32_t level, uint64_t code)
{
    (void)user;
    (void)level;
    (void)code;
    return 0;
}

typedef struct random_masks {
    uint64_t state;
    uint32_t children; /* of 8, on average; at least one */
} random_masks;

static uint8_t random_mask(void *user, uint32_t level, uint64_t code)
{
    random_masks *random = user;
    unsigned mask = 0;
    (void)code;
    while (mask == 0) {
        for (unsigned octant = 0; octant < 8; ++octant) {
            mask |= (random_below(&random->state, 8) < random->children || level == 0 ? 1u : 0u) << octant;
        }
    }
    return (uint8_t)mask;
}

/* A tree of depth 7: in the root's first octant the leaves with codes below limit, in each other the first leaf. */
static uint8_t filled_mask(void *user, uint32_t level, uint64_t code)
{
    const uint64_t limit = *(const uint64_t *)user;
    const uint32_t leaves_log2 = 3 * (7 - level - 1);
    unsigned mask = 0;
    for (uint64_t octant = 0; octant < 8; ++octant) {
        const uint64_t first_leaf = (code << 3 | octant) << leaves_log2;
        const bool chain = (first_leaf & ((UINT64_C(1) << 18) - 1)) == 0;
        mask |= (unsigned)(first_leaf < limit || chain) << octant;
    }
    return (uint8_t)mask;
}

/* ---- helpers ---- */

static svo_compact *compact_of(const fixture *opened, const svo_tree *tree, const svo_compact_options *options)
{
    svo_compact_options asked = *options;
    svo_compact *made = NULL;
    asked.struct_size = sizeof asked;
    if (svo_compact_create(opened->device, tree, &asked, opened->queue, &made) != SVO_OK ||
        svo_compact_download(made, opened->queue) != SVO_OK) {
        fail_msg("%s", svo_device_message(opened->device));
    }
    return made;
}

static svo_compact_arrays arrays_of(const svo_compact *compact)
{
    svo_compact_arrays arrays = SVO_COMPACT_ARRAYS_INIT;
    assert_int_equal(svo_compact_get_arrays(compact, &arrays), SVO_OK);
    return arrays;
}

static svo_compact_info info_of(const svo_compact *compact)
{
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    assert_int_equal(svo_compact_get_info(compact, &info), SVO_OK);
    return info;
}

/* The tree that a compact tree expands to has the hash of the original. */
static void assert_expands(const fixture *opened, svo_compact *compact, const svo_tree *original, svo_hash_scope scope)
{
    char expected[SVO_HASH_TEXT_BYTES];
    char got[SVO_HASH_TEXT_BYTES];
    svo_tree *expanded = NULL;
    if (svo_compact_expand(compact, opened->queue, &expanded) != SVO_OK ||
        svo_tree_download(expanded, opened->queue) != SVO_OK) {
        fail_msg("%s", svo_device_message(opened->device));
    }
    assert_int_equal(svo_tree_hash(original, scope, expected), SVO_OK);
    assert_int_equal(svo_tree_hash(expanded, scope, got), SVO_OK);
    assert_string_equal(expected, got);
    svo_tree_destroy(&expanded);
}

/* Every payload array of a form, given the tree's nodes in the form's order. order: NULL for the tree's own. */
static void assert_payload(const svo_compact *compact, const svo_tree *tree, const uint32_t *order)
{
    const svo_compact_info *info = &compact->info;
    const uint32_t begin = tree->info.level_begin[tree->info.payload_level];
    for (int i = SVO_I_PAYLOAD_FIRST; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        const svo_tree_buffer buffer = svo_i_compact_tree_buffer((svo_compact_buffer)i);
        const size_t bytes = svo_i_tree_element_bytes(buffer);
        const uint8_t *got = compact->host[i];
        const uint8_t *expected = tree->host[buffer];
        if (!svo_i_tree_holds(&tree->info, buffer)) {
            assert_null(got);
            continue;
        }
        assert_int_equal(info->payload_count, tree->info.node_count - begin);
        for (uint64_t at = 0; at < info->payload_count; ++at) {
            const uint64_t node = order != NULL ? order[at] - begin : at;
            assert_memory_equal(got + at * bytes, expected + node * bytes, bytes);
        }
    }
}

/* ---- descriptors ---- */

static void check_descriptor(const fixture *opened, const svo_tree *tree, uint64_t *far_count)
{
    svo_compact *made = compact_of(opened, tree, &(svo_compact_options){.form = SVO_FORM_DESCRIPTOR});
    const svo_compact_arrays arrays = arrays_of(made);
    const svo_compact_info info = info_of(made);
    svo_compact_info plan = SVO_COMPACT_INFO_INIT;
    reference_words expected;
    reference_words_make(tree, &expected);
    assert_int_equal(info.stored_count, expected.word_count);
    assert_int_equal(info.far_count, expected.far_count);
    assert_memory_equal(arrays.nodes, expected.words, expected.word_count * 4);
    if (svo_i_compact_has_places(&info)) {
        assert_int_equal(info.payload_count, expected.payload_count);
        assert_memory_equal(arrays.bases, expected.bases, expected.word_count * 4);
    } else {
        assert_null(arrays.bases);
    }
    assert_null(arrays.links);
    assert_payload(made, tree, expected.order);
    assert_expands(opened, made, tree, SVO_HASH_ALL);
    assert_int_equal(svo_compact_plan(tree, NULL, &plan), SVO_OK);
    for (int i = 0; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        assert_in_range(info.bytes[i], (plan.bounds >> i & 1) != 0 ? 0 : plan.bytes[i], plan.bytes[i]);
    }
    *far_count = expected.far_count;
    reference_words_free(&expected);
    svo_compact_destroy(&made);
}

static void full_trees_have_the_documented_bytes(void **state)
{
    static const uint64_t bytes[] = {4, 36, 292, 2340, 18724, 149796, 1198400};
    const fixture opened = fixture_cl_of_group(state);
    for (uint32_t depth = 1; depth <= 7; ++depth) {
        svo_tree *tree = hand_tree(depth, full_mask, NULL, 0, 0);
        svo_compact *made = compact_of(&opened, tree, &(svo_compact_options){.form = SVO_FORM_DESCRIPTOR});
        const svo_compact_info info = info_of(made);
        assert_int_equal(info.bytes[SVO_COMPACT_NODES], bytes[depth - 1]);
        assert_int_equal(info.total_bytes, bytes[depth - 1]);
        assert_int_equal(info.far_count, depth == 7 ? 7 : 0);
        assert_int_equal(info.voxel_count, UINT64_C(1) << (3 * depth));
        assert_expands(&opened, made, tree, SVO_HASH_ALL);
        svo_compact_destroy(&made);
        svo_tree_destroy(&tree);
    }
}

static void half_trees_with_colors_have_the_documented_bytes(void **state)
{
    static const uint64_t bytes[] = {24, 200, 1608, 12872, 102984, 823880};
    static const uint64_t published[] = {20, 164, 1316, 10532, 84260, 674084};
    const fixture opened = fixture_cl_of_group(state);
    for (uint32_t depth = 1; depth <= 6; ++depth) {
        uint64_t far_count = 1;
        svo_tree *tree = hand_tree(depth, half_mask, &depth, SVO_NEED_COLOR, depth);
        svo_compact *made = compact_of(&opened, tree, &(svo_compact_options){.form = SVO_FORM_DESCRIPTOR});
        const svo_compact_info info = info_of(made);
        assert_int_equal(info.total_bytes, bytes[depth - 1]);
        assert_int_equal(info.total_bytes - info.bytes[SVO_COMPACT_BASES], published[depth - 1]);
        check_descriptor(&opened, tree, &far_count);
        assert_int_equal(far_count, 0);
        svo_compact_destroy(&made);
        svo_tree_destroy(&tree);
    }
}

static void far_words_are_the_least_fixed_point(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    uint64_t far_before = 0;
    unsigned different = 0;
    /* Around 32767 words in the first octant, so that the other members cross the limit one after the other, some only
       because of the others' far words. */
    for (uint64_t nodes = 28640; nodes < 28680; nodes += 2) {
        uint64_t far_count = 0;
        const uint64_t limit = nodes * 8;
        svo_tree *tree = hand_tree(7, filled_mask, (void *)&limit, 0, 0);
        check_descriptor(&opened, tree, &far_count);
        assert_true(far_count >= far_before);
        different += far_count > far_before;
        far_before = far_count;
        svo_tree_destroy(&tree);
    }
    assert_int_equal(far_before, 7);
    assert_true(different >= 3);
}

static void deep_thin_trees_match_the_reference(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    random_masks thin = {.state = 3, .children = 1};
    random_masks large = {.state = 3, .children = 2};
    uint64_t far_count = 0;
    svo_tree *tree = hand_tree(16, random_mask, &thin, SVO_NEED_COLOR, 3);
    check_descriptor(&opened, tree, &far_count);
    svo_tree_destroy(&tree);
    tree = hand_tree(13, random_mask, &large, SVO_NEED_MATERIAL, 12);
    check_descriptor(&opened, tree, &far_count);
    assert_true(far_count > 3);
    svo_tree_destroy(&tree);
}

static void random_trees_match_the_reference(void **state)
{
    static const uint32_t needs[] = {0, SVO_NEED_COLOR, SVO_NEED_NORMAL, SVO_NEED_FILL, PAYLOAD};
    const fixture opened = fixture_cl_of_group(state);
    random_masks random = {.state = 17};
    for (uint32_t turn = 0; turn < 40; ++turn) {
        uint64_t far_count = 0;
        const uint32_t depth = 1 + turn % 6;
        random.children = 1 + random_below(&random.state, 7 - depth + 1);
        svo_tree *tree =
            hand_tree(depth, random_mask, &random, needs[turn % 5], random_below(&random.state, depth + 1));
        check_descriptor(&opened, tree, &far_count);
        svo_tree_destroy(&tree);
    }
}

/* ---- implied ---- */

static void check_implied(const fixture *opened, const svo_tree *tree, uint32_t step_log2)
{
    const svo_compact_options options = {.form = SVO_FORM_IMPLIED, .directory_step_log2 = step_log2};
    svo_compact *made = compact_of(opened, tree, &options);
    const svo_compact_arrays arrays = arrays_of(made);
    const svo_compact_info info = info_of(made);
    const uint32_t *first_child = tree->host[SVO_TREE_FIRST_CHILD];
    const uint32_t begin = tree->info.level_begin[tree->info.payload_level];
    const uint32_t log2 = step_log2 == 0 ? 5 : step_log2;
    assert_int_equal(info.stored_count, tree->info.inner_count);
    assert_memory_equal(arrays.nodes, tree->host[SVO_TREE_CHILD_MASK], tree->info.inner_count);
    for (uint64_t i = info.stored_count; i < info.bytes[SVO_COMPACT_NODES]; ++i) {
        assert_int_equal(((const uint8_t *)arrays.nodes)[i], 0);
    }
    assert_int_equal(info.bytes[SVO_COMPACT_LINKS], ((tree->info.inner_count - 1) / (1u << log2) + 1) * 4);
    for (uint64_t node = 0; node < tree->info.inner_count; node += 1u << log2) {
        assert_int_equal(arrays.links[node >> log2], first_child[node]);
    }
    if (svo_i_compact_has_places(&info)) {
        assert_int_equal(info.bytes[SVO_COMPACT_BASES], 4);
        assert_int_equal(arrays.bases[0], begin);
    } else {
        assert_null(arrays.bases);
    }
    assert_payload(made, tree, NULL);
    assert_expands(opened, made, tree, SVO_HASH_ALL);
    svo_compact_info plan = SVO_COMPACT_INFO_INIT;
    svo_compact_options asked = options;
    asked.struct_size = sizeof asked;
    assert_int_equal(svo_compact_plan(tree, &asked, &plan), SVO_OK);
    assert_int_equal(plan.bounds, 0);
    assert_memory_equal(plan.bytes, info.bytes, sizeof plan.bytes);
    svo_compact_destroy(&made);
}

static void implied_masks_and_directories_match_the_tree(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    random_masks random = {.state = 19};
    for (uint32_t turn = 0; turn < 12; ++turn) {
        const uint32_t depth = 1 + turn % 6;
        random.children = 1 + random_below(&random.state, 7 - depth + 1);
        svo_tree *tree = hand_tree(depth, random_mask, &random, turn % 2 == 0 ? PAYLOAD : 0, turn % (depth + 1));
        check_implied(&opened, tree, turn % 4 == 0 ? 0 : 3 + turn % 4);
        svo_tree_destroy(&tree);
    }
}

/* ---- any form ---- */

static void empty_trees_stay_empty(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (uint32_t depth = 1; depth <= 16; depth += 5) {
        uint64_t far_count = 1;
        svo_tree *tree = hand_tree(depth, empty_mask, NULL, SVO_NEED_COLOR, 0);
        check_descriptor(&opened, tree, &far_count);
        check_implied(&opened, tree, 5);
        assert_int_equal(far_count, 0);
        svo_tree_destroy(&tree);
    }
}

static void constant_payload_is_one_element(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    random_masks random = {.state = 23, .children = 3};
    svo_tree *tree = hand_tree(4, random_mask, &random, SVO_NEED_COLOR, 1);
    uint32_t *colors = tree->host[SVO_TREE_COLORS];
    for (uint64_t i = 0; i < svo_i_tree_payload_count(&tree->info); ++i) {
        colors[i] = 0xff00ff80;
    }
    tree->info.constant = SVO_NEED_COLOR;
    for (int form = 0; form < SVO_FORM_COUNT; ++form) {
        svo_compact *made = compact_of(&opened, tree, &(svo_compact_options){.form = (svo_form)form});
        const svo_compact_info info = info_of(made);
        assert_int_equal(info.bytes[SVO_COMPACT_COLORS], 4);
        assert_int_equal(info.bytes[SVO_COMPACT_BASES], 0);
        assert_memory_equal(arrays_of(made).colors, colors, 4);
        assert_expands(&opened, made, tree, SVO_HASH_ALL);
        svo_compact_destroy(&made);
    }
    svo_tree_destroy(&tree);
}

static void built_trees_come_back(void **state)
{
    static const char *const specs[] = {"cube", "knot:2000", "statue:3000"};
    const fixture opened = fixture_cl_of_group(state);
    for (size_t i = 0; i < sizeof specs / sizeof specs[0]; ++i) {
        scene *made_scene = fixture_scene(specs[i]);
        const svo_plan_options options = {.need = PAYLOAD | (i == 0 ? (uint32_t)SVO_NEED_RAYS : 0)};
        built tree;
        fixture_build(&opened, scene_mesh(made_scene), 6, &options, &tree);
        for (int form = 0; form < SVO_FORM_COUNT; ++form) {
            svo_compact *made = compact_of(&opened, tree.tree, &(svo_compact_options){.form = (svo_form)form});
            assert_expands(&opened, made, tree.tree, i == 0 ? SVO_HASH_NODES : SVO_HASH_ALL);
            svo_compact_destroy(&made);
        }
        built_destroy(&tree);
        scene_destroy(&made_scene);
    }
}

static void payload_is_left_out_on_request(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    random_masks random = {.state = 29, .children = 3};
    svo_tree *tree = hand_tree(4, random_mask, &random, PAYLOAD, 0);
    for (int form = 0; form < SVO_FORM_COUNT; ++form) {
        const svo_compact_options options = {.form = (svo_form)form,
                                             .leave_out = (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_FILL};
        svo_compact *made = compact_of(&opened, tree, &options);
        const svo_compact_arrays arrays = arrays_of(made);
        assert_null(arrays.colors);
        assert_null(arrays.fills);
        assert_non_null(arrays.normals);
        assert_non_null(arrays.materials);
        assert_int_equal(info_of(made).need, SVO_NEED_NORMAL | SVO_NEED_MATERIAL);
        assert_expands(&opened, made, tree, SVO_HASH_NODES);
        svo_compact_destroy(&made);
    }
    svo_tree_destroy(&tree);
}

static void host_and_device_give_the_same_bytes(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    random_masks random = {.state = 31, .children = 3};
    svo_tree *tree = hand_tree(5, random_mask, &random, PAYLOAD, 2);
    char hashes[2][SVO_FORM_COUNT][SVO_HASH_TEXT_BYTES];
    for (int uploaded = 0; uploaded < 2; ++uploaded) {
        for (int form = 0; form < SVO_FORM_COUNT; ++form) {
            svo_compact *made = compact_of(&opened, tree, &(svo_compact_options){.form = (svo_form)form});
            assert_int_equal(svo_compact_hash(made, hashes[uploaded][form]), SVO_OK);
            svo_compact_destroy(&made);
        }
        assert_int_equal(svo_tree_upload(tree, opened.device, opened.queue), SVO_OK);
    }
    assert_memory_equal(hashes[0], hashes[1], sizeof hashes[0]);
    assert_string_not_equal(hashes[0][0], hashes[0][1]);
    svo_tree_destroy(&tree);
}

/* ---- wrong calls ---- */

static void assert_refused(const fixture *opened, svo_status status, const char *words)
{
    assert_int_equal(status, SVO_INVALID_ARGUMENT);
    if (strstr(svo_device_message(opened->device), words) == NULL) {
        fail_msg("\"%s\" does not say \"%s\"", svo_device_message(opened->device), words);
    }
}

static void wrong_options_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_tree *tree = hand_tree(2, full_mask, NULL, 0, 0);
    svo_compact *made = NULL;
    svo_device *const device = opened.device;
    static const struct {
        svo_compact_options options;
        const char *words;
    } wrong[] = {{{.form = SVO_FORM_COUNT}, "options.form 4 is not in 0 .. 3"},
                 {{.form = (svo_form)-1}, "options.form -1 is not in 0 .. 3"},
                 {{.directory_step_log2 = 3}, "options.directory_step_log2 3 is not 0 and not in 4 .. 6"},
                 {{.directory_step_log2 = 7}, "options.directory_step_log2 7 is not 0 and not in 4 .. 6"},
                 {{.leave_out = 0x40}, "options.leave_out 0x40 has bits outside 0x3f"}};
    assert_int_equal(svo_tree_upload(tree, device, opened.queue), SVO_OK);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        svo_compact_options options = wrong[i].options;
        svo_compact_info info = SVO_COMPACT_INFO_INIT;
        options.struct_size = sizeof options;
        assert_refused(&opened, svo_compact_create(device, tree, &options, NULL, &made), wrong[i].words);
        assert_refused(&opened, svo_compact_plan(tree, &options, &info), wrong[i].words);
        assert_null(made);
    }
    svo_compact_options small = {.struct_size = 8};
    assert_refused(&opened, svo_compact_create(device, tree, &small, NULL, &made), "options.struct_size is 8");
    svo_tree_destroy(&tree);
}

static void wrong_arguments_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_device *const device = opened.device;
    svo_tree *tree = hand_tree(2, full_mask, NULL, 0, 0);
    svo_tree *empty = svo_i_tree_new(NULL);
    svo_tree *expanded = NULL;
    svo_compact *made = NULL;
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    svo_compact_arrays arrays = SVO_COMPACT_ARRAYS_INIT;
    char text[SVO_HASH_TEXT_BYTES];
    assert_int_equal(svo_compact_create(NULL, tree, NULL, NULL, &made), SVO_INVALID_ARGUMENT);
    assert_refused(&opened, svo_compact_create(device, NULL, NULL, NULL, &made), "tree is NULL");
    assert_refused(&opened, svo_compact_create(device, tree, NULL, NULL, NULL), "out is NULL");
    assert_refused(&opened, svo_compact_create(device, empty, NULL, NULL, &made),
                   "neither on the device nor on the host");
    assert_int_equal(svo_compact_plan(NULL, NULL, &info), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_compact_plan(tree, NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_compact_create(device, tree, NULL, NULL, &made), SVO_OK);
    assert_refused(&opened, svo_compact_hash(made, text), "call svo_compact_download first");
    assert_refused(&opened, svo_compact_hash(made, NULL), "text is NULL");
    assert_refused(&opened, svo_compact_expand(made, NULL, NULL), "out is NULL");
    assert_int_equal(svo_compact_expand(NULL, NULL, &expanded), SVO_INVALID_ARGUMENT);
    assert_refused(&opened,
                   svo_compact_upload(made, NULL, NULL) == SVO_INVALID_ARGUMENT ? svo_compact_upload(NULL, device, NULL)
                                                                                : SVO_OK,
                   "compact is NULL");
    assert_int_equal(svo_compact_download(NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_compact_get_info(NULL, &info), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_compact_get_info(made, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_compact_get_arrays(NULL, &arrays), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_compact_get_arrays(made, NULL), SVO_INVALID_ARGUMENT);
    info.struct_size = 8;
    assert_int_equal(svo_compact_get_info(made, &info), SVO_INVALID_ARGUMENT);
    assert_null(svo_compact_get_buffer(made, SVO_COMPACT_BUFFER_COUNT));
    assert_non_null(svo_compact_get_buffer(made, SVO_COMPACT_NODES));
    assert_string_equal(svo_name(SVO_NAME_FORM, SVO_FORM_COUNT), "unknown form");
    assert_string_equal(svo_name(SVO_NAME_COMPACT_BUFFER, SVO_COMPACT_BUFFER_COUNT), "unknown buffer");
    svo_compact_destroy(&made);
    svo_compact_destroy(&made);
    svo_compact_destroy(NULL);
    svo_tree_destroy(&empty);
    svo_tree_destroy(&tree);
}

TEST_GROUP(compact)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(full_trees_have_the_documented_bytes),
                                       cmocka_unit_test(half_trees_with_colors_have_the_documented_bytes),
                                       cmocka_unit_test(far_words_are_the_least_fixed_point),
                                       cmocka_unit_test(deep_thin_trees_match_the_reference),
                                       cmocka_unit_test(random_trees_match_the_reference),
                                       cmocka_unit_test(implied_masks_and_directories_match_the_tree),
                                       cmocka_unit_test(empty_trees_stay_empty),
                                       cmocka_unit_test(constant_payload_is_one_element),
                                       cmocka_unit_test(built_trees_come_back),
                                       cmocka_unit_test(payload_is_left_out_on_request),
                                       cmocka_unit_test(host_and_device_give_the_same_bytes),
                                       cmocka_unit_test(wrong_options_are_refused),
                                       cmocka_unit_test(wrong_arguments_are_refused)};
    return cmocka_run_group_tests_name("compact", tests, fixture_group_setup, fixture_group_teardown);
}
