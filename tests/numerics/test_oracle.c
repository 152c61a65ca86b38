/* SPDX-License-Identifier: MIT */
/*
 * Tests the exact references (tools/lab/reference). Both give the golden counts, the same pairs and the counts known in
 * closed form. The octree walk agrees with brute force over all voxels. test_oracle_tree.c tests sorting, comparing and
 * trees, test_oracle_random.c single pairs.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "oracle.h"
#include "support/golden.h"
#include "support/suite.h"

#define SNAP_BITS  20
#define COORDINATE ((1 << SNAP_BITS) - 1) /* the largest coordinate of the default grid */

static const char *const coverage_names[] = {"half-open", "closed"};
static const char *const method_names[] = {"sat", "clip"};

static oracle_pairs enumerate(const oracle_mesh *mesh, unsigned depth, oracle_coverage coverage, oracle_method method)
{
    const oracle_request request = {depth, SNAP_BITS, coverage, method};
    oracle_pairs pairs;

    assert_true(oracle_enumerate(mesh, &request, &pairs));
    return pairs;
}

static void assert_same_pairs(const oracle_pairs *expected, const oracle_pairs *actual)
{
    oracle_difference difference;

    oracle_compare(expected, actual, &difference);
    assert_int_equal(difference.missed_pairs, 0);
    assert_int_equal(difference.surplus_pairs, 0);
    assert_int_equal(difference.missed_voxels, 0);
    assert_int_equal(difference.surplus_voxels, 0);
}

/* Runs both references on one mesh, checks that they agree and returns the list. */
static oracle_pairs enumerate_both(const oracle_mesh *mesh, unsigned depth, oracle_coverage coverage)
{
    oracle_pairs sat = enumerate(mesh, depth, coverage, ORACLE_SAT);
    oracle_pairs clip = enumerate(mesh, depth, coverage, ORACLE_CLIP);

    assert_same_pairs(&sat, &clip);
    oracle_pairs_free(&clip);
    return sat;
}

static bool check_count(const golden_scene *scene, const golden_count *count, oracle_method method)
{
    const oracle_mesh mesh = {scene->vertices, NULL, NULL, scene->triangle_count};
    oracle_coverage coverage = count->is_closed ? ORACLE_CLOSED : ORACLE_HALF_OPEN;
    oracle_pairs pairs = enumerate(&mesh, count->depth, coverage, method);
    uint64_t voxel_count = oracle_pairs_voxel_count(&pairs);
    bool is_equal = voxel_count == count->voxels && pairs.count == count->pairs;

    if (!is_equal)
        print_error("%s %s depth %u, %s: %llu voxels and %llu pairs, expected %llu and %llu\n", scene->name,
                    coverage_names[coverage], count->depth, method_names[method], (unsigned long long)voxel_count,
                    (unsigned long long)pairs.count, (unsigned long long)count->voxels,
                    (unsigned long long)count->pairs);
    oracle_pairs_free(&pairs);
    return is_equal;
}

static void golden_counts_are_reproduced(void **state)
{
    golden_table *table = golden_load(GOLDEN_COUNTS_PATH);
    size_t checked = 0, wrong = 0;

    (void)state;
    assert_non_null(table);
    for (size_t s = 0; s < table->scene_count; s++) {
        for (size_t i = 0; i < table->scenes[s].count_count; i++) {
            wrong += !check_count(&table->scenes[s], &table->scenes[s].counts[i], ORACLE_SAT);
            wrong += !check_count(&table->scenes[s], &table->scenes[s].counts[i], ORACLE_CLIP);
            checked++;
        }
    }
    golden_free(table);
    assert_int_equal(wrong, 0);
    assert_in_range(checked, 200, SIZE_MAX);
}

/* Compares single pairs at the deepest level of each golden scene; the levels above are its ancestors. */
static void golden_pairs_agree(void **state)
{
    golden_table *table = golden_load(GOLDEN_COUNTS_PATH);

    (void)state;
    assert_non_null(table);
    for (size_t s = 0; s < table->scene_count; s++) {
        const golden_scene *scene = &table->scenes[s];
        const oracle_mesh mesh = {scene->vertices, NULL, NULL, scene->triangle_count};

        for (size_t i = 0; i < scene->count_count; i++) {
            const golden_count *count = &scene->counts[i];
            oracle_pairs pairs;

            if (i + 1 < scene->count_count && scene->counts[i + 1].depth > count->depth)
                continue;
            pairs = enumerate_both(&mesh, count->depth, count->is_closed ? ORACLE_CLOSED : ORACLE_HALF_OPEN);
            oracle_pairs_free(&pairs);
        }
    }
    golden_free(table);
}

/* The two triangles of the face of the full cube where axis has the given value. */
static void add_cube_face(int32_t *vertices, int axis, int32_t value)
{
    static const int32_t corners[6][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};

    for (int i = 0; i < 6; i++) {
        vertices[3 * i + axis] = value;
        vertices[3 * i + (axis + 1) % 3] = corners[i][0] * COORDINATE;
        vertices[3 * i + (axis + 2) % 3] = corners[i][1] * COORDINATE;
    }
}

/* The hull of a cube with an edge of r voxels has r^3 - (r - 2)^3 voxels. */
static void cube_hull_has_its_closed_form(void **state)
{
    int32_t vertices[6 * 18];
    const oracle_mesh mesh = {vertices, NULL, NULL, 12};

    (void)state;
    for (int face = 0; face < 6; face++)
        add_cube_face(vertices + 18 * face, face % 3, face < 3 ? 0 : COORDINATE);
    for (unsigned depth = 1; depth <= 8; depth++) {
        uint64_t r = 1u << depth;

        for (int coverage = 0; coverage < 2; coverage++) {
            oracle_pairs pairs = enumerate_both(&mesh, depth, (oracle_coverage)coverage);

            assert_int_equal(oracle_pairs_voxel_count(&pairs), 8 + 12 * (r - 2) + 6 * (r - 2) * (r - 2));
            oracle_pairs_free(&pairs);
        }
    }
}

/* A quad between two layers of voxels belongs to the upper layer, with closed coverage to both. */
static void mid_plane_has_its_closed_form(void **state)
{
    (void)state;
    for (int axis = 0; axis < 3; axis++) {
        int32_t vertices[18];
        const oracle_mesh mesh = {vertices, NULL, NULL, 2};

        add_cube_face(vertices, axis, 1 << (SNAP_BITS - 1));
        for (unsigned depth = 1; depth <= 8; depth++) {
            oracle_pairs half_open = enumerate_both(&mesh, depth, ORACLE_HALF_OPEN);
            oracle_pairs closed = enumerate_both(&mesh, depth, ORACLE_CLOSED);

            assert_int_equal(oracle_pairs_voxel_count(&half_open), UINT64_C(1) << 2 * depth);
            assert_int_equal(oracle_pairs_voxel_count(&closed), UINT64_C(2) << 2 * depth);
            oracle_pairs_free(&half_open);
            oracle_pairs_free(&closed);
        }
    }
}

/* A point has one half-open voxel; a lattice point has eight closed ones. */
static void points_have_their_voxels(void **state)
{
    const int32_t lattice = 5 << (SNAP_BITS - 4);
    const int32_t points[3][3] = {{123456, 7, COORDINATE}, {0, 0, 0}, {lattice, lattice, lattice}};
    const uint64_t closed_counts[3] = {1, 1, 8};

    (void)state;
    for (size_t p = 0; p < 3; p++) {
        const uint32_t indices[3] = {0, 0, 0};
        const oracle_mesh mesh = {points[p], indices, NULL, 1};

        for (unsigned depth = 4; depth <= 12; depth++) {
            unsigned shift = SNAP_BITS - depth;
            oracle_pairs half_open = enumerate_both(&mesh, depth, ORACLE_HALF_OPEN);
            oracle_pairs closed = enumerate_both(&mesh, depth, ORACLE_CLOSED);

            assert_int_equal(half_open.count, 1);
            assert_int_equal(half_open.pairs[0].code,
                             oracle_voxel_code((uint32_t)points[p][0] >> shift, (uint32_t)points[p][1] >> shift,
                                               (uint32_t)points[p][2] >> shift, depth));
            assert_int_equal(closed.count, closed_counts[p]);
            oracle_pairs_free(&half_open);
            oracle_pairs_free(&closed);
        }
    }
}

/* The grid includes its near faces, and its far faces with closed coverage only; a coordinate of 2^29 is refused. The
   triangle lies in a plane of constant x and covers the grid's cross-section, with a vertex at y = reach. */
static void triangles_outside_touch_nothing(void **state)
{
    const int32_t end = 1 << SNAP_BITS, limit = 1 << 29;
    const struct {
        int32_t x, reach;
        uint64_t half_open, closed;
    } cases[] = {
        {-1, 4 * end, 0, 0},    {0, 4 * end, 16, 16},     {end - 1, 4 * end, 16, 16},
        {end, 4 * end, 0, 16},  {end + 1, 4 * end, 0, 0}, {-1 - limit / 2, 4 * end, 0, 0},
        {0, limit - 1, 16, 16}, {0, limit, 0, 0},         {1 - limit, 4 * end, 0, 0},
    };

    (void)state;
    for (size_t c = 0; c < sizeof(cases) / sizeof(cases[0]); c++) {
        const int32_t x = cases[c].x;
        const int32_t vertices[9] = {x, -end, -end, x, cases[c].reach, -end, x, -end, 4 * end};
        const oracle_mesh mesh = {vertices, NULL, NULL, 1};
        oracle_pairs half_open = enumerate_both(&mesh, 2, ORACLE_HALF_OPEN);
        oracle_pairs closed = enumerate_both(&mesh, 2, ORACLE_CLOSED);

        assert_int_equal(half_open.count, cases[c].half_open);
        assert_int_equal(closed.count, cases[c].closed);
        oracle_pairs_free(&half_open);
        oracle_pairs_free(&closed);
    }
}

static uint64_t next_random(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return *state >> 33;
}

/* Tests every voxel of the grid against every triangle, in the order of the list. */
static oracle_pairs ask_every_voxel(const oracle_triangle *triangles, size_t count, unsigned depth,
                                    oracle_coverage coverage, oracle_method method)
{
    oracle_pairs pairs = {malloc((count << 3 * depth) * sizeof(oracle_pair)), 0};

    assert_non_null(pairs.pairs);
    for (uint64_t code = 0; code < UINT64_C(1) << 3 * depth; code++) {
        oracle_box box;

        oracle_voxel_box(code, depth, SNAP_BITS, &box);
        for (size_t t = 0; t < count; t++) {
            bool touches = method == ORACLE_SAT ? oracle_sat_touches(&triangles[t], &box, coverage)
                                                : oracle_clip_touches(&triangles[t], &box, coverage);

            if (touches)
                pairs.pairs[pairs.count++] = (oracle_pair){code, (uint32_t)t};
        }
    }
    return pairs;
}

#define WALK_TRIANGLES 24

/* Triangles in, around and far outside the grid, some on voxel faces, some degenerate to segments. */
static void make_walk_triangles(oracle_triangle *triangles, uint64_t *seed)
{
    for (size_t t = 0; t < WALK_TRIANGLES; t++) {
        int32_t span = t % 4 == 3 ? 1 << 29 : 3 << (SNAP_BITS - 1);
        int32_t grain = t % 3 == 0 ? 1 << (SNAP_BITS - 4) : 1;

        for (int i = 0; i < 9; i++) {
            int32_t value = (int32_t)(next_random(seed) % (uint64_t)span) - span / (t % 4 == 3 ? 2 : 6);

            triangles[t].vertex[i / 3][i % 3] = value / grain * grain;
        }
        if (t % 5 == 4)
            memcpy(triangles[t].vertex[2], triangles[t].vertex[0], sizeof(triangles[t].vertex[0]));
    }
}

static void walk_agrees_with_brute_force(void **state)
{
    oracle_triangle triangles[WALK_TRIANGLES];
    const oracle_mesh mesh = {&triangles[0].vertex[0][0], NULL, NULL, WALK_TRIANGLES};
    uint64_t seed = 20240229;

    (void)state;
    print_message("seed %llu\n", (unsigned long long)seed);
    make_walk_triangles(triangles, &seed);
    for (unsigned depth = 0; depth <= 4; depth++) {
        for (int variant = 0; variant < 4; variant++) {
            oracle_coverage coverage = (oracle_coverage)(variant & 1);
            oracle_method method = (oracle_method)(variant >> 1);
            oracle_pairs every = ask_every_voxel(triangles, WALK_TRIANGLES, depth, coverage, method);
            oracle_pairs walked = enumerate(&mesh, depth, coverage, method);

            assert_int_equal(walked.count, every.count);
            assert_true(depth == 0 || walked.count > 40);
            for (size_t i = 0; i < every.count; i++) {
                assert_int_equal(walked.pairs[i].code, every.pairs[i].code);
                assert_int_equal(walked.pairs[i].triangle, every.pairs[i].triangle);
            }
            oracle_pairs_free(&every);
            oracle_pairs_free(&walked);
        }
    }
}

TEST_GROUP(oracle)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(golden_counts_are_reproduced),  cmocka_unit_test(golden_pairs_agree),
        cmocka_unit_test(cube_hull_has_its_closed_form), cmocka_unit_test(mid_plane_has_its_closed_form),
        cmocka_unit_test(points_have_their_voxels),      cmocka_unit_test(triangles_outside_touch_nothing),
        cmocka_unit_test(walk_agrees_with_brute_force),
    };

    return cmocka_run_group_tests_name("oracle", tests, NULL, NULL);
}
