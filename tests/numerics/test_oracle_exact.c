/* SPDX-License-Identifier: MIT */
/*
 * Tests the exact references of meshes as given. Separating axes and clipping agree, and the list of all pairs with
 * both, on triangles that are hard for an overlap test in doubles: vertices an ulp beside planes, edges through
 * corners, corners that are grazed, needles, far grids, mixed exponents, edges that are no power of two. Where the
 * truth is known otherwise it is compared: points beside planes, and meshes of small integers, which are their own
 * snapped meshes.
 *
 * The seed is printed and can be set: SVOCL_TEST_SEED=n test_oracle oracle_exact.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "oracle_exact.h"
#include "support/suite.h"

#define CASES_PER_SPACE 14

static const oracle_coverage coverages[] = {ORACLE_HALF_OPEN, ORACLE_CLOSED, ORACLE_THIN};

static uint64_t random_state;

/* splitmix64 */
static uint64_t next_random(void)
{
    uint64_t z = random_state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return z ^ z >> 31;
}

/* Uniform in low .. high, both inclusive. */
static int between(int low, int high)
{
    return low + (int)(next_random() % (uint64_t)(high - low + 1));
}

static double uniform(void)
{
    return (double)(next_random() >> 11) * 0x1p-53;
}

/* ---- grids and triangles ---- */

/* Grids without their depth. */
static const oracle_space spaces[] = {
    {{0.0, 0.0, 0.0}, 1.0, 0},          {{0.1, -0.2, 0.3}, 0.7, 0},
    {{-1.0, 1.5, 0.0}, 3.0, 0},         {{0.0, 1.0 / 3.0, -1.0 / 7.0}, 1.0 / 3.0, 0},
    {{1e6, -1e6, 1e6}, 1.0, 0},         {{-0.81, -0.5, 0.25}, 1.62, 0},
    {{0.0, 0.0, 0.0}, 0x1.000012p0, 0}, {{-1e-40, 0.0, 1e-40}, 1e-38, 0},
    {{0.0, -1e300, 1e300}, 1e301, 0},
};
#define SPACE_COUNT (sizeof spaces / sizeof spaces[0])

/* The double next to plane `at` of an axis; between planes for values with a fraction. */
static double position_at(const oracle_space *space, int axis, double at)
{
    return space->origin[axis] + at * (space->edge / ldexp(1.0, (int)space->depth));
}

/* So many ulps up, or down. */
static double moved(double value, int ulps)
{
    for (; ulps != 0; ulps += ulps > 0 ? -1 : 1) {
        value = nextafter(value, ulps > 0 ? (double)INFINITY : -(double)INFINITY);
    }
    return value;
}

/* Cells that the case is about. */
typedef struct sample {
    oracle_space space;
    oracle_exact_triangle triangle;
    int32_t cell[3];
} sample;

/* In voxels from the first corner of s->cell, moved by a few ulps of the position. */
static void set_vertex(sample *s, int vertex, double x, double y, double z, int ulps)
{
    const double at[3] = {x, y, z};
    for (int k = 0; k < 3; ++k) {
        s->triangle.vertices[vertex][k] =
            moved(position_at(&s->space, k, (double)s->cell[k] + at[k]), between(-ulps, ulps));
    }
}

/* Every vertex an ulp beside planes, or on them. */
static void make_beside_planes(sample *s)
{
    for (int i = 0; i < 3; ++i) {
        set_vertex(s, i, between(-1, 2), between(-1, 2), between(-1, 2), 1);
    }
}

/* Halves of voxels: touches in corners, edges and faces, many of them degenerate. */
static void make_lattice(sample *s)
{
    for (int i = 0; i < 3; ++i) {
        set_vertex(s, i, between(-2, 4) * 0.5, between(-2, 4) * 0.5, between(-2, 4) * 0.5, 0);
    }
}

/* A long edge through a corner of the cell, within ulps. */
static void make_edge_through_corner(sample *s)
{
    const double reach = ldexp(1.0, between(-3, 4));
    const double step[3] = {reach * between(-3, 3), reach * between(-3, 3), reach * between(-3, 3)};
    const int corner[3] = {between(0, 1), between(0, 1), between(0, 1)};
    set_vertex(s, 0, corner[0] - step[0], corner[1] - step[1], corner[2] - step[2], 1);
    set_vertex(s, 1, corner[0] + step[0], corner[1] + step[1], corner[2] + step[2], 1);
    set_vertex(s, 2, 6.0 * uniform() - 3.0, 6.0 * uniform() - 3.0, 6.0 * uniform() - 3.0, 0);
}

/* A plane that cuts a corner off, or misses it, by less than 2^-40 of the grid's edge. */
static void make_grazing(sample *s)
{
    const double reach = 1.0 + uniform();
    const double depth = ldexp(uniform() - 0.5, (int)s->space.depth - between(40, 56));
    set_vertex(s, 0, reach + depth, 0.0, 0.0, 0);
    set_vertex(s, 1, -reach, reach, depth, 0);
    set_vertex(s, 2, 0.0, -reach, reach + depth, 0);
}

/* A third vertex within ulps of the segment between the others. */
static void make_needle(sample *s)
{
    const double share = uniform();
    set_vertex(s, 0, 40.0 * uniform() - 20.0, 40.0 * uniform() - 20.0, 2.0 * uniform() - 1.0, 0);
    set_vertex(s, 1, 40.0 * uniform() - 20.0, 2.0 * uniform() - 1.0, 40.0 * uniform() - 20.0, 0);
    for (int k = 0; k < 3; ++k) {
        const double *a = s->triangle.vertices[0];
        const double *b = s->triangle.vertices[1];
        s->triangle.vertices[2][k] = moved(a[k] + share * (b[k] - a[k]), between(-2, 2));
    }
}

/* A segment or a point. */
static void make_degenerate(sample *s)
{
    make_edge_through_corner(s);
    memcpy(s->triangle.vertices[2], s->triangle.vertices[between(0, 1)], sizeof s->triangle.vertices[2]);
    if (between(0, 2) == 0) {
        set_vertex(s, 0, between(0, 1), between(0, 1), between(0, 1), 1);
        memcpy(s->triangle.vertices[1], s->triangle.vertices[0], sizeof s->triangle.vertices[1]);
        memcpy(s->triangle.vertices[2], s->triangle.vertices[0], sizeof s->triangle.vertices[2]);
    }
}

/* Tiny and huge numbers beside those of the grid. */
static void make_mixed_exponents(sample *s)
{
    static const double values[] = {0x1p-62, -0x1p-62, -0.8, 0.8, 0.0, 1e-308, 0x1p-1074, 1e15, -1e30, 1e200, 0.5};
    for (int i = 0; i < 9; ++i) {
        const double value = values[between(0, (int)(sizeof values / sizeof values[0]) - 1)];
        const double other = position_at(&s->space, i % 3, s->cell[i % 3] + between(0, 1));
        s->triangle.vertices[i / 3][i % 3] = between(0, 2) == 0 ? other : value;
    }
}

/* What any mesh has. */
static void make_plain(sample *s)
{
    for (int i = 0; i < 3; ++i) {
        set_vertex(s, i, 6.0 * uniform() - 2.5, 6.0 * uniform() - 2.5, 6.0 * uniform() - 2.5, 0);
    }
}

/* ---- three ways to decide ---- */

static void print_sample(const sample *s, const int32_t cell[3])
{
    print_error("triangle");
    for (int i = 0; i < 9; ++i) {
        print_error(" %a", s->triangle.vertices[i / 3][i % 3]);
    }
    print_error(", origin %a %a %a edge %a depth %u, cell %d %d %d\n", s->space.origin[0], s->space.origin[1],
                s->space.origin[2], s->space.edge, s->space.depth, cell[0], cell[1], cell[2]);
}

static bool is_listed(const oracle_pairs *pairs, uint64_t code)
{
    size_t first = 0;
    size_t end = pairs->count;
    while (first < end) {
        const size_t middle = first + (end - first) / 2;
        if (pairs->pairs[middle].code < code) {
            first = middle + 1;
        } else {
            end = middle;
        }
    }
    return first < pairs->count && pairs->pairs[first].code == code;
}

typedef struct tally {
    unsigned touched, missed;
} tally;

/* One cell by separating axes, by clipping and as listed. */
static void check_cell(const sample *s, const oracle_pairs *pairs, const int32_t cell[3], oracle_coverage coverage,
                       tally *counts)
{
    const int32_t cells = (int32_t)1 << s->space.depth;
    bool in_grid = true;
    for (int k = 0; k < 3; ++k) {
        in_grid = in_grid && cell[k] >= 0 && cell[k] < cells;
    }
    const bool axes = oracle_exact_touches(&s->triangle, &s->space, cell, coverage);
    const bool clip = oracle_exact_clip_touches(&s->triangle, &s->space, cell, coverage);
    const bool listed = in_grid && is_listed(pairs, oracle_voxel_code((uint32_t)cell[0], (uint32_t)cell[1],
                                                                      (uint32_t)cell[2], s->space.depth));
    if (axes != clip || (in_grid && listed != axes)) {
        print_sample(s, cell);
        fail_msg("coverage %d: by axes %d, by clipping %d, listed %d", (int)coverage, axes, clip, listed);
    }
    counts->touched += axes;
    counts->missed += !axes;
}

static oracle_pairs list_of(const sample *s, oracle_coverage coverage)
{
    const oracle_positions mesh = {&s->triangle.vertices[0][0], 3, NULL, 1};
    oracle_pairs pairs;
    assert_true(oracle_exact_enumerate(&mesh, &s->space, coverage, &pairs));
    return pairs;
}

/* The cells around s->cell, and beside some that are listed. */
static void check_sample(const sample *s, tally *counts)
{
    for (int c = 0; c < 3; ++c) {
        oracle_pairs pairs = list_of(s, coverages[c]);
        for (int i = 0; i < 8; ++i) {
            const int32_t cell[3] = {s->cell[0] - (i & 1), s->cell[1] - (i >> 1 & 1), s->cell[2] - (i >> 2 & 1)};
            check_cell(s, &pairs, cell, coverages[c], counts);
        }
        for (int i = 0; pairs.count > 0 && i < 6; ++i) {
            const uint64_t code = pairs.pairs[next_random() % pairs.count].code;
            int32_t cell[3] = {0, 0, 0};
            for (unsigned bit = 0; bit < 3 * s->space.depth; ++bit) {
                cell[bit % 3] |= (int32_t)(code >> bit & 1) << bit / 3;
            }
            cell[i % 3] += between(-1, 1);
            check_cell(s, &pairs, cell, coverages[c], counts);
        }
        oracle_pairs_free(&pairs);
    }
}

/* every_depth: triangles are a few voxels large, so that their lists are short at any depth. */
static void check_kind(void (*make)(sample *), bool every_depth)
{
    tally counts = {0, 0};
    for (size_t i = 0; i < SPACE_COUNT * CASES_PER_SPACE; ++i) {
        sample s = {.space = spaces[i % SPACE_COUNT]};
        s.space.depth = (unsigned)between(1, every_depth ? 16 : 5);
        for (int k = 0; k < 3; ++k) {
            s.cell[k] = between(0, (1 << s.space.depth) - 1);
        }
        make(&s);
        check_sample(&s, &counts);
    }
    print_message("%u touched, %u missed\n", counts.touched, counts.missed);
    assert_true(counts.touched > 200);
    assert_true(counts.missed > 200);
}

#define KIND_TEST(name, every_depth)               \
    static void methods_agree_##name(void **state) \
    {                                              \
        (void)state;                               \
        check_kind(make_##name, every_depth);      \
    }

KIND_TEST(beside_planes, true)
KIND_TEST(lattice, true)
KIND_TEST(edge_through_corner, true)
KIND_TEST(grazing, true)
KIND_TEST(needle, true)
KIND_TEST(degenerate, true)
KIND_TEST(mixed_exponents, false)
KIND_TEST(plain, true)

/* Every voxel of small grids, listed or not. */
static void lists_are_complete(void **state)
{
    static void (*const makers[])(sample *) = {make_lattice, make_plain, make_edge_through_corner, make_degenerate,
                                               make_beside_planes};
    tally counts = {0, 0};
    (void)state;
    for (size_t i = 0; i < 10 * SPACE_COUNT; ++i) {
        sample s = {.space = spaces[i % SPACE_COUNT], .cell = {1, 1, 1}};
        s.space.depth = 2;
        makers[i % (sizeof makers / sizeof makers[0])](&s);
        for (int c = 0; c < 3; ++c) {
            oracle_pairs pairs = list_of(&s, coverages[c]);
            for (int32_t at = 0; at < 64; ++at) {
                const int32_t cell[3] = {at & 3, at >> 2 & 3, at >> 4};
                check_cell(&s, &pairs, cell, coverages[c], &counts);
            }
            oracle_pairs_free(&pairs);
        }
    }
    assert_true(counts.touched > 1000 && counts.missed > 1000);
}

/* ---- truths known otherwise ---- */

/* The only voxel of a point along the diagonal. */
static int32_t cell_of_point(const oracle_space *space, double at)
{
    sample s = {.space = *space, .triangle = {{{at, at, at}, {at, at, at}, {at, at, at}}}};
    oracle_pairs pairs = list_of(&s, ORACLE_HALF_OPEN);
    int32_t cell = 0;
    assert_int_equal(pairs.count, 1);
    for (unsigned bit = 0; bit < space->depth; ++bit) {
        cell |= (int32_t)(pairs.pairs[0].code >> 3 * bit & 1) << bit;
    }
    oracle_pairs_free(&pairs);
    return cell;
}

/* Points on planes and an ulp beside them. On edges that are no power of two a plane lies between doubles; the
   remainder of the product says on which side. */
static void points_lie_on_their_side_of_planes(void **state)
{
    static const double edges[] = {1.0, 0.7, 3.0, 1.0 / 3.0, 0.1, 1e-30};
    unsigned below = 0;
    (void)state;
    for (size_t e = 0; e < sizeof edges / sizeof edges[0]; ++e) {
        const oracle_space space = {{0.0, 0.0, 0.0}, edges[e], 9};
        for (int plane = 1; plane < 512; ++plane) {
            const double product = plane * edges[e];
            const double remainder = fma(plane, edges[e], -product); /* plane's real place minus the double's */
            const double at = ldexp(product, -9);
            const bool is_below = remainder > 0.0;
            assert_int_equal(cell_of_point(&space, at), is_below ? plane - 1 : plane);
            assert_int_equal(cell_of_point(&space, moved(at, 1)), plane);
            assert_int_equal(cell_of_point(&space, moved(at, -1)), plane - 1);
            below += is_below;
        }
    }
    assert_true(below > 300);
}

/* A fitted grid ends behind the mesh. */
static void fitted_grids_place_planes(void **state)
{
    const oracle_space space = {{0.0, 0.0, 0.0}, 0x1.000012p0, 10};
    const double middle = 0.5 * 0x1.000012p0;
    (void)state;
    assert_int_equal(cell_of_point(&space, 1.0), 1023);
    assert_int_equal(cell_of_point(&space, moved(middle, -1)), 511);
    assert_int_equal(cell_of_point(&space, moved(middle, 1)), 512);
}

static void assert_same_pairs(const oracle_pairs *expected, const oracle_pairs *actual)
{
    oracle_difference difference;
    oracle_compare(expected, actual, &difference);
    assert_int_equal(difference.missed_pairs, 0);
    assert_int_equal(difference.surplus_pairs, 0);
}

#define MESH_TRIANGLES 60

/* A mesh of integers is its own snapped mesh, in any origin and edge whose products are exact. */
static void integers_are_their_own_snapped_mesh(void **state)
{
    int32_t vertices[MESH_TRIANGLES * 9];
    double positions[MESH_TRIANGLES * 9];
    const oracle_mesh snapped = {vertices, NULL, NULL, MESH_TRIANGLES};
    const oracle_positions given = {positions, (size_t)MESH_TRIANGLES * 3, NULL, MESH_TRIANGLES};
    size_t pair_count = 0;
    (void)state;
    for (int round = 0; round < 24; ++round) {
        const unsigned depth = (unsigned)between(3, 6);
        const double step = ldexp(1.0, between(-30, 5)); /* of the grid in the positions */
        const oracle_space space = {{step * 3.0, step * -5.0, 0.0}, 256.0 * step, depth};
        for (int i = 0; i < MESH_TRIANGLES * 9; ++i) {
            const int base = i % 9 < 3 || round % 2 == 0 ? between(-40, 300) : vertices[i - 3];
            vertices[i] = base + between(-9, 9);
            positions[i] = space.origin[i % 3] + vertices[i] * step;
        }
        for (int c = 0; c < 3; ++c) {
            const oracle_request request = {depth, 8, coverages[c], ORACLE_CLIP};
            oracle_pairs expected;
            oracle_pairs actual;
            assert_true(oracle_enumerate(&snapped, &request, &expected));
            assert_true(oracle_exact_enumerate(&given, &space, coverages[c], &actual));
            assert_same_pairs(&expected, &actual);
            pair_count += expected.count;
            oracle_pairs_free(&expected);
            oracle_pairs_free(&actual);
        }
    }
    print_message("%zu pairs\n", pair_count);
    assert_true(pair_count > 10000);
}

/* Triangles with an index out of range or a vertex that is not finite are left out, and so are grids out of range. */
static void what_is_no_triangle_is_left_out(void **state)
{
    static const double positions[] = {0.1, 0.1, 0.1, 0.2, 0.1, 0.1, 0.1, 0.2, 0.1, 0.3, (double)NAN, 0.3};
    static const uint32_t indices[] = {0, 1, 3, 0, 1, 4, 0, 1, 2};
    const oracle_positions mesh = {positions, 4, indices, 3};
    oracle_space space = {{0.0, 0.0, 0.0}, 1.0, 1};
    oracle_pairs pairs;
    (void)state;
    assert_true(oracle_exact_enumerate(&mesh, &space, ORACLE_HALF_OPEN, &pairs));
    assert_int_equal(pairs.count, 1);
    assert_int_equal(pairs.pairs[0].code, 0);
    assert_int_equal(pairs.pairs[0].triangle, 2);
    oracle_pairs_free(&pairs);
    space.depth = ORACLE_DEPTH_MAX + 1;
    assert_false(oracle_exact_enumerate(&mesh, &space, ORACLE_HALF_OPEN, &pairs));
    space = (oracle_space){{0.0, (double)INFINITY, 0.0}, 1.0, 1};
    assert_false(oracle_exact_enumerate(&mesh, &space, ORACLE_HALF_OPEN, &pairs));
    space = (oracle_space){{0.0, 0.0, 0.0}, 0.0, 1};
    assert_false(oracle_exact_enumerate(&mesh, &space, ORACLE_HALF_OPEN, &pairs));
    assert_null(pairs.pairs);
}

TEST_GROUP(oracle_exact)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(methods_agree_beside_planes),
        cmocka_unit_test(methods_agree_lattice),
        cmocka_unit_test(methods_agree_edge_through_corner),
        cmocka_unit_test(methods_agree_grazing),
        cmocka_unit_test(methods_agree_needle),
        cmocka_unit_test(methods_agree_degenerate),
        cmocka_unit_test(methods_agree_mixed_exponents),
        cmocka_unit_test(methods_agree_plain),
        cmocka_unit_test(lists_are_complete),
        cmocka_unit_test(points_lie_on_their_side_of_planes),
        cmocka_unit_test(fitted_grids_place_planes),
        cmocka_unit_test(integers_are_their_own_snapped_mesh),
        cmocka_unit_test(what_is_no_triangle_is_left_out),
    };
    const char *seed = getenv("SVOCL_TEST_SEED");
    random_state = seed != NULL ? strtoull(seed, NULL, 10) : 20240607;
    print_message("seed %llu\n", (unsigned long long)random_state);
    return cmocka_run_group_tests_name("oracle_exact", tests, NULL, NULL);
}
