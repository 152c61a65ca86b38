/* SPDX-License-Identifier: MIT */
/*
 * Solids against closed forms and against the exact reference (tools/reference/oracle_solid.h): every voxel, the level
 * of its leaf, every count. Meshes whose corners and edges lie on the columns' center lines, open meshes, and the same
 * bytes for every queue.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "fixture.h"
#include "meshes.h"
#include "oracle_solid.h"
#include "solid_meshes.h"
#include "svocl/io.h"

/* A solid, compared with the reference. */
typedef struct solved {
    svo_solid_info info;
    oracle_solid_difference found;
    char hash[SVO_HASH_TEXT_BYTES];
} solved;

typedef struct request {
    unsigned depth;
    svo_solid_rule rule;
    svo_coverage coverage;
    bool open; /* the mesh may have holes: cells are compared, not each voxel */
} request;

static void succeed(const fixture *opened, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_status_name(status), svo_device_message(opened->device));
    }
}

/* A grid from 0, 0, 0 on of voxels one unit wide. */
static svo_plan_options unit_grid(unsigned depth, svo_coverage coverage)
{
    return (svo_plan_options){.need = SVO_NEED_RAYS, .coverage = coverage, .edge = (double)(1u << depth)};
}

static void compare(const built *from, const svo_compact *solid, const request *asked, solved *out)
{
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    svo_compact_arrays arrays = SVO_COMPACT_ARRAYS_INIT;
    oracle_solid reference;
    const oracle_mesh mesh = {from->arrays.vertices, from->arrays.indices, NULL,
                              (size_t)from->info.list_triangle_count};
    const oracle_request grid = {.depth = asked->depth, .snap_bits = from->info.snap_bits};
    uint8_t *levels = malloc((size_t)1 << 3 * asked->depth);
    assert_non_null(levels);
    assert_int_equal(svo_compact_get_info(solid, &info), SVO_OK);
    assert_int_equal(svo_compact_get_arrays(solid, &arrays), SVO_OK);
    assert_true(oracle_solid_make(&mesh, &grid, (oracle_rule)asked->rule, &reference));
    assert_true(oracle_descriptor_levels(arrays.nodes, (size_t)info.stored_count, asked->depth, levels));
    oracle_solid_compare(&reference, from->arrays.child_mask, from->arrays.first_child, levels, &out->found);
    for (int axis = 0; axis < 3; ++axis) {
        assert_int_equal(out->info.open_columns[axis], reference.open_columns[axis]);
    }
    assert_int_equal(info.voxel_count, out->info.surface_voxels + out->info.inside_voxels);
    assert_int_equal(info.leaf_count, out->info.surface_voxels + out->info.inside_leaves);
    oracle_solid_free(&reference);
    free(levels);
}

static void check_counts(const solved *found, const request *asked)
{
    const svo_solid_info *info = &found->info;
    assert_int_equal(found->found.wrong_voxels, 0);
    assert_int_equal(info->surface_voxels, found->found.surface_voxels);
    assert_int_equal(info->inside_voxels, found->found.inside_voxels);
    assert_int_equal(info->inside_leaves, found->found.inside_leaves);
    assert_int_equal(info->ambiguous_cells, found->found.ambiguous_cells);
    assert_int_equal(info->ambiguous_voxels, found->found.ambiguous_voxels);
    if (!asked->open) {
        assert_int_equal(found->found.split_voxels, 0);
        assert_int_equal(info->ambiguous_cells, 0);
        assert_int_equal(info->open_columns[0] + info->open_columns[1] + info->open_columns[2], 0);
    }
}

/* Builds a mesh on the unit grid, fills it and compares. */
static solved solve(void **state, const parts *made, request asked)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_mesh mesh = parts_mesh(made);
    const svo_plan_options plan = unit_grid(asked.depth, asked.coverage);
    const svo_solid_options options = {.struct_size = sizeof options, .rule = asked.rule};
    solved out = {.info = SVO_SOLID_INFO_INIT};
    svo_compact *solid = NULL;
    built tree;
    fixture_build(&opened, &mesh, asked.depth, &plan, &tree);
    succeed(&opened, svo_solid_create(tree.tree, &options, opened.queue, &solid, &out.info));
    succeed(&opened, svo_compact_download(solid, opened.queue));
    succeed(&opened, svo_compact_hash(solid, out.hash));
    compare(&tree, solid, &asked, &out);
    check_counts(&out, &asked);
    svo_compact_destroy(&solid);
    built_destroy(&tree);
    return out;
}

/* Closes over the parts: solves and frees them. */
static solved solve_parts(void **state, parts *made, request asked)
{
    const solved out = solve(state, made, asked);
    parts_free(made);
    return out;
}

static uint64_t all_voxels(const solved *found)
{
    return found->info.surface_voxels + found->info.inside_voxels;
}

/* ---- closed forms ---- */

/* A cube from the middle of one voxel to the middle of another. */
static void add_cube(parts *made, double first, double last, bool inwards, int skip)
{
    const double low[3] = {first, first, first};
    const double high[3] = {last, last, last};
    parts_add_box(made, low, high, inwards, skip);
}

static void cube_has_r_cubed_voxels_either_way_around(void **state)
{
    for (int inwards = 0; inwards < 2; ++inwards) {
        for (unsigned r = 3; r < 40; r += 9) {
            parts made = {.vertex_count = 0};
            add_cube(&made, 5.5, 4.5 + r, inwards != 0, -1);
            const solved found = solve_parts(state, &made, (request){.depth = 6});
            assert_int_equal(all_voxels(&found), (uint64_t)r * r * r);
            assert_int_equal(found.info.inside_voxels, (uint64_t)(r - 2) * (r - 2) * (r - 2));
        }
    }
}

static void interior_lies_on_the_highest_full_level(void **state)
{
    parts made = {.vertex_count = 0};
    add_cube(&made, 0.5, 63.5, false, -1);
    const solved found = solve_parts(state, &made, (request){.depth = 6});
    assert_int_equal(found.info.inside_voxels, 62 * 62 * 62);
    /* The eight 16^3 cells in the middle, then the layers of width 8, 4, 2 and 1 around them. */
    assert_int_equal(found.info.inside_leaves, 8 + (6 * 6 * 6 - 64) + (14 * 14 * 14 - 12 * 12 * 12) +
                                                   (30 * 30 * 30 - 28 * 28 * 28) + (62 * 62 * 62 - 60 * 60 * 60));
}

static void shell_in_shell(void **state)
{
    parts hollow = {.vertex_count = 0};
    add_cube(&hollow, 4.5, 27.5, false, -1);
    add_cube(&hollow, 10.5, 21.5, true, -1);
    solved found = solve(state, &hollow, (request){.depth = 5});
    assert_int_equal(all_voxels(&found), 24 * 24 * 24 - 10 * 10 * 10);
    found = solve_parts(state, &hollow, (request){.depth = 5, .rule = SVO_SOLID_PARITY});
    assert_int_equal(all_voxels(&found), 24 * 24 * 24 - 10 * 10 * 10);

    parts twice = {.vertex_count = 0};
    add_cube(&twice, 4.5, 27.5, false, -1);
    add_cube(&twice, 10.5, 21.5, false, -1);
    found = solve(state, &twice, (request){.depth = 5});
    assert_int_equal(all_voxels(&found), 24 * 24 * 24);
    found = solve_parts(state, &twice, (request){.depth = 5, .rule = SVO_SOLID_PARITY});
    assert_int_equal(all_voxels(&found), 24 * 24 * 24 - 10 * 10 * 10);
}

static void overlapping_cubes_make_their_union(void **state)
{
    parts made = {.vertex_count = 0};
    add_cube(&made, 3.5, 18.5, false, -1); /* voxels 3 .. 18 */
    add_cube(&made, 10.5, 27.5, false, -1); /* 10 .. 27, common 10 .. 18 */
    solved found = solve(state, &made, (request){.depth = 5});
    assert_int_equal(all_voxels(&found), 16 * 16 * 16 + 18 * 18 * 18 - 9 * 9 * 9);
    found = solve_parts(state, &made, (request){.depth = 5, .rule = SVO_SOLID_PARITY});
    assert_int_equal(all_voxels(&found), 16 * 16 * 16 + 18 * 18 * 18 - 9 * 9 * 9 - 7 * 7 * 7);
}

/* Without a face the columns through it do not cancel, and no others. Lines that leave through the hole find nothing,
   and those in front of it find the face behind; the other two axes decide. The voxels that the face would touch
   are inside. */
static void missing_face_is_reported(void **state)
{
    for (int face = 0; face < 6; ++face) {
        parts made = {.vertex_count = 0};
        add_cube(&made, 8.25, 23.75, false, face); /* the hole lies between cells, whatever their level */
        const solved found = solve_parts(state, &made, (request){.depth = 5, .open = true});
        for (int axis = 0; axis < 3; ++axis) {
            assert_int_equal(found.info.open_columns[axis], axis == face / 2 ? 16 * 16 : 0);
        }
        assert_true(found.info.ambiguous_voxels > 0);
        assert_int_equal(found.info.inside_voxels, 14 * 14 * 14 + 14 * 14);
    }
}

static void empty_trees_have_no_inside(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_mesh mesh = SVO_MESH_INIT;
    const svo_plan_options plan = unit_grid(4, SVO_COVERAGE_HALF_OPEN);
    svo_solid_info info = SVO_SOLID_INFO_INIT;
    svo_compact *solid = NULL;
    built tree;
    fixture_build(&opened, &mesh, 4, &plan, &tree);
    succeed(&opened, svo_solid_create(tree.tree, NULL, NULL, &solid, &info));
    assert_int_equal(info.surface_voxels + info.inside_voxels, 0);
    assert_int_equal(info.tests, 8);
    svo_compact_destroy(&solid);
    built_destroy(&tree);
}

/* ---- against the reference ---- */

static void spheres_of_radius_4_to_200(void **state)
{
    static const struct {
        double radius;
        unsigned depth, rings;
    } rows[] = {{4, 4, 8}, {9.7, 5, 12}, {25.3, 6, 24}, {61, 7, 40}, {120.4, 8, 32}, {200, 9, 24}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        const double middle = (double)(1u << rows[i].depth) / 2 + 0.25;
        const double center[3] = {middle, middle, middle};
        parts made = {.vertex_count = 0};
        parts_add_sphere(&made, center, rows[i].radius, rows[i].rings);
        const solved found = solve_parts(state, &made, (request){.depth = rows[i].depth});
        /* The reference has every voxel. The volume says that the reference is about a sphere. */
        const double volume = 4.18879 * rows[i].radius * rows[i].radius * rows[i].radius;
        assert_true((double)all_voxels(&found) > 0.9 * volume);
        assert_true((double)found.info.inside_voxels < volume);
    }
}

/* Tetrahedra with corners on the centers of voxels: columns pass through corners and along edges. */
static void random_lattice_tetrahedra(parts *made, uint64_t seed, unsigned count, unsigned cells, double step)
{
    for (unsigned i = 0; i < count; ++i) {
        double corners[4][3];
        for (unsigned k = 0; k < 12; ++k) {
            corners[k / 3][k % 3] = step * (random_below(&seed, cells) + 0.5);
        }
        parts_add_tetrahedron(made, (const double(*)[3])corners);
    }
}

static void corners_and_edges_on_the_columns(void **state)
{
    for (uint64_t seed = 1; seed <= 24; ++seed) {
        parts made = {.vertex_count = 0};
        random_lattice_tetrahedra(&made, seed, 1 + (unsigned)seed % 5, 32, 1);
        print_message("seed %d\n", (int)seed);
        solve(state, &made, (request){.depth = 5});
        solve(state, &made, (request){.depth = 5, .rule = SVO_SOLID_PARITY});
        solve_parts(state, &made, (request){.depth = 5, .coverage = SVO_COVERAGE_CLOSED});
    }
}

/* Many triangles in every leaf: their lists are read by a work-group. */
static void long_lists(void **state)
{
    parts made = {.vertex_count = 0};
    random_lattice_tetrahedra(&made, 77, 900, 64, 0.0625);
    const double low[3] = {5.5, 5.5, 5.5};
    const double high[3] = {15.25, 15.25, 15.25};
    parts_add_box(&made, low, high, false, -1);
    solve(state, &made, (request){.depth = 4});
    solve_parts(state, &made, (request){.depth = 4, .rule = SVO_SOLID_PARITY});
}

/* Parts of the surface left out at random, also with ties. */
static void open_meshes_are_reported(void **state)
{
    for (uint64_t seed = 100; seed < 112; ++seed) {
        parts made = {.vertex_count = 0};
        uint64_t random = seed;
        random_lattice_tetrahedra(&made, seed, 4, 32, 1);
        for (size_t t = 0; t < made.triangle_count; ++t) {
            if (random_below(&random, 4) == 0) {
                memcpy(made.indices + t * 3, made.indices + --made.triangle_count * 3, 3 * sizeof(uint32_t));
            }
        }
        print_message("seed %d\n", (int)seed);
        solve(state, &made, (request){.depth = 5, .open = true});
        solve_parts(state, &made, (request){.depth = 5, .open = true, .rule = SVO_SOLID_PARITY});
    }
}

/* ---- the finest grids ---- */

typedef struct deep {
    const built *tree;
    const uint32_t *words;
    oracle_mesh mesh;
    uint64_t tested;
} deep;

/* Compares the empty children below a node with the reference, point by point: there is no dense grid. */
static void check_node(deep *d, uint32_t node, size_t word_index, unsigned level, const uint32_t *cell)
{
    const svo_tree_arrays *arrays = &d->tree->arrays;
    const unsigned depth = d->tree->info.depth;
    const uint32_t word = d->words[word_index];
    const uint32_t field = word >> 17;
    size_t inner = word_index + ((word >> 16 & 1) != 0 ? d->words[word_index + field] : field);
    uint32_t child = arrays->first_child[node];
    for (unsigned octant = 0; octant < 8; ++octant) {
        const unsigned shift = d->tree->info.snap_bits - level - 1;
        uint32_t below[3];
        int64_t at[3];
        for (unsigned axis = 0; axis < 3; ++axis) {
            below[axis] = cell[axis] << 1 | (octant >> axis & 1);
            at[axis] = ((int64_t)below[axis] << shift) + (level + 1 < depth ? INT64_C(1) << (shift - 1) : 0) +
                       (INT64_C(1) << (d->tree->info.snap_bits - depth - 1));
        }
        if ((arrays->child_mask[node] >> octant & 1) == 0) {
            const bool inside = oracle_point_winding(&d->mesh, (unsigned)(d->tested % 3), at) != 0;
            assert_int_equal(word >> octant & 1, inside);
            assert_int_equal(word >> (8 + octant) & 1, inside);
            ++d->tested;
        } else if (level + 1 < depth) {
            check_node(d, child++, inner++, level + 1, below);
        }
    }
}

/* Slender tetrahedra, hundreds and thousands of voxels long: codes beyond 32 bits, other widths of the snap. */
static void grids_of_depth_13_and_16(void **state)
{
    static const struct {
        unsigned depth;
        double width;
    } rows[] = {{13, 17.3}, {16, 11.9}};
    const fixture opened = fixture_cl_of_group(state);
    for (size_t i = 0; i < 2; ++i) {
        const double edge = (double)(1u << rows[i].depth);
        const double width = rows[i].width;
        const double base[3] = {edge * 0.95, edge * 0.69, edge * 0.56};
        const double corners[4][3] = {{edge * 0.91, edge * 0.67, edge * 0.53},
                                      {base[0] + width, base[1], base[2]},
                                      {base[0], base[1] + width, base[2]},
                                      {base[0], base[1], base[2] + width}};
        parts made = {.vertex_count = 0};
        parts_add_tetrahedron(&made, corners);
        const svo_mesh mesh = parts_mesh(&made);
        const svo_plan_options plan = unit_grid(rows[i].depth, SVO_COVERAGE_HALF_OPEN);
        svo_compact_arrays arrays = SVO_COMPACT_ARRAYS_INIT;
        svo_solid_info info = SVO_SOLID_INFO_INIT;
        svo_compact *solid = NULL;
        built tree;
        fixture_build(&opened, &mesh, rows[i].depth, &plan, &tree);
        succeed(&opened, svo_solid_create(tree.tree, NULL, opened.queue, &solid, &info));
        succeed(&opened, svo_compact_download(solid, opened.queue));
        assert_int_equal(svo_compact_get_arrays(solid, &arrays), SVO_OK);
        deep d = {.tree = &tree, .words = arrays.nodes, .mesh = {tree.arrays.vertices, tree.arrays.indices, NULL, 4}};
        const uint32_t root[3] = {0, 0, 0};
        check_node(&d, 0, 0, 0, root);
        assert_int_equal(d.tested, info.tests);
        assert_true(info.inside_voxels > 0);
        assert_int_equal(info.ambiguous_cells, 0);
        svo_compact_destroy(&solid);
        built_destroy(&tree);
        parts_free(&made);
    }
}

/* ---- what a solid carries ---- */

/* A cube of one material in a mesh of two, colored. */
static void build_painted(const fixture *opened, uint32_t need, uint32_t payload_level, built *out)
{
    static const svo_material materials[] = {{{10, 20, 30, 255}, SVO_NO_TEXTURE}, {{200, 0, 0, 255}, SVO_NO_TEXTURE}};
    uint16_t triangle_materials[12];
    parts made = {.vertex_count = 0};
    add_cube(&made, 2.5, 13.5, false, -1);
    svo_mesh mesh = parts_mesh(&made);
    for (size_t t = 0; t < 12; ++t) {
        triangle_materials[t] = (uint16_t)(t % 2);
    }
    mesh.materials = materials;
    mesh.material_count = 2;
    mesh.triangle_materials = triangle_materials;
    svo_plan_options plan = unit_grid(4, SVO_COVERAGE_HALF_OPEN);
    plan.need |= need;
    plan.payload_level = payload_level;
    fixture_build(opened, &mesh, 4, &plan, out);
    parts_free(&made);
}

/* The leaf of a voxel in an expanded tree, or UINT32_MAX. */
static uint32_t leaf_at(const svo_tree *tree, uint32_t x, uint32_t y, uint32_t z)
{
    const uint32_t cell[3] = {x, y, z};
    svo_node node;
    return svo_tree_find_cell(tree, 4, cell, &node) == SVO_OK && node.level == 4 ? node.index : UINT32_MAX;
}

static void interior_has_the_stated_color_and_material(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const uint32_t need =
        (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_MATERIAL | (uint32_t)SVO_NEED_FILL;
    const svo_solid_options options = {.struct_size = sizeof options, .color = {1, 2, 3, 4}, .material = 7};
    svo_compact *solid = NULL;
    svo_tree *full = NULL;
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    built tree;
    build_painted(&opened, need, 0, &tree);
    succeed(&opened, svo_solid_create(tree.tree, &options, opened.queue, &solid, NULL));
    succeed(&opened, svo_compact_expand(solid, opened.queue, &full));
    succeed(&opened, svo_tree_download(full, opened.queue));
    assert_int_equal(svo_tree_get_arrays(full, &arrays), SVO_OK);
    for (uint32_t i = 0; i < 16 * 16 * 16; ++i) {
        const uint32_t at[3] = {i % 16, i / 16 % 16, i / 256};
        bool inside = true;
        bool held = true;
        for (int axis = 0; axis < 3; ++axis) {
            inside = inside && at[axis] > 2 && at[axis] < 13;
            held = held && at[axis] >= 2 && at[axis] <= 13;
        }
        const uint32_t leaf = leaf_at(full, at[0], at[1], at[2]);
        const uint32_t surface = leaf_at(tree.tree, at[0], at[1], at[2]);
        assert_int_equal(leaf != UINT32_MAX, held);
        assert_int_equal(surface != UINT32_MAX, held && !inside);
        if (inside) {
            const int16_t zero[3] = {0, 0, 0};
            assert_memory_equal(arrays.colors + leaf * 4, options.color, 4);
            assert_int_equal(arrays.materials[leaf], 7);
            assert_memory_equal(arrays.normals + leaf * 3, zero, sizeof zero);
            assert_int_equal(arrays.fills[leaf], 0);
        } else if (held) {
            assert_memory_equal(arrays.colors + leaf * 4, tree.arrays.colors + surface * 4, 4);
            assert_int_equal(arrays.materials[leaf], tree.arrays.materials[surface]);
            assert_memory_equal(arrays.normals + leaf * 3, tree.arrays.normals + surface * 3, 6);
            assert_int_equal(arrays.fills[leaf], tree.arrays.fills[surface]);
        }
    }
    assert_memory_equal(arrays.colors, tree.arrays.colors, 4); /* the root's stays that of the surface */
    svo_tree_destroy(&full);
    svo_compact_destroy(&solid);
    built_destroy(&tree);
}

/* White cubes: payload that is the same everywhere stays one element if the interior is white too. */
static void constant_payload_stays_constant_if_it_can(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_solid_options options = SVO_SOLID_OPTIONS_INIT;
    svo_plan_options plan = unit_grid(4, SVO_COVERAGE_HALF_OPEN);
    parts made = {.vertex_count = 0};
    built tree;
    plan.need |= (uint32_t)SVO_NEED_COLOR;
    add_cube(&made, 2.5, 13.5, false, -1);
    const svo_mesh mesh = parts_mesh(&made);
    fixture_build(&opened, &mesh, 4, &plan, &tree);
    assert_int_equal(tree.info.constant, SVO_NEED_COLOR);
    for (int white = 0; white < 2; ++white) {
        svo_compact_info info = SVO_COMPACT_INFO_INIT;
        svo_compact *solid = NULL;
        options.color[0] = options.color[1] = options.color[2] = options.color[3] = white != 0 ? 0 : 9;
        succeed(&opened, svo_solid_create(tree.tree, &options, opened.queue, &solid, NULL));
        assert_int_equal(svo_compact_get_info(solid, &info), SVO_OK);
        assert_int_equal(info.need, SVO_NEED_COLOR);
        assert_int_equal(info.constant, white != 0 ? SVO_NEED_COLOR : 0);
        assert_int_equal(info.bytes[SVO_COMPACT_COLORS], 4 * (white != 0 ? 1 : info.inner_count + info.leaf_count));
        svo_compact_destroy(&solid);
    }
    built_destroy(&tree);
    parts_free(&made);
}

/* Rays see a solid as they see all of its voxels; files keep it. */
static void solids_are_traced_and_saved(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const char path[] = "test_solid.tmp";
    const svo_solid_options options = {.struct_size = sizeof options, .color = {1, 2, 3, 4}, .material = 1};
    enum { RAYS = 400 };
    svo_ray rays[RAYS];
    svo_voxel_hit hits[RAYS];
    svo_voxel_hit full_hits[RAYS];
    uint64_t seed = 9;
    svo_compact *solid = NULL;
    svo_compact *loaded = NULL;
    svo_compact *flat = NULL;
    svo_tree *full = NULL;
    svo_message message = {""};
    char hashes[2][SVO_HASH_TEXT_BYTES];
    unsigned inside = 0;
    built tree;
    build_painted(&opened, SVO_NEED_COLOR, 0, &tree);
    succeed(&opened, svo_solid_create(tree.tree, &options, opened.queue, &solid, NULL));
    succeed(&opened, svo_compact_expand(solid, opened.queue, &full));
    succeed(&opened, svo_compact_create(opened.device, full, NULL, opened.queue, &flat));
    for (int i = 0; i < RAYS; ++i) {
        rays[i] = (svo_ray){.t_max = 100.0F};
        for (int axis = 0; axis < 3; ++axis) {
            rays[i].origin[axis] = (float)(random_unit(&seed) * 16.0);
            rays[i].direction[axis] = (float)(random_unit(&seed) - 0.5);
        }
    }
    succeed(&opened, svo_compact_trace(solid, rays, hits, RAYS, 0.0F, opened.queue));
    succeed(&opened, svo_compact_trace(flat, rays, full_hits, RAYS, 0.0F, opened.queue));
    for (int i = 0; i < RAYS; ++i) {
        assert_int_equal(hits[i].node == SVO_NO_NODE, full_hits[i].node == SVO_NO_NODE);
        assert_true(hits[i].node == SVO_NO_NODE || hits[i].t == full_hits[i].t);
        inside += hits[i].node != SVO_NO_NODE && hits[i].level < 4 ? 1 : 0;
    }
    assert_true(inside > 10);
    succeed(&opened, svo_compact_download(solid, opened.queue));
    succeed(&opened, svo_compact_hash(solid, hashes[0]));
    if (svo_compact_save(solid, path, NULL, &message) != SVO_OK ||
        svo_compact_load(path, NULL, &loaded, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    (void)remove(path);
    assert_int_equal(svo_compact_hash(loaded, hashes[1]), SVO_OK);
    assert_string_equal(hashes[0], hashes[1]);
    svo_tree_destroy(&full);
    svo_compact_destroy(&loaded);
    svo_compact_destroy(&flat);
    svo_compact_destroy(&solid);
    built_destroy(&tree);
}

static void same_bytes_on_any_queue(void **state)
{
    parts made = {.vertex_count = 0};
    random_lattice_tetrahedra(&made, 5, 3, 32, 1);
    const solved first = solve(state, &made, (request){.depth = 5});
    const solved again = solve(state, &made, (request){.depth = 5});
    assert_string_equal(first.hash, again.hash);
    fixture out_of_order;
    fixture_open_cl(&(fixture_options){.queue_properties = CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE}, &out_of_order);
    void *other = &out_of_order;
    const solved third = solve(&other, &made, (request){.depth = 5});
    assert_string_equal(first.hash, third.hash);
    fixture_close(&out_of_order);
    parts_free(&made);
}

/* ---- refusals ---- */

static void refuse(const fixture *opened, svo_tree *tree, const svo_solid_options *options, const char *message)
{
    svo_compact *solid = NULL;
    svo_solid_info info = SVO_SOLID_INFO_INIT;
    assert_int_equal(svo_solid_create(tree, options, opened->queue, &solid, &info), SVO_INVALID_ARGUMENT);
    assert_null(solid);
    assert_int_equal(info.surface_voxels, 0);
    if (strstr(svo_device_message(opened->device), message) == NULL) {
        fail_msg("'%s' does not say '%s'", svo_device_message(opened->device), message);
    }
}

static void refuse_build(const fixture *opened, const svo_mesh *mesh, svo_plan_options plan, const char *message)
{
    built tree;
    fixture_build(opened, mesh, 4, &plan, &tree);
    refuse(opened, tree.tree, NULL, message);
    built_destroy(&tree);
}

static void trees_that_do_not_say_what_is_inside_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    parts made = {.vertex_count = 0};
    add_cube(&made, 2.5, 13.5, false, -1);
    const svo_mesh mesh = parts_mesh(&made);
    svo_plan_options plan = unit_grid(4, SVO_COVERAGE_THIN);
    refuse_build(&opened, &mesh, plan, "coverage is thin");
    plan = unit_grid(4, SVO_COVERAGE_HALF_OPEN);
    plan.need = SVO_NEED_COLOR;
    refuse_build(&opened, &mesh, plan, "holds no leaf lists");
    plan.need = (uint32_t)SVO_NEED_RAYS | (uint32_t)SVO_NEED_COLOR;
    plan.payload_level = 2;
    refuse_build(&opened, &mesh, plan, "payload does not begin at level 0");
    plan = unit_grid(4, SVO_COVERAGE_HALF_OPEN);
    plan.origin[2] = 5;
    refuse_build(&opened, &mesh, plan, "2 triangles lie outside the tree's grid");
    plan.origin[2] = -3;
    refuse_build(&opened, &mesh, plan, "2 triangles lie outside the tree's grid");
    const double lean[4][3] = {{3, 3, 3}, {6, 3, 3}, {3, 6, 3}, {4, 4, 40}};
    parts beyond = {.vertex_count = 0};
    parts_add_tetrahedron(&beyond, lean);
    const svo_mesh reaches = parts_mesh(&beyond);
    refuse_build(&opened, &reaches, unit_grid(4, SVO_COVERAGE_HALF_OPEN), "3 triangles reach outside the tree's grid");
    parts_free(&beyond);
    parts_free(&made);
}

static void wrong_arguments_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_solid_options options = SVO_SOLID_OPTIONS_INIT;
    svo_solid_info info = SVO_SOLID_INFO_INIT;
    svo_compact *solid = NULL;
    built tree;
    build_painted(&opened, 0, 0, &tree);
    assert_int_equal(svo_solid_create(NULL, NULL, NULL, &solid, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_solid_create(tree.tree, NULL, NULL, NULL, NULL), SVO_INVALID_ARGUMENT);
    options.rule = (svo_solid_rule)2;
    refuse(&opened, tree.tree, &options, "svo_solid_create: options.rule 2 is not in 0 .. 1");
    options = (svo_solid_options){.struct_size = 3};
    refuse(&opened, tree.tree, &options, "struct_size");
    info.struct_size = 8;
    assert_int_equal(svo_solid_create(tree.tree, NULL, NULL, &solid, &info), SVO_INVALID_ARGUMENT);
    assert_null(solid);
    fixture other;
    fixture_open_cl(&(fixture_options){.share = SVO_GL_SHARE_AUTO}, &other);
    assert_int_equal(svo_solid_create(tree.tree, NULL, other.queue, &solid, NULL), SVO_INVALID_ARGUMENT);
    assert_null(solid);
    fixture_close(&other);
    assert_string_equal(svo_solid_rule_name(SVO_SOLID_WINDING), "winding");
    assert_string_equal(svo_solid_rule_name(SVO_SOLID_PARITY), "parity");
    assert_string_equal(svo_solid_rule_name((svo_solid_rule)7), "unknown rule");
    built_destroy(&tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cube_has_r_cubed_voxels_either_way_around),
        cmocka_unit_test(interior_lies_on_the_highest_full_level),
        cmocka_unit_test(shell_in_shell),
        cmocka_unit_test(overlapping_cubes_make_their_union),
        cmocka_unit_test(missing_face_is_reported),
        cmocka_unit_test(empty_trees_have_no_inside),
        cmocka_unit_test(spheres_of_radius_4_to_200),
        cmocka_unit_test(corners_and_edges_on_the_columns),
        cmocka_unit_test(long_lists),
        cmocka_unit_test(open_meshes_are_reported),
        cmocka_unit_test(grids_of_depth_13_and_16),
        cmocka_unit_test(interior_has_the_stated_color_and_material),
        cmocka_unit_test(constant_payload_stays_constant_if_it_can),
        cmocka_unit_test(solids_are_traced_and_saved),
        cmocka_unit_test(same_bytes_on_any_queue),
        cmocka_unit_test(trees_that_do_not_say_what_is_inside_are_refused),
        cmocka_unit_test(wrong_arguments_are_refused),
    };
    return cmocka_run_group_tests_name("solid", tests, fixture_group_setup, fixture_group_teardown);
}
