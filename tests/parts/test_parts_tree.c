/* SPDX-License-Identifier: MIT */
/*
 * A folder of parts as a tree: counts, hashes, files, levels and regions are those of the stitched tree, also where
 * there are more nodes than numbers. Damaged, missing, foreign and changed parts are refused by name.
 */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "parts/tree.h"
#include "shared/nodes.clh"
#include "support/attributed_mesh.h"
#include "support/fixture_folder.h"
#include "support/suite.h"
#include "svocl/io.h"
#include "svocl/parts.h"
#include "svocl/parts_tree.h"

#define PATH_BYTES 256
#define LIMIT      400000 /* so that there are dozens of parts */

/* A folder whose parts are built, the tree that it is, and the same tree stitched. */
typedef struct deep_folder {
    svo_device *device;
    svo_parts *parts;
    svo_parts_tree *tree;
    svo_tree *whole;
    char folder[PATH_BYTES], file[PATH_BYTES];
} deep_folder;

static void name_of(const char *name, char path[PATH_BYTES])
{
    (void)snprintf(path, PATH_BYTES, "%s", path_of(name));
}

static void check(svo_status status, const svo_message *message)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), message->text);
    }
}

static void build_parts(const deep_folder *f)
{
    svo_message message;
    for (size_t i = 0; i < svo_parts_count(f->parts); ++i) {
        check(svo_parts_build(f->parts, i, f->device, NULL, NULL, &message), &message);
    }
}

static void make_folder(void **state, deep_folder *f, const char *name, const svo_mesh *mesh, unsigned depth,
                        const svo_plan_options *options)
{
    svo_message message;
    *f = (deep_folder){.device = fixture_cl_of_group(state).device};
    name_of(name, f->folder);
    (void)snprintf(f->file, sizeof f->file, "%.*s", (int)(strlen(f->folder) - strlen(".parts")), f->folder);
    check(svo_parts_create(f->device, mesh, depth, options, LIMIT, f->folder, &message), &message);
    check(svo_parts_open(f->folder, &f->parts, &message), &message);
    build_parts(f);
    check(svo_parts_finish(f->parts, f->file, &message), &message);
    check(svo_tree_load(svo_from_path(f->file), NULL, &f->whole, &message), &message);
    check(svo_parts_tree_open(f->folder, &f->tree, &message), &message);
}

static void end_folder(deep_folder *f)
{
    svo_message message;
    svo_parts_tree_close(&f->tree);
    svo_parts_close(&f->parts);
    svo_tree_destroy(&f->whole);
    check(svo_parts_remove(f->folder, &message), &message);
    assert_int_equal(unlink(f->file), 0);
}

static void make_attributed(void **state, deep_folder *f, const char *name, uint32_t need)
{
    attributed_mesh made;
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    attributed_mesh_create(7, 60, 0.0, &made);
    options.need = need;
    options.edge = 1.0;
    make_folder(state, f, name, &made.mesh, 6, &options);
    attributed_mesh_destroy(&made);
    assert_true(svo_parts_count(f->parts) > 2);
}

static svo_tree_info info_of(const svo_tree *tree)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    assert_int_equal(svo_tree_get_info(tree, &info), SVO_OK);
    return info;
}

static void assert_same_hash(const svo_tree *a, const svo_tree *b)
{
    char first[SVO_HASH_TEXT_BYTES], second[SVO_HASH_TEXT_BYTES];
    assert_int_equal(svo_tree_hash(a, SVO_HASH_ALL, first), SVO_OK);
    assert_int_equal(svo_tree_hash(b, SVO_HASH_ALL, second), SVO_OK);
    assert_string_equal(first, second);
}

static void assert_same_files(const char *a, const char *b)
{
    char line[2 * PATH_BYTES + 16];
    (void)snprintf(line, sizeof line, "cmp '%s' '%s'", a, b);
    assert_int_equal(system(line), 0);
}

/* ---- the whole tree ---- */

static void compare_counts(const deep_folder *f)
{
    svo_parts_tree_info info = SVO_PARTS_TREE_INFO_INIT;
    svo_message message;
    const svo_tree_info whole = info_of(f->whole);
    check(svo_parts_tree_get_info(f->tree, &info, &message), &message);
    assert_int_equal(info.node_count, whole.node_count);
    assert_int_equal(info.inner_count, whole.inner_count);
    assert_int_equal(info.leaf_count, whole.leaf_count);
    assert_int_equal(info.list_count, whole.list_count);
    assert_int_equal(info.tree.fragments, whole.fragments);
    assert_int_equal(info.tree.depth, whole.depth);
    assert_int_equal(info.tree.need, whole.need);
    assert_int_equal(info.last_level, whole.depth);
    for (uint32_t level = 0; level <= whole.depth; ++level) {
        assert_int_equal(info.level_nodes[level], whole.level_begin[level + 1] - whole.level_begin[level]);
    }
}

static void compare_whole(const deep_folder *f)
{
    static const svo_hash_scope scopes[] = {SVO_HASH_ALL, SVO_HASH_NODES};
    svo_message message;
    svo_tree *loaded = NULL;
    svo_tree_info info = SVO_TREE_INFO_INIT;
    char saved[PATH_BYTES];
    compare_counts(f);
    for (size_t i = 0; i < 2; ++i) {
        char own[SVO_HASH_TEXT_BYTES], stitched[SVO_HASH_TEXT_BYTES];
        check(svo_parts_tree_hash(f->tree, scopes[i], own, &message), &message);
        assert_int_equal(svo_tree_hash(f->whole, scopes[i], stitched), SVO_OK);
        assert_string_equal(own, stitched);
    }
    work_folder_remember("saved.svo");
    name_of("saved.svo", saved);
    check(svo_parts_tree_save(f->tree, NULL, svo_to_path(saved), &info, &message), &message);
    assert_same_files(f->file, saved);
    assert_int_equal(info.node_count, info_of(f->whole).node_count);
    check(svo_parts_tree_load(f->tree, NULL, &loaded, &message), &message);
    assert_same_hash(f->whole, loaded);
    svo_tree_destroy(&loaded);
}

/* Every array, as payload of each node and as one element for all. */
static void test_whole_tree(void **state)
{
    deep_folder f;
    owned_mesh plain;
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    make_attributed(state, &f, "all.svo.parts", (uint32_t)SVO_NEED_ALL);
    compare_whole(&f);
    end_folder(&f);
    random_mesh(11, 40, 0.0, &plain);
    options.need = (uint32_t)SVO_NEED_ALL;
    options.edge = 1.0;
    options.payload_level = 2;
    make_folder(state, &f, "plain.svo.parts", &plain.mesh, 6, &options);
    assert_true(info_of(f.whole).constant != 0);
    compare_whole(&f);
    end_folder(&f);
    owned_mesh_free(&plain);
}

static void test_no_parts(void **state)
{
    const float far[9] = {5, 5, 5, 6, 5, 5, 5, 6, 5};
    svo_mesh mesh = SVO_MESH_INIT;
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    svo_parts_region region = SVO_PARTS_REGION_INIT;
    svo_message message;
    svo_tree *none = NULL;
    deep_folder f;
    mesh.positions = far;
    mesh.vertex_count = 3;
    mesh.triangle_count = 1;
    options.need = (uint32_t)SVO_NEED_ALL;
    options.edge = 1.0;
    make_folder(state, &f, "none.svo.parts", &mesh, 3, &options);
    compare_whole(&f);
    region.level = 1;
    assert_int_equal(svo_parts_tree_load(f.tree, &region, &none, &message), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(message.text, "has no node there"));
    end_folder(&f);
}

/* ---- levels and regions ---- */

static void test_levels(void **state)
{
    deep_folder f;
    svo_message message;
    char cut[PATH_BYTES], saved[PATH_BYTES];
    make_attributed(state, &f, "levels.svo.parts", (uint32_t)SVO_NEED_ALL);
    work_folder_remember("cut.svo");
    name_of("cut.svo", cut);
    work_folder_remember("saved.svo");
    name_of("saved.svo", saved);
    for (uint32_t level = 1; level < info_of(f.whole).depth; ++level) {
        const svo_load_options options = {.struct_size = sizeof options, .last_level = level};
        svo_parts_region region = SVO_PARTS_REGION_INIT;
        svo_tree *expected = NULL, *loaded = NULL;
        region.last_level = level;
        check(svo_tree_load(svo_from_path(f.file), &options, &expected, &message), &message);
        check(svo_tree_save(expected, svo_to_path(cut), NULL, &message), &message);
        check(svo_parts_tree_save(f.tree, &region, svo_to_path(saved), NULL, &message), &message);
        assert_same_files(cut, saved);
        check(svo_parts_tree_load(f.tree, &region, &loaded, &message), &message);
        assert_same_hash(expected, loaded);
        svo_tree_destroy(&expected);
        svo_tree_destroy(&loaded);
    }
    end_folder(&f);
}

/* What lies under a node of the whole tree, level after level, must be the region's nodes. */
static void compare_region(const svo_tree *whole, uint32_t level, uint64_t node, const svo_tree *part)
{
    svo_tree_arrays all = SVO_TREE_ARRAYS_INIT, own = SVO_TREE_ARRAYS_INIT;
    const svo_tree_info info = info_of(whole), own_info = info_of(part);
    assert_int_equal(svo_tree_get_arrays(whole, &all), SVO_OK);
    assert_int_equal(svo_tree_get_arrays(part, &own), SVO_OK);
    assert_int_equal(own_info.depth, info.depth - level);
    assert_int_equal(own_info.need, (uint32_t)SVO_NEED_ALL & info.need & SVO_I_PAYLOAD_NEEDS);
    uint64_t first = node, count = 1;
    for (uint32_t k = 0; k <= own_info.depth; ++k) {
        const uint64_t at = own_info.level_begin[k];
        assert_int_equal(own_info.level_begin[k + 1] - at, count);
        assert_memory_equal(own.colors + 4 * at, all.colors + 4 * first, 4 * count);
        assert_memory_equal(own.normals + 3 * at, all.normals + 3 * first, 6 * count);
        assert_memory_equal(own.materials + at, all.materials + first, 2 * count);
        assert_memory_equal(own.fills + at, all.fills + first, 2 * count);
        if (k < own_info.depth) {
            assert_memory_equal(own.child_mask + at, all.child_mask + first, count);
            const uint64_t last = first + count - 1;
            const uint64_t next = all.first_child[first];
            count = all.first_child[last] + svo_count_bits(all.child_mask[last]) - next;
            first = next;
        }
    }
}

/* Regions above the parts, at them, and inside: every node of four levels. Each has its place in the grid. */
static void test_regions(void **state)
{
    deep_folder f;
    svo_message message;
    make_attributed(state, &f, "regions.svo.parts", (uint32_t)SVO_NEED_ALL);
    const svo_tree_info whole = info_of(f.whole);
    for (uint32_t level = 1; level <= 4; ++level) {
        uint64_t leaves = 0;
        uint64_t node = whole.level_begin[level];
        for (uint64_t code = 0; code >> 3 * level == 0; ++code) {
            svo_parts_region region = SVO_PARTS_REGION_INIT;
            svo_tree *part = NULL;
            region.level = level;
            region.code = code;
            const svo_status status = svo_parts_tree_load(f.tree, &region, &part, &message);
            if (status == SVO_INVALID_ARGUMENT && strstr(message.text, "no node there") != NULL) {
                continue;
            }
            check(status, &message);
            const svo_tree_info info = info_of(part);
            uint32_t cell[3];
            svo_deinterleave(code, cell);
            assert_true(info.edge == whole.edge / (double)(1u << level));
            for (int axis = 0; axis < 3; ++axis) {
                assert_true(info.origin[axis] == whole.origin[axis] + cell[axis] * info.edge);
            }
            if (level < 4 || node % 16 == 0) {
                compare_region(f.whole, level, node, part);
            }
            ++node;
            leaves += info.leaf_count;
            svo_tree_destroy(&part);
        }
        assert_int_equal(node, whole.level_begin[level + 1]);
        assert_int_equal(leaves, whole.leaf_count);
    }
    end_folder(&f);
}

/* ---- more nodes than a file can have ---- */

/* The hash of the whole tree with numbers of 64 bits, from its arrays. */
static void hash_wide(const svo_tree *tree, char text[SVO_HASH_TEXT_BYTES])
{
    const svo_tree_info info = info_of(tree);
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    XXH3_state_t *state = XXH3_createState();
    const uint32_t words[3] = {info.depth, info.coverage, 0};
    uint64_t bytes = info.inner_count;
    assert_int_equal(svo_tree_get_arrays(tree, &arrays), SVO_OK);
    XXH3_128bits_reset(state);
    XXH3_128bits_update(state, words, sizeof words);
    XXH3_128bits_update(state, info.origin, sizeof info.origin);
    XXH3_128bits_update(state, &info.edge, sizeof info.edge);
    for (uint32_t i = 0; i < info.depth + 2; ++i) {
        const uint64_t wide = info.level_begin[i];
        XXH3_128bits_update(state, &wide, sizeof wide);
    }
    XXH3_128bits_update(state, &bytes, sizeof bytes);
    XXH3_128bits_update(state, arrays.child_mask, info.inner_count);
    bytes = 8 * info.inner_count;
    XXH3_128bits_update(state, &bytes, sizeof bytes);
    for (uint64_t i = 0; i < info.inner_count; ++i) {
        const uint64_t wide = arrays.first_child[i];
        XXH3_128bits_update(state, &wide, sizeof wide);
    }
    const XXH128_hash_t hash = XXH3_128bits_digest(state);
    (void)snprintf(text, SVO_HASH_TEXT_BYTES, "%016llx%016llx", (unsigned long long)hash.high64,
                   (unsigned long long)hash.low64);
    XXH3_freeState(state);
}

/* With fewer numbers to tell nodes apart: the whole is refused, and by which level it is not. */
static void test_more_than_numbers(void **state)
{
    deep_folder f;
    svo_message message;
    svo_tree *loaded = NULL;
    svo_parts_tree_info info = SVO_PARTS_TREE_INFO_INIT;
    svo_parts_region region = SVO_PARTS_REGION_INIT;
    char own[SVO_HASH_TEXT_BYTES], wide[SVO_HASH_TEXT_BYTES];
    make_attributed(state, &f, "many.svo.parts", (uint32_t)SVO_NEED_ALL);
    const svo_tree_info whole = info_of(f.whole);
    f.tree->nodes_max = whole.level_begin[whole.depth] + 1;
    check(svo_parts_tree_get_info(f.tree, &info, &message), &message);
    assert_int_equal(info.last_level, whole.depth - 1);
    assert_int_equal(info.node_count, whole.node_count);
    assert_int_equal(svo_parts_tree_load(f.tree, NULL, &loaded, &message), SVO_CAPACITY_EXCEEDED);
    region.last_level = whole.depth;
    assert_int_equal(svo_parts_tree_save(f.tree, &region, svo_to_path(f.file), NULL, &message), SVO_CAPACITY_EXCEEDED);
    assert_non_null(strstr(message.text, "down to level 5 is possible"));
    region.last_level = info.last_level;
    check(svo_parts_tree_load(f.tree, &region, &loaded, &message), &message);
    assert_int_equal(info_of(loaded).node_count, whole.level_begin[whole.depth]);
    svo_tree_destroy(&loaded);
    check(svo_parts_tree_hash(f.tree, SVO_HASH_NODES, own, &message), &message);
    hash_wide(f.whole, wide);
    assert_string_equal(own, wide);
    end_folder(&f);
}

/* ---- deeper than a file can be ---- */

#define DEEP_LEVELS 6 /* of a region */

/* A folder of the whole grid, in which the mesh's unit cube begins so many edges of regions from the corner, and parts
   are built of. */
static void make_deep(void **state, deep_folder *f, const svo_mesh *mesh, unsigned depth, double place,
                      svo_plan_options *options)
{
    svo_message message;
    *f = (deep_folder){.device = fixture_cl_of_group(state).device};
    name_of("deep.svo.parts", f->folder);
    options->edge = ldexp(1.0, (int)depth - DEEP_LEVELS);
    for (int axis = 0; axis < 3; ++axis) {
        options->origin[axis] = -place;
    }
    check(svo_parts_create(f->device, mesh, depth, options, LIMIT, f->folder, &message), &message);
    check(svo_parts_open(f->folder, &f->parts, &message), &message);
    build_parts(f);
    check(svo_parts_tree_open(f->folder, &f->tree, &message), &message);
}

/* The region of a cell must be the tree that is built on the cell's grid, which starts at origin. */
static void compare_with_build(deep_folder *f, const svo_mesh *mesh, const uint32_t cell[3], const double origin[3],
                               const svo_plan_options *whole, svo_hash_scope scope)
{
    svo_message message;
    svo_plan *plan = NULL;
    svo_tree *alone = NULL, *region_tree = NULL;
    svo_parts_tree_info info = SVO_PARTS_TREE_INFO_INIT;
    svo_parts_region region = SVO_PARTS_REGION_INIT;
    svo_plan_options options = *whole;
    char own[SVO_HASH_TEXT_BYTES], expected[SVO_HASH_TEXT_BYTES];
    options.edge = 1.0;
    memcpy(options.origin, origin, sizeof options.origin);
    assert_int_equal(svo_plan_create(f->device, mesh, DEEP_LEVELS, &options, &plan), SVO_OK);
    assert_int_equal(svo_build(plan, NULL, NULL, &alone, NULL), SVO_OK);
    assert_int_equal(svo_tree_download(alone, NULL), SVO_OK);
    check(svo_parts_tree_get_info(f->tree, &info, &message), &message);
    region.level = info.tree.depth - DEEP_LEVELS;
    region.code = svo_interleave(cell);
    check(svo_parts_tree_load(f->tree, &region, &region_tree, &message), &message);
    assert_int_equal(svo_tree_hash(region_tree, scope, own), SVO_OK);
    assert_int_equal(svo_tree_hash(alone, scope, expected), SVO_OK);
    assert_string_equal(own, expected);
    assert_true(info_of(alone).leaf_count > 100);
    svo_tree_destroy(&region_tree);
    svo_tree_destroy(&alone);
    svo_plan_destroy(&plan);
}

static void end_deep(deep_folder *f)
{
    svo_message message;
    svo_parts_tree_close(&f->tree);
    svo_parts_close(&f->parts);
    check(svo_parts_remove(f->folder, &message), &message);
}

/* Below a node far from the origin lies what a build on that node's grid makes, payload too, by whoever plans. */
static void test_far_regions(void **state)
{
    static const svo_coverage coverages[] = {SVO_COVERAGE_HALF_OPEN, SVO_COVERAGE_CLOSED, SVO_COVERAGE_THIN};
    static const svo_place places[] = {SVO_PLACE_HOST, SVO_PLACE_DEVICE, SVO_PLACE_HOST};
    static const unsigned depths[] = {17, 19, SVO_PARTS_DEPTH_MAX};
    static const double corner[3] = {0};
    attributed_mesh made;
    attributed_mesh_create(7, 60, 0.0, &made);
    for (size_t i = 0; i < 3; ++i) {
        deep_folder f;
        svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
        const uint32_t last = (1u << (depths[i] - DEEP_LEVELS)) - 1u;
        const uint32_t cell[3] = {last, last, last};
        options.coverage = coverages[i];
        options.need = (uint32_t)SVO_NEED_ALL & ~(uint32_t)(SVO_NEED_RAYS | SVO_NEED_PROJECTED_AREA);
        options.place = places[i];
        make_deep(state, &f, &made.mesh, depths[i], last, &options);
        options.place = SVO_PLACE_DEFAULT;
        compare_with_build(&f, &made.mesh, cell, corner, &options, SVO_HASH_ALL);
        end_deep(&f);
    }
    attributed_mesh_destroy(&made);
}

/* A mesh in the middle of the grid, an eighth of it below each of eight nodes. */
static void test_regions_side_by_side(void **state)
{
    deep_folder f;
    owned_mesh mesh;
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    const uint32_t middle = 1u << (SVO_PARTS_DEPTH_MAX - DEEP_LEVELS - 1);
    random_mesh(5, 60, 0.0, &mesh);
    options.need = SVO_NEED_NONE;
    make_deep(state, &f, &mesh.mesh, SVO_PARTS_DEPTH_MAX, middle - 0.5, &options);
    for (uint32_t octant = 0; octant < 8; ++octant) {
        uint32_t cell[3];
        double origin[3];
        for (uint32_t axis = 0; axis < 3; ++axis) {
            cell[axis] = middle - 1 + (octant >> axis & 1u);
            origin[axis] = -0.5 + (octant >> axis & 1u);
        }
        compare_with_build(&f, &mesh.mesh, cell, origin, &options, SVO_HASH_NODES);
    }
    end_deep(&f);
    owned_mesh_free(&mesh);
}

/* What needs more than the levels of a file is refused, and levels that a file can have are not. */
static void test_too_deep(void **state)
{
    deep_folder f;
    owned_mesh mesh;
    svo_message message;
    svo_tree *loaded = NULL;
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    svo_parts_tree_info info = SVO_PARTS_TREE_INFO_INIT;
    svo_parts_region region = SVO_PARTS_REGION_INIT;
    random_mesh(5, 20, 0.0, &mesh);
    make_deep(state, &f, &mesh.mesh, SVO_PARTS_DEPTH_MAX, 3.0, &options);
    check(svo_parts_tree_get_info(f.tree, &info, &message), &message);
    assert_int_equal(info.last_level, SVO_DEPTH_MAX);
    assert_int_equal(info.level_nodes[SVO_PARTS_DEPTH_MAX], info.leaf_count);
    assert_int_equal(svo_parts_tree_load(f.tree, NULL, &loaded, &message), SVO_CAPACITY_EXCEEDED);
    assert_non_null(strstr(message.text, "down to level 16 is possible"));
    assert_int_equal(svo_parts_finish(f.parts, path_of("deep.svo"), &message), SVO_CAPACITY_EXCEEDED);
    assert_non_null(strstr(message.text, "depth 20 is above the 16 of a .svo file"));
    assert_int_equal(svo_parts_shares_begin(f.parts, 2, &message), SVO_CAPACITY_EXCEEDED);
    region.last_level = info.last_level;
    check(svo_parts_tree_load(f.tree, &region, &loaded, &message), &message);
    assert_int_equal(info_of(loaded).leaf_count, info.level_nodes[SVO_DEPTH_MAX]);
    svo_tree_destroy(&loaded);
    options.need = SVO_NEED_RAYS;
    assert_int_equal(svo_parts_create(f.device, &mesh.mesh, 17, &options, LIMIT, f.folder, &message), SVO_UNSUPPORTED);
    assert_non_null(strstr(message.text, "options.need has rays, and depth 17 is above 16"));
    assert_int_equal(svo_parts_create(f.device, &mesh.mesh, 21, NULL, LIMIT, f.folder, &message), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(message.text, "depth 21 is not in 1 .. 20"));
    options.need = SVO_NEED_NORMAL;
    memset(options.origin, 0, sizeof options.origin);
    options.edge = 1.0; /* the triangles are as large as the grid */
    assert_int_equal(svo_parts_create(f.device, &mesh.mesh, 20, &options, LIMIT, f.folder, &message),
                     SVO_CAPACITY_EXCEEDED);
    end_deep(&f);
    owned_mesh_free(&mesh);
}

/* ---- parts that are not those of the tree ---- */

static void find_part(const deep_folder *f, size_t index, char path[PATH_BYTES + 48])
{
    svo_parts_entry entry = SVO_PARTS_ENTRY_INIT;
    svo_message message;
    check(svo_parts_get(f->parts, index, &entry, &message), &message);
    (void)snprintf(path, PATH_BYTES + 48, "%s/%u-%llx.part", f->folder, entry.level, (unsigned long long)entry.code);
}

static void flip(const char *path, long from_end)
{
    FILE *file = fopen(path, "r+b");
    assert_non_null(file);
    assert_int_equal(fseek(file, -from_end, SEEK_END), 0);
    const int byte = fgetc(file);
    assert_int_equal(fseek(file, -from_end, SEEK_END), 0);
    assert_int_equal(fputc(byte ^ 0x10, file), byte ^ 0x10);
    (void)fclose(file);
}

/* Opens the folder anew and hashes it: the failure must name the file. */
static void expect_refused(deep_folder *f, svo_status expected, const char *name, const char *why)
{
    char text[SVO_HASH_TEXT_BYTES];
    svo_message message = {""};
    svo_parts_tree_close(&f->tree);
    svo_status status = svo_parts_tree_open(f->folder, &f->tree, &message);
    if (status == SVO_OK) {
        status = svo_parts_tree_hash(f->tree, SVO_HASH_ALL, text, &message);
    }
    assert_int_equal(status, expected);
    assert_non_null(strstr(message.text, name));
    assert_non_null(strstr(message.text, why));
}

static void test_parts_of_others(void **state)
{
    deep_folder f, other;
    svo_message message;
    char path[PATH_BYTES + 48], kept[PATH_BYTES], foreign[PATH_BYTES + 48];
    uint64_t checked = 0;
    make_attributed(state, &f, "mine.svo.parts", (uint32_t)SVO_NEED_ALL);
    make_attributed(state, &other, "other.svo.parts", (uint32_t)SVO_NEED_COLOR);
    find_part(&f, 2, path);
    find_part(&other, 2, foreign);
    name_of("kept.part", kept);
    check(svo_parts_tree_check(f.tree, 0, 0, &checked, &message), &message);
    assert_int_equal(checked, svo_parts_count(f.parts));
    flip(path, 5);
    assert_int_equal(svo_parts_tree_check(f.tree, 0, 0, &checked, &message), SVO_FILE_DAMAGED);
    assert_non_null(strstr(message.text, path));
    expect_refused(&f, SVO_FILE_DAMAGED, path, "checksum");
    flip(path, 5);
    assert_int_equal(rename(path, kept), 0);
    expect_refused(&f, SVO_FILE_ERROR, f.folder, "is missing");
    assert_int_equal(rename(foreign, path), 0);
    expect_refused(&f, SVO_FILE_DAMAGED, path, "belongs to plan");
    assert_int_equal(rename(kept, path), 0);
    svo_parts_tree_close(&f.tree);
    check(svo_parts_tree_open(f.folder, &f.tree, &message), &message);
    compare_whole(&f);
    end_folder(&f);
    end_folder(&other);
}

/* A part that becomes another file while the tree is open, all its checksums right. */
static void test_part_that_changes(void **state)
{
    deep_folder f;
    svo_message message;
    char path[PATH_BYTES + 48], text[SVO_HASH_TEXT_BYTES];
    make_attributed(state, &f, "moved.svo.parts", (uint32_t)SVO_NEED_ALL);
    find_part(&f, 2, path);
    FILE *file = fopen(path, "r+b");
    assert_non_null(file);
    unsigned char content[4096];
    const size_t count = fread(content, 1, sizeof content, file);
    uint32_t segments = 0;
    memcpy(&segments, content + 12, sizeof segments);
    assert_true(208 + 32 * (size_t)segments <= count);
    content[64] ^= 1; /* the number of fragments */
    const uint64_t hash = XXH3_64bits(content + 32, 208 - 32 + 32 * (size_t)segments);
    memcpy(content + 24, &hash, sizeof hash);
    rewind(file);
    assert_int_equal(fwrite(content, 1, count, file), count);
    (void)fclose(file);
    assert_int_equal(svo_parts_tree_hash(f.tree, SVO_HASH_ALL, text, &message), SVO_UNAVAILABLE);
    assert_non_null(strstr(message.text, path));
    end_folder(&f);
}

static void test_bad_regions(void **state)
{
    static const struct {
        uint32_t level, last_level;
        uint64_t code;
        const char *words;
    } bad[] = {
        {0, 7, 0, "last_level 7"}, {6, 0, 0, "no node above"}, {3, 3, 0, "no node above"}, {1, 0, 8, "no node above"}};
    deep_folder f;
    svo_message message;
    svo_tree *loaded = NULL;
    make_attributed(state, &f, "bad.svo.parts", (uint32_t)SVO_NEED_ALL);
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        const svo_parts_region region = {
            .struct_size = sizeof region, .level = bad[i].level, .last_level = bad[i].last_level, .code = bad[i].code};
        assert_int_equal(svo_parts_tree_load(f.tree, &region, &loaded, &message), SVO_INVALID_ARGUMENT);
        assert_non_null(strstr(message.text, bad[i].words));
    }
    assert_int_equal(svo_parts_tree_load(NULL, NULL, &loaded, &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_parts_tree_load(f.tree, NULL, NULL, &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_parts_tree_hash(f.tree, SVO_HASH_ALL, NULL, &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_parts_tree_check(NULL, 0, 0, NULL, &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_parts_tree_get_info(NULL, NULL, &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_parts_tree_open(NULL, &f.tree, &message), SVO_INVALID_ARGUMENT);
    end_folder(&f);
}

TEST_GROUP(parts_tree)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_whole_tree),
        cmocka_unit_test(test_no_parts),
        cmocka_unit_test(test_levels),
        cmocka_unit_test(test_regions),
        cmocka_unit_test(test_more_than_numbers),
        cmocka_unit_test(test_far_regions),
        cmocka_unit_test(test_regions_side_by_side),
        cmocka_unit_test(test_too_deep),
        cmocka_unit_test(test_parts_of_others),
        cmocka_unit_test(test_part_that_changes),
        cmocka_unit_test(test_bad_regions),
    };
    return cmocka_run_group_tests_name("parts_tree", tests, fixture_folder_setup, fixture_folder_teardown);
}
