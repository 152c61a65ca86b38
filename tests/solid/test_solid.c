/* SPDX-License-Identifier: MIT */
/*
 * Solids against closed forms and against the exact reference of meshes as given (tools/lab/reference/oracle_exact.h):
 * every voxel, the level of its leaf, every count. Meshes whose corners and edges lie on the columns' center lines, or
 * an ulp beside them, open meshes, and the same bytes for every queue.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "oracle_exact.h"
#include "shared/layout.h"
#include "support/fixture.h"
#include "support/meshes.h"
#include "support/solid_meshes.h"
#include "support/suite.h"

/* A solid, compared with the reference. */
typedef struct solved {
    svo_solid_info info;
    oracle_solid_difference found;
    char hash[SVO_HASH_TEXT_BYTES];
    uint32_t longest_list; /* triangles of a leaf at most */
} solved;

typedef struct request {
    unsigned depth;
    svo_solid_rule rule;
    svo_coverage coverage;
    bool open; /* the mesh may have holes: cells are compared, not each voxel */
    bool skewed; /* on the skewed grid, whose planes are no doubles, with corners up to an ulp beside their places */
    bool floats; /* the mesh has floats */
    bool many_regions; /* too many for a line each */
} request;

static const double skewed_origin[3] = {0.1, -0.2, 1.0 / 3.0};
static const double skewed_edge = 0.7;

static void succeed(const fixture *opened, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), svo_device_message(opened->device));
    }
}

/* A grid from 0, 0, 0 on of voxels one unit wide. */
static svo_plan_options unit_grid(unsigned depth, svo_coverage coverage)
{
    return (svo_plan_options){.need = SVO_NEED_RAYS, .coverage = coverage, .edge = (double)(1u << depth)};
}

/* The mesh as it was given, in doubles of the caller's. */
static double *copy_positions(const built *from)
{
    const size_t count = (size_t)from->info.vertex_count * 3;
    double *positions = malloc((count + 1) * sizeof *positions);
    assert_non_null(positions);
    for (size_t i = 0; i < count; ++i) {
        positions[i] = from->info.positions == SVO_POSITIONS_DOUBLE ? from->arrays.positions_double[i]
                                                                    : (double)from->arrays.positions[i];
    }
    return positions;
}

static oracle_space space_of(const svo_tree_info *info)
{
    return (oracle_space){{info->origin[0], info->origin[1], info->origin[2]}, info->edge, info->depth};
}

static void compare(const built *from, const svo_compact *solid, const request *asked, solved *out)
{
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    svo_compact_arrays arrays = SVO_COMPACT_ARRAYS_INIT;
    oracle_solid reference;
    double *positions = copy_positions(from);
    const oracle_positions mesh = {positions, (size_t)from->info.vertex_count, from->arrays.indices,
                                   (size_t)from->info.list_triangle_count};
    const oracle_space space = space_of(&from->info);
    uint8_t *levels = malloc((size_t)1 << 3 * asked->depth);
    assert_non_null(levels);
    assert_int_equal(svo_compact_get_info(solid, &info), SVO_OK);
    assert_int_equal(svo_compact_get_arrays(solid, &arrays), SVO_OK);
    assert_true(oracle_exact_solid_make(&mesh, &space, (oracle_rule)asked->rule, &reference));
    assert_true(oracle_descriptor_levels(arrays.nodes, (size_t)info.stored_count, asked->depth, levels));
    oracle_solid_compare(&reference, from->arrays.child_mask, from->arrays.first_child, levels, &out->found);
    for (int axis = 0; axis < 3; ++axis) {
        assert_int_equal(out->info.open_columns[axis], reference.open_columns[axis]);
    }
    for (uint64_t leaf = 0; leaf < from->info.leaf_count; ++leaf) {
        const uint32_t length = from->arrays.list_begin[leaf + 1] - from->arrays.list_begin[leaf];
        out->longest_list = length > out->longest_list ? length : out->longest_list;
    }
    assert_int_equal(info.is_exact, 1);
    assert_int_equal(info.voxel_count, out->info.surface_voxels + out->info.inside_voxels);
    assert_int_equal(info.leaf_count, out->info.surface_voxels + out->info.inside_leaves);
    oracle_solid_free(&reference);
    free(positions);
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
        assert_true(asked->many_regions ? info->regions == 0 : info->regions > 0);
    } else {
        assert_int_equal(info->regions, 0);
    }
}

/* Moves parts from the unit grid to the skewed one, each coordinate an ulp up or down, or not. */
static void skew(parts *made, unsigned depth)
{
    uint64_t seed = 3;
    for (size_t i = 0; i < made->vertex_count * 3; ++i) {
        const double at = skewed_origin[i % 3] + made->positions[i] * (skewed_edge / (double)(1u << depth));
        const double step = (double)random_below(&seed, 3) - 1.0;
        made->positions[i] = nextafter(at, at + step);
    }
}

static float *copy_floats(const parts *made)
{
    float *floats = malloc((made->vertex_count * 3 + 1) * sizeof *floats);
    assert_non_null(floats);
    for (size_t i = 0; i < made->vertex_count * 3; ++i) {
        floats[i] = (float)made->positions[i];
    }
    return floats;
}

/* Builds a mesh on the grid, fills it and compares. */
static solved solve_once(void **state, const parts *made, request asked)
{
    const fixture opened = fixture_cl_of_group(state);
    float *floats = asked.floats ? copy_floats(made) : NULL;
    svo_mesh mesh = parts_mesh(made);
    svo_plan_options plan = unit_grid(asked.depth, asked.coverage);
    if (asked.skewed) {
        memcpy(plan.origin, skewed_origin, sizeof plan.origin);
        plan.edge = skewed_edge;
    }
    if (asked.floats) {
        mesh.positions = floats;
        mesh.positions_double = NULL;
    }
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
    free(floats);
    return out;
}

/* The parts and a triangle by itself in the last voxel. */
static parts with_lone_triangle(const parts *made, const request *asked)
{
    const size_t vertices = made->vertex_count;
    const size_t triangles = made->triangle_count;
    parts out = {malloc((vertices + 3) * 3 * sizeof(double)), malloc((triangles + 1) * 3 * sizeof(uint32_t)),
                 vertices + 3, triangles + 1};
    assert_true(out.positions != NULL && out.indices != NULL);
    memcpy(out.positions, made->positions, vertices * 3 * sizeof(double));
    memcpy(out.indices, made->indices, triangles * 3 * sizeof(uint32_t));
    for (size_t i = 0; i < 9; ++i) {
        const double at = (double)(1u << asked->depth) - (i % 4 == 0 ? 0.125 : 0.875);
        out.positions[vertices * 3 + i] =
            asked->skewed ? skewed_origin[i % 3] + at * (skewed_edge / (double)(1u << asked->depth)) : at;
        out.indices[triangles * 3 + i / 3] = (uint32_t)(vertices + i / 3);
    }
    return out;
}

/* The same with a closed mesh, whose regions decide, and with that mesh and a triangle that is not closed, where each
   cell decides for itself. */
static solved solve(void **state, const parts *made, request asked)
{
    const solved out = solve_once(state, made, asked);
    if (!asked.open && !asked.many_regions) {
        parts opened = with_lone_triangle(made, &asked);
        asked.open = true;
        solve_once(state, &opened, asked);
        parts_free(&opened);
    }
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

static void cube_has_r_cubed_voxels_either_way_around(void **state)
{
    for (int inwards = 0; inwards < 2; ++inwards) {
        for (unsigned r = 3; r < 40; r += 9) {
            parts made = {.vertex_count = 0};
            parts_add_cube(&made, 5.5, 4.5 + r, inwards != 0, -1);
            const solved found = solve_parts(state, &made, (request){.depth = 6});
            assert_int_equal(all_voxels(&found), (uint64_t)r * r * r);
            assert_int_equal(found.info.inside_voxels, (uint64_t)(r - 2) * (r - 2) * (r - 2));
        }
    }
}

static void interior_lies_on_the_highest_full_level(void **state)
{
    parts made = {.vertex_count = 0};
    parts_add_cube(&made, 0.5, 63.5, false, -1);
    const solved found = solve_parts(state, &made, (request){.depth = 6});
    assert_int_equal(found.info.inside_voxels, 62 * 62 * 62);
    /* The eight 16^3 cells in the middle, then the layers of width 8, 4, 2 and 1 around them. */
    assert_int_equal(found.info.inside_leaves, 8 + (6 * 6 * 6 - 64) + (14 * 14 * 14 - 12 * 12 * 12) +
                                                   (30 * 30 * 30 - 28 * 28 * 28) + (62 * 62 * 62 - 60 * 60 * 60));
}

static void shell_in_shell(void **state)
{
    parts hollow = {.vertex_count = 0};
    parts_add_cube(&hollow, 4.5, 27.5, false, -1);
    parts_add_cube(&hollow, 10.5, 21.5, true, -1);
    solved found = solve(state, &hollow, (request){.depth = 5});
    assert_int_equal(all_voxels(&found), 24 * 24 * 24 - 10 * 10 * 10);
    found = solve_parts(state, &hollow, (request){.depth = 5, .rule = SVO_SOLID_PARITY});
    assert_int_equal(all_voxels(&found), 24 * 24 * 24 - 10 * 10 * 10);

    parts twice = {.vertex_count = 0};
    parts_add_cube(&twice, 4.5, 27.5, false, -1);
    parts_add_cube(&twice, 10.5, 21.5, false, -1);
    found = solve(state, &twice, (request){.depth = 5});
    assert_int_equal(all_voxels(&found), 24 * 24 * 24);
    found = solve_parts(state, &twice, (request){.depth = 5, .rule = SVO_SOLID_PARITY});
    assert_int_equal(all_voxels(&found), 24 * 24 * 24 - 10 * 10 * 10);
}

static void overlapping_cubes_make_their_union(void **state)
{
    parts made = {.vertex_count = 0};
    parts_add_cube(&made, 3.5, 18.5, false, -1); /* voxels 3 .. 18 */
    parts_add_cube(&made, 10.5, 27.5, false, -1); /* 10 .. 27, common 10 .. 18 */
    solved found = solve(state, &made, (request){.depth = 5});
    assert_int_equal(all_voxels(&found), 16 * 16 * 16 + 18 * 18 * 18 - 9 * 9 * 9);
    found = solve_parts(state, &made, (request){.depth = 5, .rule = SVO_SOLID_PARITY});
    assert_int_equal(all_voxels(&found), 16 * 16 * 16 + 18 * 18 * 18 - 9 * 9 * 9 - 7 * 7 * 7);
}

/* Twenty slabs above each other, and a beam through all of them: columns along z are crossed up to 42 times. */
static void columns_with_many_crossings(void **state)
{
    parts made = {.vertex_count = 0};
    for (int i = 0; i < 20; ++i) {
        const double low[3] = {2.5, 2.5, 6 * i + 1.5};
        const double high[3] = {61.5, 9.5, 6 * i + 5.5};
        parts_add_box(&made, low, high, false, -1);
    }
    const double low[3] = {20.5, 2.5, 0.5};
    const double high[3] = {30.5, 9.5, 125.5};
    parts_add_box(&made, low, high, false, -1);
    const solved found = solve_parts(state, &made, (request){.depth = 7});
    assert_int_equal(all_voxels(&found), 20 * 60 * 8 * 5 + 11 * 8 * 126 - 20 * 11 * 8 * 5);
}

/* Without a face the columns through it do not cancel, and no others. Lines that leave through the hole find nothing,
   and those in front of it find the face behind; the other two axes decide. The voxels that the face would touch
   are inside. */
static void missing_face_is_reported(void **state)
{
    for (int face = 0; face < 6; ++face) {
        parts made = {.vertex_count = 0};
        parts_add_cube(&made, 8.25, 23.75, false, face); /* the hole lies between cells, whatever their level */
        const solved found = solve_parts(state, &made, (request){.depth = 5, .open = true});
        for (int axis = 0; axis < 3; ++axis) {
            assert_int_equal(found.info.open_columns[axis], axis == face / 2 ? 16 * 16 : 0);
        }
        assert_true(found.info.ambiguous_voxels > 0);
        assert_int_equal(found.info.inside_voxels, 14 * 14 * 14 + 14 * 14);
    }
}

/* Cubes side by side that share all of their faces, with one empty voxel each. */
static void many_pockets_take_three_lines_each(void **state)
{
    parts made = {.vertex_count = 0};
    for (unsigned i = 0; i < 12 * 12 * 12; ++i) {
        const unsigned cell[3] = {i % 12, i / 12 % 12, i / 144};
        const double low[3] = {2 * cell[0] + 0.5, 2 * cell[1] + 0.5, 2 * cell[2] + 0.5};
        const double high[3] = {low[0] + 2, low[1] + 2, low[2] + 2};
        parts_add_box(&made, low, high, i % 2 != 0, -1);
    }
    const solved found = solve_parts(state, &made, (request){.depth = 5, .many_regions = true});
    assert_int_equal(found.info.inside_voxels, 12 * 12 * 12);
}

/* A hollow cube with fins that begin at one wall and at the other by turns: the passage between them is one region,
   though its ends are far from each other by way of it. */
static void a_winding_passage_is_one_region(void **state)
{
    parts made = {.vertex_count = 0};
    parts_add_cube(&made, 1.5, 30.5, false, -1);
    parts_add_cube(&made, 4.5, 27.5, true, -1);
    for (unsigned fin = 0; fin < 5; ++fin) {
        const double x = fin % 2 != 0 ? 8.5 : 3.5;
        const double low[3] = {x, 4 * fin + 6.25, 3.5};
        const double high[3] = {x + 20, 4 * fin + 8.75, 28.5};
        parts_add_box(&made, low, high, false, -1);
    }
    const solved found = solve_parts(state, &made, (request){.depth = 5});
    assert_int_equal(found.info.regions, 3 + 5); /* outside, the wall, the passage, and the fins */
}

/* A wall with a dent one voxel wide, whose only neighbor is an empty cell eight voxels wide before it: the same regions
   as without the dent. */
static void small_cells_join_larger_ones_on_all_sides(void **state)
{
    static const double around[4][2][2] = {{{2.5, 12.75}, {2.5, 29.5}},
                                           {{14.25, 29.5}, {2.5, 29.5}},
                                           {{2.5, 29.5}, {2.5, 12.75}},
                                           {{2.5, 29.5}, {14.25, 29.5}}};
    for (unsigned axis = 0; axis < 3; ++axis) {
        uint64_t regions[2];
        for (unsigned dent = 0; dent < 2; ++dent) {
            parts made = {.vertex_count = 0};
            double low[3];
            double high[3];
            for (unsigned side = 0; side < 5; ++side) {
                low[axis] = side == 4 && dent != 0 ? 17.25 : 16.25;
                high[axis] = 20.5;
                for (unsigned k = 0; k < 2; ++k) {
                    low[(axis + 1 + k) % 3] = side == 4 ? 12.75 : around[side][k][0];
                    high[(axis + 1 + k) % 3] = side == 4 ? 14.25 : around[side][k][1];
                }
                parts_add_box(&made, low, high, false, -1);
            }
            regions[dent] = solve_parts(state, &made, (request){.depth = 5}).info.regions;
        }
        assert_int_equal(regions[0], regions[1]);
    }
}

/* The faces of a cube have corners of their own, and zeros with either sign. */
static void seams_and_signs_of_zero_are_closed(void **state)
{
    parts made = {.vertex_count = 0};
    parts_add_cube(&made, 0, 12, false, -1);
    double *positions = malloc(made.triangle_count * 9 * sizeof *positions);
    uint32_t *indices = malloc(made.triangle_count * 3 * sizeof *indices);
    assert_true(positions != NULL && indices != NULL);
    for (size_t i = 0; i < made.triangle_count * 3; ++i) {
        indices[i] = (uint32_t)i;
        for (size_t axis = 0; axis < 3; ++axis) {
            const double at = made.positions[3 * made.indices[i] + axis];
            positions[3 * i + axis] = at == 0 && i % 2 != 0 ? -0.0 : at;
        }
    }
    parts apart = {positions, indices, made.triangle_count * 3, made.triangle_count};
    for (int floats = 0; floats < 2; ++floats) {
        const solved found = solve(state, &apart, (request){.depth = 4, .floats = floats != 0});
        assert_int_equal(found.info.regions, 2);
        assert_int_equal(found.info.inside_voxels, 11 * 11 * 11);
    }
    parts_free(&apart);
    parts_free(&made);
}

/* A cube with one triangle turned around has no hole, but its edges do not cancel. */
static void a_turned_triangle_is_open(void **state)
{
    parts made = {.vertex_count = 0};
    parts_add_cube(&made, 3.5, 20.5, false, -1);
    const uint32_t swapped = made.indices[0];
    made.indices[0] = made.indices[1];
    made.indices[1] = swapped;
    solve(state, &made, (request){.depth = 5, .open = true});
    solve_parts(state, &made, (request){.depth = 5, .open = true, .rule = SVO_SOLID_PARITY});
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

/* Small tetrahedra with corners on corners and centers of voxels, so that many cross center lines where voxels meet. */
static void add_small_tetrahedra(parts *made, uint64_t seed, unsigned count)
{
    for (unsigned i = 0; i < count; ++i) {
        double corners[4][3];
        double from[3];
        for (unsigned k = 0; k < 15; ++k) {
            const double step = 0.5 * random_below(&seed, k < 3 ? 54 : 9);
            if (k < 3) {
                from[k] = step;
            } else {
                corners[k / 3 - 1][k % 3] = from[k % 3] + step + 0.5;
            }
        }
        parts_add_tetrahedron(made, (const double(*)[3])corners);
    }
}

/* The same on a grid of which no plane and no center is a double. */
static void crossings_an_ulp_beside_planes_and_edges(void **state)
{
    for (uint64_t seed = 1; seed <= 12; ++seed) {
        parts made = {.vertex_count = 0};
        random_lattice_tetrahedra(&made, seed, 1 + (unsigned)seed % 5, 32, 1);
        add_small_tetrahedra(&made, seed, 200);
        skew(&made, 5);
        print_message("seed %d\n", (int)seed);
        const bool floats = seed % 2 == 0;
        solve(state, &made, (request){.depth = 5, .skewed = true, .floats = floats});
        solve(state, &made, (request){.depth = 5, .skewed = true, .floats = floats, .rule = SVO_SOLID_PARITY});
        solve_parts(state, &made,
                    (request){.depth = 5, .skewed = true, .floats = floats, .coverage = SVO_COVERAGE_CLOSED});
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
    const solved found = solve(state, &made, (request){.depth = 4});
    assert_true(found.longest_list > SVO_SHORT_LIST_MAX);
    solve(state, &made, (request){.depth = 4, .rule = SVO_SOLID_PARITY});
    skew(&made, 4);
    solve_parts(state, &made, (request){.depth = 4, .skewed = true});
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
    uint64_t tested;
} deep;

/* The sum of the crossings above a voxel's center. */
static int64_t wind(const built *tree, unsigned axis, const int32_t cell[3])
{
    const oracle_space space = space_of(&tree->info);
    oracle_exact_triangle triangle;
    int64_t half = 0;
    int64_t sum = 0;
    for (size_t t = 0; t < tree->info.list_triangle_count; ++t) {
        for (size_t k = 0; k < 9; ++k) {
            const size_t vertex = tree->arrays.indices[3 * t + k / 3];
            triangle.vertices[k / 3][k % 3] = tree->arrays.positions_double[3 * vertex + k % 3];
        }
        const int sense = oracle_exact_crossing(&triangle, &space, axis, cell, &half);
        sum += sense != 0 && half > 2 * (int64_t)cell[axis] ? sense : 0;
    }
    return sum;
}

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
        const unsigned shift = depth - level - 1;
        uint32_t below[3];
        int32_t middle[3];
        for (unsigned axis = 0; axis < 3; ++axis) {
            below[axis] = cell[axis] << 1 | (octant >> axis & 1);
            middle[axis] = (int32_t)(below[axis] << shift | 1u << shift >> 1);
        }
        if ((arrays->child_mask[node] >> octant & 1) == 0) {
            const bool inside = wind(d->tree, (unsigned)(d->tested % 3), middle) != 0;
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
        deep d = {.tree = &tree, .words = arrays.nodes};
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

/* ---- the same everywhere ---- */

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

TEST_GROUP(solid)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cube_has_r_cubed_voxels_either_way_around),
        cmocka_unit_test(interior_lies_on_the_highest_full_level),
        cmocka_unit_test(shell_in_shell),
        cmocka_unit_test(overlapping_cubes_make_their_union),
        cmocka_unit_test(columns_with_many_crossings),
        cmocka_unit_test(missing_face_is_reported),
        cmocka_unit_test(many_pockets_take_three_lines_each),
        cmocka_unit_test(a_winding_passage_is_one_region),
        cmocka_unit_test(small_cells_join_larger_ones_on_all_sides),
        cmocka_unit_test(seams_and_signs_of_zero_are_closed),
        cmocka_unit_test(a_turned_triangle_is_open),
        cmocka_unit_test(empty_trees_have_no_inside),
        cmocka_unit_test(spheres_of_radius_4_to_200),
        cmocka_unit_test(corners_and_edges_on_the_columns),
        cmocka_unit_test(crossings_an_ulp_beside_planes_and_edges),
        cmocka_unit_test(long_lists),
        cmocka_unit_test(open_meshes_are_reported),
        cmocka_unit_test(grids_of_depth_13_and_16),
        cmocka_unit_test(same_bytes_on_any_queue),
    };
    return cmocka_run_group_tests_name("solid", tests, fixture_group_setup, fixture_group_teardown);
}
