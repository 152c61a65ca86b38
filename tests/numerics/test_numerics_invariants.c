/* SPDX-License-Identifier: MIT */
/*
 * The catalog of ill-conditioned and extreme cases, by invariant: the mean number of voxels of a triangle (T5),
 * symmetry (T6), separability of each coverage, nesting of coverages, and sums of the filter (T16). Property tests
 * print their seeds.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/compare_tree.h"
#include "support/meshes.h"
#include "support/payload_reference.h"
#include "support/suite.h"

#define EDGE 0x1p20

static const svo_coverage coverages[] = {SVO_COVERAGE_HALF_OPEN, SVO_COVERAGE_CLOSED, SVO_COVERAGE_THIN};
enum { COVERAGES = sizeof coverages / sizeof coverages[0] };

static void *allocate(size_t bytes)
{
    void *memory = calloc(1, bytes + 1);
    assert_non_null(memory);
    return memory;
}

/*
 * T5 fragment estimate.
 */

/* E[voxels] = 1 + (wx + wy + wz) / h + A (|nx| + |ny| + |nz|) / h^2: the mean over copies of one triangle at random
   offsets is within four standard errors. */
static void t5_mean_count_matches_the_estimate(void **state)
{
    enum { COPIES = 20000, DEPTH = 8 };
    static const int32_t shape[9] = {100, 9000, 40, 11000, 20, 3000, 4000, 7000, 15000};
    const uint64_t seed = 20240302;
    uint64_t random = seed;
    print_message("seed %llu\n", (unsigned long long)seed);
    double *positions = allocate(COPIES * 9 * sizeof *positions);
    for (size_t t = 0; t < COPIES; ++t) {
        const double offsets[3] = {random_below(&random, 1 << 19), random_below(&random, 1 << 19),
                                   random_below(&random, 1 << 19)};
        for (unsigned k = 0; k < 9; ++k) {
            positions[t * 9 + k] = shape[k] + offsets[k % 3];
        }
    }
    const svo_mesh mesh = {.struct_size = sizeof mesh,
                           .positions_double = positions,
                           .vertex_count = COPIES * 3,
                           .triangle_count = COPIES};
    built actual;
    fixture_build(fixture_of_group(state), &mesh, DEPTH, &(svo_plan_options){.need = SVO_NEED_RAYS, .edge = EDGE},
                  &actual);
    uint64_t *counts = allocate(COPIES * sizeof *counts);
    for (size_t i = 0; i < actual.info.list_count; ++i) {
        ++counts[actual.arrays.triangle_ids[actual.arrays.list[i]]];
    }
    const double mean = (double)actual.info.fragments / COPIES;
    double variance = 0.0;
    for (size_t t = 0; t < COPIES; ++t) {
        variance += ((double)counts[t] - mean) * ((double)counts[t] - mean) / (COPIES - 1);
    }
    const double error = sqrt(variance / COPIES);
    const double estimate = actual.plan.expected_fragments / COPIES;
    print_message("mean %.4f, estimate %.4f, standard error %.4f\n", mean, estimate, error);
    assert_true(fabs(mean - estimate) <= 4.0 * error);
    /* The plan's estimate equals the documented formula. */
    const double h = EDGE / (1 << DEPTH);
    const double u[3] = {shape[3] - shape[0], shape[4] - shape[1], shape[5] - shape[2]};
    const double v[3] = {shape[6] - shape[0], shape[7] - shape[1], shape[8] - shape[2]};
    double by_hand = 1.0 + (10900.0 + 8980.0 + 14960.0) / h;
    for (unsigned k = 0; k < 3; ++k) {
        const unsigned p = (k + 1) % 3;
        const unsigned q = (k + 2) % 3;
        by_hand += fabs(u[p] * v[q] - u[q] * v[p]) / 2.0 / (h * h);
    }
    assert_true(fabs(estimate - by_hand) < 1e-3);
    free(counts);
    built_destroy(&actual);
    free(positions);
}

/*
 * T6 symmetry.
 */

/* Coordinates 1 .. 2^20 - 1, so that a mirror image lies inside too; some on voxel corners. */
static void make_symmetric(uint64_t seed, size_t triangle_count, owned_mesh *out)
{
    random_mesh(seed, triangle_count, 0.0, out);
    for (size_t i = 0; i < triangle_count * 9; ++i) {
        out->positions[i] = fmin(fmax(rint(out->positions[i] * EDGE), 1.0), EDGE - 1.0);
    }
}

/* The tree's voxels, as coordinates packed into one number, in ascending order; allocated by malloc. */
typedef struct voxel_set {
    uint64_t *voxels;
    size_t count;
} voxel_set;

static uint64_t pack(uint32_t x, uint32_t y, uint32_t z)
{
    return (uint64_t)z << 32 | (uint64_t)y << 16 | x;
}

static uint32_t axis_of(uint64_t voxel, unsigned axis)
{
    return (uint32_t)(voxel >> 16 * axis & 0xffff);
}

static int compare_voxels(const void *left, const void *right)
{
    const uint64_t a = *(const uint64_t *)left;
    const uint64_t b = *(const uint64_t *)right;
    return (a > b) - (a < b);
}

static void voxels_of(const built *tree, voxel_set *out)
{
    *out = (voxel_set){allocate(tree->info.leaf_count * sizeof(uint64_t)), (size_t)tree->info.leaf_count};
    assert_true(oracle_leaf_codes(tree->arrays.child_mask, tree->info.inner_count, tree->info.depth,
                                  tree->info.leaf_count, out->voxels));
    for (size_t i = 0; i < out->count; ++i) {
        oracle_box box;
        oracle_voxel_box(out->voxels[i], tree->info.depth, tree->info.depth, &box);
        out->voxels[i] = pack((uint32_t)box.corner[0], (uint32_t)box.corner[1], (uint32_t)box.corner[2]);
    }
    qsort(out->voxels, out->count, sizeof(uint64_t), compare_voxels);
}

static void build_voxels(const fixture *opened, const svo_mesh *mesh, unsigned depth, svo_coverage coverage,
                         voxel_set *out)
{
    const svo_plan_options options = {.need = SVO_NEED_NONE, .edge = EDGE, .coverage = coverage};
    built actual;
    fixture_build(opened, mesh, depth, &options, &actual);
    voxels_of(&actual, out);
    built_destroy(&actual);
}

/* A permutation of the axes, then a reflection along those whose bit is set. */
typedef struct symmetry {
    unsigned axes[3]; /* where each axis comes from */
    unsigned mirrored;
} symmetry;

static const unsigned orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};

static void transform_mesh(const symmetry *by, const owned_mesh *from, double *positions)
{
    for (size_t v = 0; v < from->mesh.vertex_count; ++v) {
        for (unsigned axis = 0; axis < 3; ++axis) {
            const double value = from->positions[v * 3 + by->axes[axis]];
            positions[v * 3 + axis] = (by->mirrored >> axis & 1u) != 0 ? EDGE - value : value;
        }
    }
}

static void transform_voxels(const symmetry *by, unsigned depth, voxel_set *set)
{
    const uint32_t last = (1u << depth) - 1u;
    for (size_t i = 0; i < set->count; ++i) {
        uint32_t at[3];
        for (unsigned axis = 0; axis < 3; ++axis) {
            const uint32_t value = axis_of(set->voxels[i], by->axes[axis]);
            at[axis] = (by->mirrored >> axis & 1u) != 0 ? last - value : value;
        }
        set->voxels[i] = pack(at[0], at[1], at[2]);
    }
    qsort(set->voxels, set->count, sizeof(uint64_t), compare_voxels);
}

static void check_symmetry(const fixture *opened, const owned_mesh *made, unsigned depth, svo_coverage coverage,
                           const symmetry *by)
{
    voxel_set expected;
    voxel_set actual;
    svo_mesh mesh = made->mesh;
    double *positions = allocate(mesh.vertex_count * 3 * sizeof *positions);
    build_voxels(opened, &mesh, depth, coverage, &expected);
    transform_voxels(by, depth, &expected);
    transform_mesh(by, made, positions);
    mesh.positions_double = positions;
    build_voxels(opened, &mesh, depth, coverage, &actual);
    assert_int_equal(actual.count, expected.count);
    assert_memory_equal(actual.voxels, expected.voxels, expected.count * sizeof(uint64_t));
    free(actual.voxels);
    free(expected.voxels);
    free(positions);
}

/* Half-open and closed coverage treat all axes alike; thin coverage breaks ties by the order of the axes. */
static void t6_order_of_the_axes_does_not_matter(void **state)
{
    for (uint64_t seed = 1; seed <= 4; ++seed) {
        owned_mesh made;
        make_symmetric(seed, 200, &made);
        print_message("seed %llu\n", (unsigned long long)seed);
        for (unsigned order = 1; order < 6; ++order) {
            const symmetry by = {{orders[order][0], orders[order][1], orders[order][2]}, 0};
            check_symmetry(fixture_of_group(state), &made, 3 + (unsigned)seed, SVO_COVERAGE_HALF_OPEN, &by);
            check_symmetry(fixture_of_group(state), &made, 3 + (unsigned)seed, SVO_COVERAGE_CLOSED, &by);
        }
        owned_mesh_free(&made);
    }
}

static void t6_closed_coverage_is_mirror_symmetric(void **state)
{
    for (uint64_t seed = 11; seed <= 14; ++seed) {
        owned_mesh made;
        make_symmetric(seed, 200, &made);
        print_message("seed %llu\n", (unsigned long long)seed);
        for (unsigned mirrored = 1; mirrored < 8; ++mirrored) {
            const unsigned order = (mirrored + (unsigned)seed) % 6;
            const symmetry by = {{orders[order][0], orders[order][1], orders[order][2]}, mirrored};
            check_symmetry(fixture_of_group(state), &made, (unsigned)seed - 8, SVO_COVERAGE_CLOSED, &by);
        }
        owned_mesh_free(&made);
    }
}

/* Corners in any order and winding give the same tree with the same lists. */
static void t6_order_of_vertices_and_winding_do_not_matter(void **state)
{
    const fixture *opened = fixture_of_group(state);
    for (uint64_t seed = 21; seed <= 23; ++seed) {
        print_message("seed %llu\n", (unsigned long long)seed);
        owned_mesh made;
        make_symmetric(seed, 300, &made);
        uint32_t *indices = allocate(300 * 3 * sizeof *indices);
        for (size_t i = 0; i < (size_t)COVERAGES * 5; ++i) {
            const unsigned *order = orders[1 + i % 5];
            const svo_plan_options options = {.need = SVO_NEED_RAYS, .edge = EDGE, .coverage = coverages[i / 5]};
            for (size_t k = 0; k < 900; ++k) {
                indices[k] = made.indices[k / 3 * 3 + order[k % 3]];
            }
            svo_mesh turned_mesh = made.mesh;
            turned_mesh.indices = indices;
            built expected;
            built turned;
            fixture_build(opened, &made.mesh, 7, &options, &expected);
            fixture_build(opened, &turned_mesh, 7, &options, &turned);
            assert_string_equal(turned.hash, expected.hash);
            built_destroy(&turned);
            built_destroy(&expected);
        }
        free(indices);
        owned_mesh_free(&made);
    }
}

/* A mesh in the first octant, translated to another, has the same voxels there. */
static void t6_octants_have_the_same_voxels(void **state)
{
    const fixture *opened = fixture_of_group(state);
    const unsigned depth = 7;
    const double half = EDGE / 2;
    for (uint64_t seed = 31; seed <= 33; ++seed) {
        print_message("seed %llu\n", (unsigned long long)seed);
        owned_mesh made;
        make_symmetric(seed, 200, &made);
        for (size_t i = 0; i < 1800; ++i) { /* closed voxels include their far faces: avoid those of the octant */
            made.positions[i] = fmin(fmax(floor(made.positions[i] / 2), 1.0), half - 1.0);
        }
        for (unsigned i = 0; i < COVERAGES * 7u; ++i) {
            const unsigned octant = 1 + i % 7;
            voxel_set expected;
            voxel_set actual;
            build_voxels(opened, &made.mesh, depth, coverages[i / 7], &expected);
            svo_mesh mesh = made.mesh;
            double *positions = allocate(1800 * sizeof *positions);
            for (size_t k = 0; k < 1800; ++k) {
                positions[k] = made.positions[k] + ((octant >> k % 3 & 1u) != 0 ? half : 0.0);
            }
            mesh.positions_double = positions;
            build_voxels(opened, &mesh, depth, coverages[i / 7], &actual);
            const uint32_t step = 1u << (depth - 1);
            const uint64_t shift = pack((octant & 1u) * step, (octant >> 1 & 1u) * step, (octant >> 2) * step);
            assert_int_equal(actual.count, expected.count);
            for (size_t k = 0; k < expected.count; ++k) {
                assert_int_equal(actual.voxels[k], expected.voxels[k] + shift);
            }
            free(positions);
            free(actual.voxels);
            free(expected.voxels);
        }
        owned_mesh_free(&made);
    }
}

/*
 * Separability.
 */

enum { FLOOD_DEPTH = 6, FLOOD_WIDTH = 1 << FLOOD_DEPTH, FLOOD_VOXELS = FLOOD_WIDTH * FLOOD_WIDTH * FLOOD_WIDTH };

/* The corner of cell (i, j) on the given face of a cube, projected onto a bumpy sphere around a point. */
static void sphere_corner(const double center[3], double radius, unsigned face, unsigned i, unsigned j, unsigned cells,
                          double *out)
{
    double direction[3];
    direction[face % 3] = face < 3 ? 1.0 : -1.0;
    direction[(face + 1) % 3] = 2.0 * i / cells - 1.0;
    direction[(face + 2) % 3] = 2.0 * j / cells - 1.0;
    const double length = sqrt(direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]);
    const double bump = 1.0 + 0.15 * sin(5.0 * direction[0] / length) * cos(4.0 * direction[1] / length);
    for (unsigned axis = 0; axis < 3; ++axis) {
        out[axis] = rint(center[axis] + direction[axis] / length * radius * bump);
    }
}

enum { SPHERE_CELLS = 7, SPHERE_TRIANGLES = 6 * SPHERE_CELLS * SPHERE_CELLS * 2 };

/* A closed surface; common corners have equal coordinates. */
static void make_sphere(const double center[3], double radius, double *positions)
{
    double *next = positions;
    for (unsigned face = 0; face < 6; ++face) {
        for (unsigned cell = 0; cell < SPHERE_CELLS * SPHERE_CELLS; ++cell) {
            static const unsigned corners[6][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
            for (unsigned k = 0; k < 6; ++k, next += 3) {
                sphere_corner(center, radius, face, cell % SPHERE_CELLS + corners[k][0],
                              cell / SPHERE_CELLS + corners[k][1], SPHERE_CELLS, next);
            }
        }
    }
}

static size_t cell_of(uint64_t voxel)
{
    return ((size_t)axis_of(voxel, 2) * FLOOD_WIDTH + axis_of(voxel, 1)) * FLOOD_WIDTH + axis_of(voxel, 0);
}

/* Marks the empty neighbors of a voxel that the flood fill has not reached yet; neighbors: 6 or 26. */
static size_t flood_from(size_t cell, unsigned neighbors, uint8_t *taken, size_t *stack, size_t depth)
{
    const int at[3] = {(int)(cell % FLOOD_WIDTH), (int)(cell / FLOOD_WIDTH % FLOOD_WIDTH),
                       (int)(cell / FLOOD_WIDTH / FLOOD_WIDTH)};
    for (int step = 0; step < 27; ++step) {
        const int by[3] = {step % 3 - 1, step / 3 % 3 - 1, step / 9 - 1};
        const int moved = abs(by[0]) + abs(by[1]) + abs(by[2]);
        const int to[3] = {at[0] + by[0], at[1] + by[1], at[2] + by[2]};
        bool inside = moved > 0 && (neighbors == 26 || moved == 1);
        for (unsigned axis = 0; axis < 3; ++axis) {
            inside = inside && to[axis] >= 0 && to[axis] < FLOOD_WIDTH;
        }
        const size_t next = inside ? (size_t)((to[2] * FLOOD_WIDTH + to[1]) * FLOOD_WIDTH + to[0]) : 0;
        if (inside && taken[next] == 0) {
            taken[next] = 1;
            stack[depth++] = next;
        }
    }
    return depth;
}

/* Whether a flood fill from the grid's first voxel reaches the target through empty voxels. */
static bool flood_reaches(const voxel_set *walls, unsigned neighbors, uint64_t target)
{
    uint8_t *taken = allocate(FLOOD_VOXELS);
    size_t *stack = allocate(FLOOD_VOXELS * sizeof *stack);
    for (size_t i = 0; i < walls->count; ++i) {
        taken[cell_of(walls->voxels[i])] = 2;
    }
    assert_int_equal(taken[0], 0);
    assert_int_equal(taken[cell_of(target)], 0);
    taken[0] = 1;
    size_t depth = 1;
    while (depth > 0) {
        const size_t cell = stack[--depth];
        depth = flood_from(cell, neighbors, taken, stack, depth);
    }
    const bool reached = taken[cell_of(target)] == 1;
    free(stack);
    free(taken);
    return reached;
}

static bool is_subset(const voxel_set *part, const voxel_set *whole)
{
    for (size_t i = 0; i < part->count; ++i) {
        if (bsearch(&part->voxels[i], whole->voxels, whole->count, sizeof(uint64_t), compare_voxels) == NULL) {
            return false;
        }
    }
    return true;
}

/* Thin and half-open surfaces stop a 6-connected flood fill. Closed ones also stop a 26-connected one, which passes at
   least some of the others. */
static void coverages_separate_inside_from_outside(void **state)
{
    const fixture *opened = fixture_of_group(state);
    unsigned leaks[COVERAGES] = {0};
    for (uint64_t seed = 1; seed <= 12; ++seed) {
        print_message("seed %llu\n", (unsigned long long)seed);
        uint64_t random = seed;
        static double positions[SPHERE_TRIANGLES * 9];
        double center[3];
        for (unsigned axis = 0; axis < 3; ++axis) {
            center[axis] = EDGE * (0.48 + 0.04 * random_unit(&random));
        }
        make_sphere(center, EDGE * (0.1 + 0.25 * random_unit(&random)), positions);
        const svo_mesh mesh = {.struct_size = sizeof mesh,
                               .positions_double = positions,
                               .vertex_count = SPHERE_TRIANGLES * 3,
                               .triangle_count = SPHERE_TRIANGLES};
        const double voxel = EDGE / FLOOD_WIDTH;
        const uint64_t middle =
            pack((uint32_t)(center[0] / voxel), (uint32_t)(center[1] / voxel), (uint32_t)(center[2] / voxel));
        for (unsigned c = 0; c < COVERAGES; ++c) {
            voxel_set walls;
            build_voxels(opened, &mesh, FLOOD_DEPTH, coverages[c], &walls);
            assert_false(flood_reaches(&walls, 6, middle));
            leaks[c] += flood_reaches(&walls, 26, middle);
            free(walls.voxels);
        }
    }
    assert_int_equal(leaks[1], 0);
    print_message("through corners, of 12: half-open %u leak, thin %u\n", leaks[0], leaks[2]);
    assert_true(leaks[2] > 0);
}

static void coverages_are_nested(void **state)
{
    const fixture *opened = fixture_of_group(state);
    for (uint64_t seed = 41; seed <= 46; ++seed) {
        print_message("seed %llu\n", (unsigned long long)seed);
        owned_mesh made;
        voxel_set sets[COVERAGES];
        make_symmetric(seed, 300, &made);
        for (unsigned c = 0; c < COVERAGES; ++c) {
            build_voxels(opened, &made.mesh, 3 + (unsigned)seed % 6, coverages[c], &sets[c]);
        }
        assert_true(is_subset(&sets[2], &sets[0]));
        assert_true(is_subset(&sets[0], &sets[1]));
        assert_true(sets[2].count < sets[0].count && sets[0].count < sets[1].count);
        for (unsigned c = 0; c < COVERAGES; ++c) {
            free(sets[c].voxels);
        }
        owned_mesh_free(&made);
    }
}

/*
 * T16 filter.
 */

enum { FILTER_TRIANGLES = 300, FILTER_DEPTH = 6 };

/* Sums of the pairs below one node of a level, found by the prefix of their codes. */
typedef struct pair_sums {
    uint64_t pairs, color[4]; /* color: red, green and blue times alpha */
} pair_sums;

static void assert_node_color(const built *actual, size_t node, const pair_sums *sums)
{
    for (unsigned channel = 0; channel < 4; ++channel) {
        const uint64_t by = channel < 3 && sums->color[3] > 0 ? sums->color[3] : sums->pairs;
        const uint64_t rounded = (2 * sums->color[channel] + by) / (2 * by);
        const uint64_t mean = channel < 3 ? rounded : payload_alpha(rounded, sums->color[3], sums->pairs);
        if (actual->arrays.colors[node * 4 + channel] != mean) {
            fail_msg("node %zu, channel %u: %u, not %llu / %llu", node, channel,
                     actual->arrays.colors[node * 4 + channel], (unsigned long long)sums->color[channel],
                     (unsigned long long)by);
        }
    }
}

/* Every node of every level is the mean over all pairs of the leaves below it, rounded once. The nodes of a level
   together cover all leaves. */
static void check_filter(const built *actual, const oracle_pairs *pairs, const uint8_t *colors)
{
    for (unsigned level = 0; level <= actual->info.depth; ++level) {
        const unsigned below = 3 * (actual->info.depth - level);
        size_t node = actual->info.level_begin[level];
        pair_sums sums = {0};
        for (size_t i = 0; i < pairs->count; ++i) {
            ++sums.pairs;
            const uint8_t *color = colors + pairs->pairs[i].triangle * 12;
            for (unsigned channel = 0; channel < 4; ++channel) {
                sums.color[channel] += color[channel] * (channel < 3 ? color[3] : 1U);
            }
            if (i + 1 == pairs->count || pairs->pairs[i + 1].code >> below != pairs->pairs[i].code >> below) {
                assert_node_color(actual, node++, &sums);
                sums = (pair_sums){0};
            }
        }
        assert_int_equal(node, actual->info.level_begin[level + 1]);
    }
}

static void t16_sums_of_every_level_equal_those_of_the_leaves(void **state)
{
    const fixture *opened = fixture_of_group(state);
    for (uint64_t seed = 51; seed <= 56; ++seed) {
        print_message("seed %llu\n", (unsigned long long)seed);
        owned_mesh made;
        make_symmetric(seed, FILTER_TRIANGLES, &made);
        uint64_t random = seed;
        static uint8_t colors[FILTER_TRIANGLES * 12];
        for (size_t i = 0; i < sizeof colors; ++i) { /* one color per triangle */
            made.indices[i / 4] = (uint32_t)(i / 4);
            colors[i] = i % 12 < 4 ? (uint8_t)random_word(&random) : colors[i - 4];
        }
        made.mesh.colors = colors;
        const svo_plan_options options = {.need = SVO_NEED_COLOR,
                                          .weights = SVO_WEIGHTS_UNIFORM,
                                          .edge = EDGE,
                                          .coverage = coverages[seed % COVERAGES]};
        built actual;
        exact expected;
        fixture_build(opened, &made.mesh, FILTER_DEPTH, &options, &actual);
        exact_create(&made.mesh, FILTER_DEPTH, &options, &expected);
        assert_tree_is_exact(&actual, &expected);
        check_filter(&actual, &expected.pairs, colors);
        exact_destroy(&expected);
        built_destroy(&actual);
        owned_mesh_free(&made);
    }
}

TEST_GROUP(numerics_invariants)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(t5_mean_count_matches_the_estimate),
        cmocka_unit_test(t6_order_of_the_axes_does_not_matter),
        cmocka_unit_test(t6_closed_coverage_is_mirror_symmetric),
        cmocka_unit_test(t6_order_of_vertices_and_winding_do_not_matter),
        cmocka_unit_test(t6_octants_have_the_same_voxels),
        cmocka_unit_test(coverages_separate_inside_from_outside),
        cmocka_unit_test(coverages_are_nested),
        cmocka_unit_test(t16_sums_of_every_level_equal_those_of_the_leaves),
    };
    return cmocka_run_group_tests_name("numerics_invariants", tests, fixture_group_setup, fixture_group_teardown);
}
