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

#include "hard_cases.h"
#include "support/suite.h"

#define CASES_PER_SPACE 14

static const oracle_coverage coverages[] = {ORACLE_HALF_OPEN, ORACLE_CLOSED, ORACLE_THIN};

/* ---- three ways to decide ---- */

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
static void check_cell(const hard_case *s, const oracle_pairs *pairs, const int32_t cell[3], oracle_coverage coverage,
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
        hard_case_print(s, cell);
        fail_msg("coverage %d: by axes %d, by clipping %d, listed %d", (int)coverage, axes, clip, listed);
    }
    counts->touched += axes;
    counts->missed += !axes;
}

static oracle_pairs list_of(const hard_case *s, oracle_coverage coverage)
{
    const oracle_positions mesh = {&s->triangle.vertices[0][0], 3, NULL, 1};
    oracle_pairs pairs;
    assert_true(oracle_exact_enumerate(&mesh, &s->space, coverage, &pairs));
    return pairs;
}

/* The cells around s->cell, and beside some that are listed. */
static void check_sample(const hard_case *s, tally *counts)
{
    for (int c = 0; c < 3; ++c) {
        oracle_pairs pairs = list_of(s, coverages[c]);
        for (int i = 0; i < 8; ++i) {
            const int32_t cell[3] = {s->cell[0] - (i & 1), s->cell[1] - (i >> 1 & 1), s->cell[2] - (i >> 2 & 1)};
            check_cell(s, &pairs, cell, coverages[c], counts);
        }
        for (int i = 0; pairs.count > 0 && i < 6; ++i) {
            const uint64_t code = pairs.pairs[hard_random() % pairs.count].code;
            int32_t cell[3] = {0, 0, 0};
            for (unsigned bit = 0; bit < 3 * s->space.depth; ++bit) {
                cell[bit % 3] |= (int32_t)(code >> bit & 1) << bit / 3;
            }
            cell[i % 3] += hard_between(-1, 1);
            check_cell(s, &pairs, cell, coverages[c], counts);
        }
        oracle_pairs_free(&pairs);
    }
}

static void methods_agree(void **state)
{
    const hard_kind *kind = *state;
    tally counts = {0, 0};
    for (size_t i = 0; i < (size_t)HARD_SPACES * CASES_PER_SPACE; ++i) {
        hard_case s;
        hard_case_make(*kind, i, &s);
        check_sample(&s, &counts);
    }
    print_message("%s: %u touched, %u missed\n", hard_kind_name(*kind), counts.touched, counts.missed);
    assert_true(counts.touched > 200);
    assert_true(counts.missed > 200);
}

/* Every voxel of small grids, listed or not. */
static void lists_are_complete(void **state)
{
    static const hard_kind kinds[] = {HARD_LATTICE, HARD_PLAIN, HARD_EDGE_THROUGH_CORNER, HARD_DEGENERATE,
                                      HARD_BESIDE_PLANES};
    tally counts = {0, 0};
    (void)state;
    for (size_t i = 0; i < (size_t)10 * HARD_SPACES; ++i) {
        hard_case s;
        hard_case_make(HARD_PLAIN, i, &s);
        s.space.depth = 2;
        s.cell[0] = s.cell[1] = s.cell[2] = 1;
        hard_case_fill(kinds[i % (sizeof kinds / sizeof kinds[0])], &s);
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
    const hard_case s = {.space = *space, .triangle = {{{at, at, at}, {at, at, at}, {at, at, at}}}};
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
            assert_int_equal(cell_of_point(&space, hard_move(at, 1)), plane);
            assert_int_equal(cell_of_point(&space, hard_move(at, -1)), plane - 1);
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
    assert_int_equal(cell_of_point(&space, hard_move(middle, -1)), 511);
    assert_int_equal(cell_of_point(&space, hard_move(middle, 1)), 512);
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
        const unsigned depth = (unsigned)hard_between(3, 6);
        const double step = ldexp(1.0, hard_between(-30, 5)); /* of the grid in the positions */
        const oracle_space space = {{step * 3.0, step * -5.0, 0.0}, 256.0 * step, depth};
        for (int i = 0; i < MESH_TRIANGLES * 9; ++i) {
            const int base = i % 9 < 3 || round % 2 == 0 ? hard_between(-40, 300) : vertices[i - 3];
            vertices[i] = base + hard_between(-9, 9);
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
    space.depth = ORACLE_EXACT_DEPTH_MAX + 1;
    assert_false(oracle_exact_enumerate(&mesh, &space, ORACLE_HALF_OPEN, &pairs));
    space = (oracle_space){{0.0, (double)INFINITY, 0.0}, 1.0, 1};
    assert_false(oracle_exact_enumerate(&mesh, &space, ORACLE_HALF_OPEN, &pairs));
    space = (oracle_space){{0.0, 0.0, 0.0}, 0.0, 1};
    assert_false(oracle_exact_enumerate(&mesh, &space, ORACLE_HALF_OPEN, &pairs));
    assert_null(pairs.pairs);
}

/* Lists below the nodes of a level are that of the whole, cut. */
static void lists_below_nodes(void **state)
{
    static const double positions[] = {0.1,  0.1, 0.1, 0.9, 0.2, 0.5, 0.3, 0.8, 0.7,
                                       -1.0, 0.5, 0.5, 2.0, 0.5, 0.5, 0.5, 2.0, 0.6};
    const oracle_positions mesh = {positions, 6, NULL, 2};
    const oracle_space space = {{0.0, 0.0, 0.0}, 1.0, 5};
    (void)state;
    for (int c = 0; c < 3; ++c) {
        oracle_pairs whole, below;
        size_t seen = 0;
        assert_true(oracle_exact_enumerate(&mesh, &space, coverages[c], &whole));
        for (uint64_t code = 0; code < 64; ++code) {
            assert_true(oracle_exact_enumerate_below(&mesh, &space, coverages[c], 2, code, &below));
            for (size_t i = 0; i < below.count; ++i, ++seen) {
                assert_memory_equal(&below.pairs[i].code, &whole.pairs[seen].code, sizeof below.pairs[i].code);
                assert_int_equal(below.pairs[i].triangle, whole.pairs[seen].triangle);
                assert_int_equal(below.pairs[i].code >> 9, code);
            }
            oracle_pairs_free(&below);
        }
        assert_int_equal(seen, whole.count);
        assert_false(oracle_exact_enumerate_below(&mesh, &space, coverages[c], 2, 64, &below));
        oracle_pairs_free(&whole);
    }
}

TEST_GROUP(oracle_exact)
{
    static hard_kind kinds[HARD_KINDS] = {HARD_BESIDE_PLANES, HARD_LATTICE,    HARD_EDGE_THROUGH_CORNER, HARD_GRAZING,
                                          HARD_NEEDLE,        HARD_DEGENERATE, HARD_MIXED_EXPONENTS,     HARD_PLAIN};
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_prestate(methods_agree, &kinds[0]),
        cmocka_unit_test_prestate(methods_agree, &kinds[1]),
        cmocka_unit_test_prestate(methods_agree, &kinds[2]),
        cmocka_unit_test_prestate(methods_agree, &kinds[3]),
        cmocka_unit_test_prestate(methods_agree, &kinds[4]),
        cmocka_unit_test_prestate(methods_agree, &kinds[5]),
        cmocka_unit_test_prestate(methods_agree, &kinds[6]),
        cmocka_unit_test_prestate(methods_agree, &kinds[7]),
        cmocka_unit_test(lists_are_complete),
        cmocka_unit_test(points_lie_on_their_side_of_planes),
        cmocka_unit_test(fitted_grids_place_planes),
        cmocka_unit_test(integers_are_their_own_snapped_mesh),
        cmocka_unit_test(what_is_no_triangle_is_left_out),
        cmocka_unit_test(lists_below_nodes),
    };
    const char *seed_text = getenv("SVOCL_TEST_SEED");
    const uint64_t seed = seed_text != NULL ? strtoull(seed_text, NULL, 10) : 20240607;
    hard_cases_seed(seed);
    print_message("seed %llu\n", (unsigned long long)seed);
    return cmocka_run_group_tests_name("oracle_exact", tests, NULL, NULL);
}
