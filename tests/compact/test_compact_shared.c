/* SPDX-License-Identifier: MIT */
/*
 * SVO_FORM_SHARED and SVO_FORM_MIRRORED (svocl/compact.h): the records of trees of all kinds against readers that are
 * written after the text of the header alone, the number of records against a map of subtrees as strings, places
 * against a depth-first walk, sizes against closed forms, and what expanding gives back.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "compact_reference.h"
#include "scenes.h"
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

/* A compact tree with its arrays on the host. */
typedef struct shared_tree {
    svo_compact *compact;
    svo_compact_info info;
    svo_compact_arrays arrays;
} shared_tree;

static void make_form(const fixture *opened, const svo_tree *tree, svo_form form, uint32_t leave_out, shared_tree *out)
{
    svo_compact_options options = SVO_COMPACT_OPTIONS_INIT;
    options.form = form;
    options.leave_out = leave_out;
    *out = (shared_tree){.info = SVO_COMPACT_INFO_INIT, .arrays = SVO_COMPACT_ARRAYS_INIT};
    succeed(opened, svo_compact_create(opened->device, tree, &options, opened->queue, &out->compact));
    succeed(opened, svo_compact_download(out->compact, opened->queue));
    succeed(opened, svo_compact_get_info(out->compact, &out->info));
    succeed(opened, svo_compact_get_arrays(out->compact, &out->arrays));
}

static void make_shared(const fixture *opened, const svo_tree *tree, uint32_t leave_out, shared_tree *out)
{
    make_form(opened, tree, SVO_FORM_SHARED, leave_out, out);
}

/* ---- voxels ---- */

/* Voxels of a tree whose nodes have masks from a table: node of level l has table[l % table_count]. */
static size_t add_pattern(voxel *voxels, const uint8_t *table, size_t table_count, unsigned depth)
{
    size_t count = 0;
    const uint32_t edge = 1u << depth;
    for (uint64_t code = 0; code < (uint64_t)edge * edge * edge; ++code) {
        int inside = 1;
        for (unsigned level = 0; level < depth; ++level) {
            inside &= table[level % table_count] >> (code >> 3 * (depth - 1 - level) & 7) & 1;
        }
        if (inside != 0) {
            svo_code_to_cell(code, voxels[count].cell);
            ++count;
        }
    }
    return count;
}

static void build_pattern(const fixture *opened, const uint8_t *table, size_t table_count, unsigned depth, built *out)
{
    voxel *voxels = calloc((size_t)1 << 3 * depth, sizeof *voxels);
    voxel_mesh made;
    assert_non_null(voxels);
    const size_t count = add_pattern(voxels, table, table_count, depth);
    voxel_mesh_make(voxels, count, depth, &made);
    made.options.need = SVO_NEED_NONE;
    fixture_build(opened, &made.mesh, depth, &made.options, out);
    assert_int_equal(out->info.leaf_count, count);
    voxel_mesh_free(&made);
    free(voxels);
}

/* Random voxels, some blocks of which are copies of each other, with random payload. */
static void build_random(const fixture *opened, uint64_t seed, unsigned depth, uint32_t need, uint32_t payload_level,
                         built *out)
{
    enum { VOXELS = 600 };
    static voxel voxels[2 * VOXELS];
    uint64_t random = seed;
    const uint32_t half = depth > 1 ? 1u << (depth - 1) : 1;
    for (size_t i = 0; i < VOXELS; ++i) {
        voxel *one = &voxels[i];
        for (unsigned axis = 0; axis < 3; ++axis) {
            one->cell[axis] = random_below(&random, half < 8 ? half : 8) + random_below(&random, 2) * (half / 2);
            one->normal[axis] = (float)random_unit(&random) - 0.5f;
        }
        for (unsigned channel = 0; channel < 4; ++channel) {
            one->rgba[channel] = (uint8_t)random_below(&random, 256);
        }
        one->material = (uint16_t)random_below(&random, VOXEL_MATERIALS);
        one->width = 0.1 + 0.8 * random_unit(&random);
        voxels[VOXELS + i] = *one;
        voxels[VOXELS + i].cell[seed % 3] += depth > 1 ? half : 1;
        voxels[VOXELS + i].rgba[1] ^= 0x55;
    }
    voxel_mesh made;
    voxel_mesh_make(voxels, sizeof voxels / sizeof voxels[0], depth, &made);
    made.options.need = need;
    made.options.payload_level = payload_level;
    fixture_build(opened, &made.mesh, depth, &made.options, out);
    voxel_mesh_free(&made);
}

/* ---- a reader after the text of the header ---- */

typedef struct reader {
    const built *tree;
    const shared_tree *shared;
    uint32_t next_place; /* of the depth-first walk */
    uint64_t visited;
} reader;

static unsigned bits_of(uint32_t word)
{
    unsigned count = 0;
    for (; word != 0; word &= word - 1) {
        ++count;
    }
    return count;
}

static const uint8_t *bytes_at(const uint32_t *words, uint32_t word)
{
    return (const uint8_t *)(words + word);
}

/* before[r] of a record; half words up to five levels above the voxels. */
static uint32_t number_at(const uint32_t *words, uint32_t record, uint32_t levels, uint32_t r)
{
    uint16_t half = 0;
    if (levels > 5) {
        return words[record + r];
    }
    memcpy(&half, bytes_at(words, record) + 2 * r, sizeof half);
    return half;
}

/* Payload of a node against that at its place. */
static void compare_payload(const reader *job, uint32_t node, uint32_t place)
{
    const svo_tree_info *info = &job->tree->info;
    const svo_tree_arrays *from = &job->tree->arrays;
    const svo_compact_arrays *to = &job->shared->arrays;
    const uint32_t varying = job->shared->info.need & ~job->shared->info.constant;
    const uint32_t at = node - info->level_begin[info->payload_level];
    if ((varying & SVO_NEED_COLOR) != 0) {
        assert_memory_equal(to->colors + 4 * (size_t)place, from->colors + 4 * (size_t)at, 4);
    }
    if ((varying & SVO_NEED_NORMAL) != 0) {
        assert_memory_equal(to->normals + 3 * (size_t)place, from->normals + 3 * (size_t)at, 6);
    }
    if ((varying & SVO_NEED_MATERIAL) != 0) {
        assert_int_equal(to->materials[place], from->materials[at]);
    }
    if ((varying & SVO_NEED_FILL) != 0) {
        assert_int_equal(to->fills[place], from->fills[at]);
    }
}

/* Compares the subtree of a node with what its record says, and its places with those of the walk. mask: the record of
   a node above voxels is its mask alone. place: as the walk over the records adds it up. */
static void compare_subtree(reader *job, uint32_t node, uint32_t level, uint32_t record, uint32_t place)
{
    const svo_tree_info *info = &job->tree->info;
    const uint32_t *words = job->shared->arrays.nodes;
    const uint32_t levels = info->depth - level;
    const int places = (job->shared->info.need & ~job->shared->info.constant) != 0;
    const int has_payload = level >= info->payload_level;
    ++job->visited;
    if (places && has_payload) {
        assert_int_equal(place, job->next_place);
        compare_payload(job, node, place);
        ++job->next_place;
    }
    if (levels == 0) {
        return;
    }
    const uint32_t mask = job->tree->arrays.child_mask[node];
    const uint32_t count = bits_of(mask);
    uint32_t child_place = place + (has_payload ? 1 : 0);
    if (levels == 1) {
        assert_int_equal(record, mask);
    } else {
        assert_in_range(record, 0, job->shared->info.stored_count - 1);
        assert_int_equal(bytes_at(words, record)[0], mask);
        assert_int_equal(bytes_at(words, record)[1], 0);
    }
    const uint32_t numbers = places && count > 0 ? count - 1 : 0;
    const uint32_t names = record + 1 + (levels > 5 ? numbers : numbers / 2);
    for (uint32_t r = 0; r < count; ++r) {
        const uint32_t child = job->tree->arrays.first_child[node] + r;
        if (levels == 1) {
            compare_subtree(job, child, level + 1, 0, child_place);
            child_place += 1;
        } else if (levels == 2) {
            const uint32_t child_mask = bytes_at(words, record)[2 + r];
            compare_subtree(job, child, level + 1, child_mask, child_place);
            child_place += bits_of(child_mask) + (level + 1 >= info->payload_level ? 1 : 0);
        } else {
            const uint32_t before = r > 0 && places ? number_at(words, record, levels, r) : 0;
            compare_subtree(job, child, level + 1, words[names + r], place + (has_payload ? 1 : 0) + before);
        }
    }
}

/* The same for the form "mirrored": the walk of compact_reference.h meets every node, each place once, and there the
   payload of its node. */
static void compare_half_words(const built *tree, const shared_tree *mirrored, mirrored_walk *walk)
{
    const reader job = {.tree = tree, .shared = mirrored};
    const int places = (mirrored->info.need & ~mirrored->info.constant) != 0;
    uint64_t placed = 0;
    uint64_t sum = 0;
    mirrored_walk_make(mirrored->compact, tree->tree, walk);
    assert_int_equal(walk->visited, tree->info.node_count);
    for (uint32_t node = 0; places && node < tree->info.node_count; ++node) {
        if (walk->places[node] != SVO_NO_NODE) {
            compare_payload(&job, node, walk->places[node]);
            sum += walk->places[node];
            ++placed;
        }
    }
    assert_int_equal(placed, mirrored->info.payload_count * (places ? 1 : 0));
    assert_int_equal(sum, placed > 0 ? placed * (placed - 1) / 2 : 0);
}

static void compare_records(const built *tree, const shared_tree *shared)
{
    reader job = {.tree = tree, .shared = shared};
    const uint32_t *words = shared->arrays.nodes;
    compare_subtree(&job, 0, 0, tree->info.depth == 1 ? words[0] & 255 : 0, 0);
    assert_int_equal(job.visited, tree->info.node_count);
    if ((shared->info.need & ~shared->info.constant) != 0) {
        assert_int_equal(job.next_place, shared->info.payload_count);
    }
}

/* ---- a map of subtrees ---- */

/* A subtree as its child masks in depth-first order, reflected or not. */
typedef struct subtree_text {
    uint8_t *masks;
    size_t length;
} subtree_text;

static void append_subtree(const built *tree, uint32_t node, uint32_t levels, uint32_t mirror, subtree_text *text)
{
    const uint32_t mask = tree->arrays.child_mask[node];
    uint8_t *own = &text->masks[text->length];
    *own = 0;
    ++text->length;
    for (uint32_t octant = 0; octant < 8; ++octant) {
        const uint32_t from = octant ^ mirror;
        if ((mask >> from & 1) != 0) {
            *own |= (uint8_t)(1u << octant);
            if (levels > 1) {
                const uint32_t child = tree->arrays.first_child[node] + bits_of(mask & ((1u << from) - 1));
                append_subtree(tree, child, levels - 1, mirror, text);
            }
        }
    }
}

static int compare_texts(const void *a, const void *b)
{
    const subtree_text *x = a;
    const subtree_text *y = b;
    const int order = memcmp(x->masks, y->masks, x->length < y->length ? x->length : y->length);
    return order != 0 ? order : x->length < y->length ? -1 : x->length > y->length ? 1 : 0;
}

/* Appends the least of a node's reflections; of none but itself without mirrors. */
static void append_least(const built *tree, uint32_t node, uint32_t levels, int mirrors, subtree_text *text)
{
    append_subtree(tree, node, levels, 0, text);
    for (uint32_t mirror = 1; mirror < 8 && mirrors; ++mirror) {
        subtree_text other = {malloc(text->length), 0};
        assert_non_null(other.masks);
        append_subtree(tree, node, levels, mirror, &other);
        assert_int_equal(other.length, text->length);
        if (memcmp(other.masks, text->masks, text->length) < 0) {
            memcpy(text->masks, other.masks, text->length);
        }
        free(other.masks);
    }
}

/* The different subtrees of the nodes with two and more levels below them, and the root. mirrors: reflections are the
   same. */
static uint64_t count_subtrees(const built *tree, int mirrors)
{
    const svo_tree_info *info = &tree->info;
    uint64_t different = 0;
    for (uint32_t level = 0; level + 2 <= info->depth || level == 0; ++level) {
        const uint32_t count = info->level_begin[level + 1] - info->level_begin[level];
        subtree_text *texts = calloc(count, sizeof *texts);
        uint8_t *all = malloc(info->inner_count * (size_t)1);
        size_t used = 0;
        assert_non_null(texts);
        assert_non_null(all);
        for (uint32_t i = 0; i < count; ++i) {
            texts[i].masks = all + used;
            append_least(tree, info->level_begin[level] + i, info->depth - level, mirrors, &texts[i]);
            used += texts[i].length;
        }
        assert_in_range(used, 0, info->inner_count);
        qsort(texts, count, sizeof *texts, compare_texts);
        for (uint32_t i = 0; i < count; ++i) {
            different += i == 0 || compare_texts(&texts[i], &texts[i - 1]) != 0 ? 1 : 0;
        }
        free(texts);
        free(all);
    }
    return different;
}

/* ---- tests ---- */

static void compare_expanded(const fixture *opened, const built *tree, shared_tree *shared, svo_hash_scope scope)
{
    svo_tree *expanded = NULL;
    char hash[SVO_HASH_TEXT_BYTES];
    succeed(opened, svo_compact_expand(shared->compact, opened->queue, &expanded));
    succeed(opened, svo_tree_download(expanded, opened->queue));
    succeed(opened, svo_tree_hash(expanded, scope, hash));
    assert_string_equal(hash, scope == SVO_HASH_ALL ? tree->hash : tree->nodes_hash);
    svo_tree_destroy(&expanded);
}

/* Records, places, payload and the way back of one tree. */
static void check_tree(const fixture *opened, const built *tree, svo_hash_scope scope)
{
    shared_tree shared;
    mirrored_walk walk;
    make_shared(opened, tree->tree, 0, &shared);
    assert_int_equal(shared.info.shared_count, count_subtrees(tree, 0));
    compare_records(tree, &shared);
    compare_expanded(opened, tree, &shared, scope);
    svo_compact_destroy(&shared.compact);
    make_form(opened, tree->tree, SVO_FORM_MIRRORED, 0, &shared);
    assert_int_equal(shared.info.shared_count, count_subtrees(tree, 1));
    compare_half_words(tree, &shared, &walk);
    compare_expanded(opened, tree, &shared, scope);
    svo_compact_destroy(&shared.compact);
    mirrored_walk_free(&walk);
}

static void random_trees_are_shared_and_expanded(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const uint32_t all = SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_MATERIAL | SVO_NEED_FILL;
    const uint32_t needs[] = {SVO_NEED_NONE, SVO_NEED_COLOR, SVO_NEED_NORMAL, SVO_NEED_MATERIAL | SVO_NEED_FILL, all};
    for (unsigned depth = 1; depth <= 8; ++depth) {
        for (unsigned turn = 0; turn < 3; ++turn) {
            const uint32_t payload_level = turn == 0 ? 0 : turn == 1 ? depth : depth / 2;
            built tree;
            build_random(&opened, 31 * depth + turn, depth, needs[(depth + turn) % 5], payload_level, &tree);
            check_tree(&opened, &tree, SVO_HASH_ALL);
            built_destroy(&tree);
        }
    }
}

/* Above five levels numbers have 32 bits: a node with six levels below needs more than 16. */
static void long_numbers_are_used_where_needed(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    scene *made = fixture_scene("knot:3000");
    const svo_plan_options options = {.need = SVO_NEED_COLOR | SVO_NEED_NORMAL};
    built tree;
    fixture_build(&opened, scene_mesh(made), 8, &options, &tree);
    assert_true(tree.info.leaf_count > 65536);
    check_tree(&opened, &tree, SVO_HASH_ALL);
    built_destroy(&tree);
    scene_destroy(&made);
}

/* Records beyond the reach of a half word are used less often than those within it. */
static void long_references_are_rare(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    scene *made = fixture_scene("statue:3000");
    const svo_plan_options options = {.need = SVO_NEED_NONE};
    built tree;
    shared_tree shared;
    shared_tree mirrored;
    mirrored_walk walk;
    fixture_build(&opened, scene_mesh(made), 8, &options, &tree);
    make_shared(&opened, tree.tree, 0, &shared);
    make_form(&opened, tree.tree, SVO_FORM_MIRRORED, 0, &mirrored);
    compare_half_words(&tree, &mirrored, &walk);
    assert_in_range(walk.long_references, 1, tree.info.inner_count / 4);
    assert_in_range(walk.reflected, tree.info.inner_count / 16, tree.info.inner_count);
    assert_in_range(mirrored.info.total_bytes, 1, shared.info.total_bytes * 4 / 5);
    assert_true(mirrored.info.shared_count < shared.info.shared_count);
    compare_expanded(&opened, &tree, &mirrored, SVO_HASH_ALL);
    mirrored_walk_free(&walk);
    svo_compact_destroy(&shared.compact);
    svo_compact_destroy(&mirrored.compact);
    built_destroy(&tree);
    scene_destroy(&made);
}

/* Every node of a level is equal: a record per level, of 3 words above voxels, and of 1 + m words elsewhere. */
static void self_similar_trees_have_a_record_per_level(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const struct {
        uint8_t table[3];
        size_t table_count;
    } patterns[] = {{{0xff}, 1}, {{0x69}, 1}, {{0x7e}, 1}, {{0xff, 0x96, 0x01}, 3}};
    for (size_t i = 0; i < sizeof patterns / sizeof patterns[0]; ++i) {
        for (unsigned depth = 1; depth <= 5; ++depth) {
            built tree;
            shared_tree shared;
            uint64_t words = 0;
            uint64_t halves = 0;
            build_pattern(&opened, patterns[i].table, patterns[i].table_count, depth, &tree);
            make_shared(&opened, tree.tree, 0, &shared);
            for (unsigned level = 0; level + 1 < depth; ++level) {
                const unsigned children = bits_of(patterns[i].table[level % patterns[i].table_count]);
                words += level + 2 == depth ? (2 + children + 3) / 4 : 1 + children;
                halves += level + 2 == depth ? (2 + children) / 2 : 1 + children;
            }
            assert_int_equal(shared.info.shared_count, depth > 1 ? depth - 1 : 1);
            assert_int_equal(shared.info.stored_count, depth > 1 ? words : 1);
            assert_int_equal(shared.info.bytes[SVO_COMPACT_NODES], 4 * shared.info.stored_count);
            compare_records(&tree, &shared);
            compare_expanded(&opened, &tree, &shared, SVO_HASH_ALL);
            svo_compact_destroy(&shared.compact);
            make_form(&opened, tree.tree, SVO_FORM_MIRRORED, 0, &shared);
            assert_int_equal(shared.info.shared_count, depth > 1 ? depth - 1 : 1);
            assert_int_equal(shared.info.stored_count, depth > 1 ? (halves + 1) / 2 : 1);
            compare_expanded(&opened, &tree, &shared, SVO_HASH_ALL);
            svo_compact_destroy(&shared.compact);
            built_destroy(&tree);
        }
    }
}

/* The surface of a cube that fills the grid: below the root a node is one of eight corners, twelve edges, six faces, as
   far as the level has them; up to reflections a corner, three edges, three faces. */
static void a_cube_surface_has_26_records_per_level(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (unsigned depth = 2; depth <= 6; ++depth) {
        const uint32_t edge = 1u << depth;
        voxel *voxels = calloc((size_t)6 * edge * edge, sizeof *voxels);
        size_t count = 0;
        assert_non_null(voxels);
        for (uint32_t z = 0; z < edge; ++z) {
            for (uint32_t y = 0; y < edge; ++y) {
                for (uint32_t x = 0; x < edge; ++x) {
                    const uint32_t least = x < y ? (x < z ? x : z) : y < z ? y : z;
                    const uint32_t most = x > y ? (x > z ? x : z) : y > z ? y : z;
                    if (least == 0 || most == edge - 1) {
                        voxels[count] = (voxel){.cell = {x, y, z}};
                        ++count;
                    }
                }
            }
        }
        voxel_mesh made;
        built tree;
        shared_tree shared;
        voxel_mesh_make(voxels, count, depth, &made);
        made.options.need = SVO_NEED_NONE;
        fixture_build(&opened, &made.mesh, depth, &made.options, &tree);
        make_shared(&opened, tree.tree, 0, &shared);
        /* The root; on level 1 corners alone; from level 2 on all 26 kinds. */
        assert_int_equal(shared.info.shared_count, 1u + (depth > 2 ? 8u : 0u) + (depth > 3 ? 26 * (depth - 3) : 0u));
        assert_int_equal(shared.info.shared_count, count_subtrees(&tree, 0));
        compare_expanded(&opened, &tree, &shared, SVO_HASH_ALL);
        svo_compact_destroy(&shared.compact);
        make_form(&opened, tree.tree, SVO_FORM_MIRRORED, 0, &shared);
        assert_int_equal(shared.info.shared_count, 1u + (depth > 2 ? 1u : 0u) + (depth > 3 ? 7 * (depth - 3) : 0u));
        compare_expanded(&opened, &tree, &shared, SVO_HASH_ALL);
        svo_compact_destroy(&shared.compact);
        built_destroy(&tree);
        voxel_mesh_free(&made);
        free(voxels);
    }
}

static void a_tree_without_leaves_is_one_record(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (unsigned depth = 1; depth <= 4; ++depth) {
        const svo_mesh nothing = SVO_MESH_INIT;
        const svo_plan_options options = {.need = SVO_NEED_NONE, .edge = 1};
        built tree;
        shared_tree shared;
        fixture_build(&opened, &nothing, depth, &options, &tree);
        for (svo_form form = SVO_FORM_SHARED; form <= SVO_FORM_MIRRORED; ++form) {
            make_form(&opened, tree.tree, form, 0, &shared);
            assert_int_equal(shared.info.stored_count, 1);
            assert_int_equal(*(const uint32_t *)shared.arrays.nodes, 0);
            compare_expanded(&opened, &tree, &shared, SVO_HASH_ALL);
            svo_compact_destroy(&shared.compact);
        }
        built_destroy(&tree);
    }
}

/* Occupancy alone decides: colors that differ cost no record, and without payload there are no numbers. */
static void payload_does_not_split_records(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    built tree;
    shared_tree with;
    shared_tree without;
    build_random(&opened, 5, 6, SVO_NEED_COLOR, 0, &tree);
    make_shared(&opened, tree.tree, 0, &with);
    make_shared(&opened, tree.tree, SVO_NEED_COLOR, &without);
    assert_int_equal(with.info.shared_count, without.info.shared_count);
    assert_true(with.info.stored_count > without.info.stored_count);
    assert_int_equal(without.info.need, 0);
    compare_records(&tree, &without);
    compare_expanded(&opened, &tree, &without, SVO_HASH_NODES);
    svo_compact_destroy(&with.compact);
    svo_compact_destroy(&without.compact);
    built_destroy(&tree);
}

/* The plan's sizes are upper bounds, and marked as such. */
static void a_plan_bounds_what_is_made(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (unsigned turn = 2; turn < 16; ++turn) {
        const unsigned depth = turn / 2;
        built tree;
        shared_tree shared;
        svo_compact_options options = SVO_COMPACT_OPTIONS_INIT;
        svo_compact_info planned = SVO_COMPACT_INFO_INIT;
        build_random(&opened, depth, depth, SVO_NEED_COLOR, 0, &tree);
        options.form = turn % 2 == 0 ? SVO_FORM_SHARED : SVO_FORM_MIRRORED;
        make_form(&opened, tree.tree, options.form, 0, &shared);
        succeed(&opened, svo_compact_plan(tree.tree, &options, &planned));
        assert_int_equal(planned.bounds, 1u << SVO_COMPACT_NODES);
        for (int i = 0; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
            if (i == SVO_COMPACT_NODES) {
                assert_in_range(shared.info.bytes[i], 1, planned.bytes[i]);
            } else {
                assert_int_equal(shared.info.bytes[i], planned.bytes[i]);
            }
        }
        svo_compact_destroy(&shared.compact);
        built_destroy(&tree);
    }
}

TEST_GROUP(compact_shared)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_trees_are_shared_and_expanded),
        cmocka_unit_test(long_numbers_are_used_where_needed),
        cmocka_unit_test(long_references_are_rare),
        cmocka_unit_test(self_similar_trees_have_a_record_per_level),
        cmocka_unit_test(a_cube_surface_has_26_records_per_level),
        cmocka_unit_test(a_tree_without_leaves_is_one_record),
        cmocka_unit_test(payload_does_not_split_records),
        cmocka_unit_test(a_plan_bounds_what_is_made),
    };
    return cmocka_run_group_tests_name("compact_shared", tests, fixture_group_setup, fixture_group_teardown);
}
