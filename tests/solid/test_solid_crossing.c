/* SPDX-License-Identifier: MIT */
/*
 * Crossings of lines and triangles (kernels/solid/crossing.clh, compiled as C): closed parts cancel on every line, also
 * through corners and edges; each crossing lies in the voxel that the reference says. Triangles as they were given, on
 * grids that no double fits: where the snapped one decides, it is right, and the exact ones are right where numbers are
 * an ulp apart. The same with a planted mistake fails: a wrong tie, heights that a voxel owns at the wrong end,
 * triangles taken the wrong way around, snapped ones that decide too much.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <string.h>

#include "numerics/hard_cases.h"
#include "oracle_exact.h"
#include "solid/crossing/crossing_probe.h"
#include "support/meshes.h"
#include "support/suite.h"

__extension__ typedef __int128 wide;

#define CELLS 16 /* the grid has so many voxels along each axis */
#define WIDTH 4 /* units of a voxel, whose center is a lattice point */
/* The reference's unit is finer: no two heights on a line differ by less, unless they are equal. */
#define FINER 32768

/* A tetrahedron with corners on the lattice of the voxels' centers and corners. */
static const uint32_t faces[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};

static void make_corners(uint64_t *seed, int32_t corners[12])
{
    for (unsigned i = 0; i < 12; ++i) {
        corners[i] = (int32_t)random_below(seed, CELLS * 2) * (WIDTH / 2);
    }
}

/* A line through the centers of a column of voxels. */
typedef struct line {
    uint32_t axis;
    int32_t point[2];
} line;

static line make_line(uint64_t *seed)
{
    return (line){.axis = random_below(seed, 3),
                  .point = {(int32_t)random_below(seed, CELLS) * WIDTH + WIDTH / 2,
                            (int32_t)random_below(seed, CELLS) * WIDTH + WIDTH / 2}};
}

/* The sum of a face's crossings in the voxel of that height. */
static int cross_face(const crossing_functions *cross, const int32_t *vertices, const uint32_t *face, const line *along,
                      int32_t height)
{
    static const int32_t exactly[3] = {0, 0, 0};
    int32_t corners[9];
    for (unsigned k = 0; k < 9; ++k) {
        corners[k] = vertices[face[k / 3] * 3 + k % 3];
    }
    return cross->snapped(corners, exactly, along->axis, along->point, height * WIDTH, (height + 1) * WIDTH);
}

/* Lines on which the crossings of closed parts do not cancel. */
static unsigned count_open(const crossing_functions *cross)
{
    uint64_t seed = 31;
    unsigned open = 0;
    for (unsigned n = 0; n < 400; ++n) {
        int32_t vertices[12];
        int sum = 0;
        make_corners(&seed, vertices);
        const line along = make_line(&seed);
        for (int32_t i = 0; i < CELLS * 4; ++i) {
            sum += cross_face(cross, vertices, faces + i % 4 * 3, &along, i / 4);
        }
        open += sum != 0 ? 1 : 0;
    }
    return open;
}

/* Single faces that a voxel crosses otherwise than the reference. */
static unsigned count_wrong(const crossing_functions *cross)
{
    uint64_t seed = 77;
    unsigned wrong = 0;
    for (unsigned n = 0; n < 4000; ++n) {
        int32_t vertices[12];
        int32_t finer[12];
        int sum = 0;
        make_corners(&seed, vertices);
        const line along = make_line(&seed);
        for (unsigned k = 0; k < 12; ++k) {
            finer[k] = vertices[k] * FINER;
        }
        const oracle_mesh one = {finer, faces, NULL, 1};
        for (int32_t height = CELLS; height-- > 0;) {
            int64_t at[3]; /* just below the voxel: behind it is what this and the ones above cross */
            at[along.axis] = (int64_t)height * WIDTH * FINER - 1;
            at[(along.axis + 1) % 3] = (int64_t)along.point[0] * FINER;
            at[(along.axis + 2) % 3] = (int64_t)along.point[1] * FINER;
            sum += cross_face(cross, vertices, faces, &along, height);
            wrong += sum != oracle_point_winding(&one, along.axis, at) ? 1 : 0;
        }
    }
    return wrong;
}

static void crossings_are_those_of_the_reference(void **unused)
{
    (void)unused;
    assert_int_equal(count_open(&crossing_sound), 0);
    assert_int_equal(count_wrong(&crossing_sound), 0);
}

/* Another rule for ties is consistent too: it cancels, but single faces differ. */
static void planted_mistakes_are_found(void **unused)
{
    (void)unused;
    assert_int_equal(count_open(&crossing_tie), 0);
    assert_true(count_wrong(&crossing_tie) > 0);
    assert_true(count_open(&crossing_both) > 0);
    assert_true(count_wrong(&crossing_both) > 0);
    assert_true(count_open(&crossing_none) > 0);
    assert_true(count_wrong(&crossing_none) > 0);
    assert_true(count_wrong(&crossing_far) > 0);
    assert_true(count_wrong(&crossing_turned) > 0);
    assert_true(count_wrong(&crossing_passing) > 0);
}

/* ---- triangles as they were given ---- */

/* What a case finds: answers other than the reference's, and how often the snapped triangle decides, doubles do, or it
   crosses. */
typedef struct outcome {
    unsigned wrong_snapped, wrong_near, wrong_exact;
    unsigned decided, undecided, near_decided, crossed;
} outcome;

/* The case about a column's center in place of a voxel's corner: that is a corner of voxels half as wide. */
static void make_case(hard_kind kind, size_t index, hard_case *s, crossing_pair *pair)
{
    hard_case_make(kind, index, s);
    s->space.depth += s->space.depth < 2 ? 1 : 0;
    for (int k = 0; k < 3; ++k) {
        s->cell[k] = 2 * hard_between(0, (1 << (s->space.depth - 1)) - 1) + 1;
    }
    hard_case_fill(kind, s);
    --s->space.depth;
    memcpy(pair->vertices, s->triangle.vertices, sizeof pair->vertices);
    memcpy(pair->origin, s->space.origin, sizeof pair->origin);
    pair->edge = s->space.edge;
    pair->depth = s->space.depth;
    for (int k = 0; k < 3; ++k) {
        s->cell[k] /= 2;
        pair->cell[k] = (uint32_t)s->cell[k];
    }
}

/* Whether all of the triangle lies inside the grid. */
static bool is_inside(const int32_t corners[9], int snap_bits)
{
    bool inside = true;
    for (int i = 0; i < 9; ++i) {
        inside = inside && corners[i] >= 0 && corners[i] < 1 << snap_bits;
    }
    return inside;
}

/* upper: from the center of the voxel on. */
static int cross_reference(const hard_case *s, uint32_t axis, bool upper)
{
    int64_t half = 0;
    const int sense = oracle_exact_crossing(&s->triangle, &s->space, axis, s->cell, &half);
    return sense != 0 && half >> 1 == s->cell[axis] && (!upper || half % 2 != 0) ? sense : 0;
}

/* What the snapped triangle says of the pair. */
static int cross_snapped(const crossing_functions *cross, const crossing_pair *pair, uint32_t axis, int voxel_log2,
                         bool upper, bool *inside)
{
    int32_t corners[9];
    int32_t errors[3];
    const int snap_bits = (int)pair->depth + voxel_log2;
    crossing_snap(pair, snap_bits, corners, errors);
    const int32_t low = (int32_t)(pair->cell[axis] << voxel_log2);
    const int32_t point[2] = {(int32_t)((2 * pair->cell[(axis + 1) % 3] + 1) << (voxel_log2 - 1)),
                              (int32_t)((2 * pair->cell[(axis + 2) % 3] + 1) << (voxel_log2 - 1))};
    *inside = is_inside(corners, snap_bits);
    const int32_t from = upper ? low + (1 << (voxel_log2 - 1)) : low;
    return *inside ? cross->snapped(corners, errors, axis, point, from, low + (1 << voxel_log2)) : 0;
}

static void compare_voxel(const crossing_functions *cross, const hard_case *s, const crossing_pair *pair, uint32_t axis,
                          bool upper, outcome *out)
{
    const int expected = cross_reference(s, axis, upper);
    const int voxel_log2 = hard_between(1, (int)pair->depth > 16 ? 24 - (int)pair->depth : 8);
    bool inside;
    const int snapped = cross_snapped(cross, pair, axis, voxel_log2, upper, &inside);
    if (!inside) {
        return;
    }
    const int near = cross->near(pair, axis, upper);
    out->undecided += snapped == CROSSING_UNDECIDED;
    out->decided += snapped != CROSSING_UNDECIDED;
    out->wrong_snapped += snapped != CROSSING_UNDECIDED && snapped != expected;
    out->near_decided += near != CROSSING_UNDECIDED;
    out->wrong_near += near != CROSSING_UNDECIDED && near != expected;
    out->wrong_exact += cross->exact(pair, axis, upper) != expected;
    out->crossed += expected != 0;
}

/* Hard cases, along each axis, in the voxel and its neighbors along it, and in the upper half of each. */
static outcome compare_cases(const crossing_functions *cross)
{
    outcome out = {0};
    hard_cases_seed(47);
    for (size_t i = 0; i < (size_t)HARD_KINDS * HARD_SPACES * 60; ++i) {
        hard_case s;
        crossing_pair pair;
        make_case((hard_kind)(i % HARD_KINDS), i / HARD_KINDS, &s, &pair);
        for (uint32_t n = 0; n < 9; ++n) {
            const uint32_t axis = n % 3;
            const int32_t own = s.cell[axis];
            const int32_t moved = own + (int32_t)(n / 3) - 1;
            if (moved >= 0 && moved < 1 << s.space.depth) {
                s.cell[axis] = moved;
                pair.cell[axis] = (uint32_t)moved;
                compare_voxel(cross, &s, &pair, axis, false, &out);
                compare_voxel(cross, &s, &pair, axis, true, &out);
                s.cell[axis] = own;
                pair.cell[axis] = (uint32_t)own;
            }
        }
    }
    return out;
}

static void given_triangles_cross_as_the_reference_says(void **unused)
{
    (void)unused;
    const outcome found = compare_cases(&crossing_sound);
    print_message("%u decided by snapped triangles, %u not, %u by doubles, %u crossings\n", found.decided,
                  found.undecided, found.near_decided, found.crossed);
    assert_int_equal(found.wrong_snapped, 0);
    assert_int_equal(found.wrong_near, 0);
    assert_int_equal(found.wrong_exact, 0);
    assert_true(found.decided > 5000 && found.undecided > 5000 && found.near_decided > 5000 && found.crossed > 1000);
}

static void planted_mistakes_of_given_triangles_are_found(void **unused)
{
    (void)unused;
    assert_true(compare_cases(&crossing_sure_edge).wrong_snapped > 0);
    assert_true(compare_cases(&crossing_half_edge).wrong_snapped > 0);
    assert_true(compare_cases(&crossing_sure_height).wrong_snapped > 0);
    assert_true(compare_cases(&crossing_near_side).wrong_near > 0);
    assert_true(compare_cases(&crossing_near_height).wrong_near > 0);
    assert_true(compare_cases(&crossing_exact_tie).wrong_exact > 0);
    assert_true(compare_cases(&crossing_exact_far).wrong_exact > 0);
    assert_true(compare_cases(&crossing_exact_height).wrong_exact > 0);
}

/* The sum of the crossings of a face in all voxels of a column. */
static int cross_column(crossing_pair *pair, uint32_t axis, unsigned *undecided)
{
    int sum = 0;
    for (pair->cell[axis] = 0; pair->cell[axis] < CELLS; ++pair->cell[axis]) {
        bool inside;
        const int sense = cross_snapped(&crossing_sound, pair, axis, 6, false, &inside);
        assert_true(inside);
        sum += sense == CROSSING_UNDECIDED ? crossing_sound.exact(pair, axis, false) : sense;
        *undecided += sense == CROSSING_UNDECIDED;
    }
    return sum;
}

/* Corners within an ulp of centers and corners of voxels. Faces share edges and corners, and each line crosses as many
   upwards as downwards. */
static void given_tetrahedra_cancel(void **unused)
{
    (void)unused;
    uint64_t seed = 9;
    unsigned undecided = 0;
    hard_cases_seed(3);
    for (unsigned n = 0; n < 2000; ++n) {
        crossing_pair pair = {.origin = {0.1, -0.2, 1.0 / 3.0}, .edge = 0.7, .depth = 4};
        double corners[12];
        const uint32_t axis = n % 3;
        int sum = 0;
        for (unsigned k = 0; k < 12; ++k) {
            const uint32_t step = 1 + random_below(&seed, CELLS * 2 - 1);
            const double at = (double)(n % 2 == 0 ? step : step | 1) / (CELLS * 2);
            corners[k] = hard_move(pair.origin[k % 3] + at * pair.edge, hard_between(-1, 1));
        }
        pair.cell[(axis + 1) % 3] = random_below(&seed, CELLS);
        pair.cell[(axis + 2) % 3] = random_below(&seed, CELLS);
        for (unsigned face = 0; face < 4; ++face) {
            for (unsigned k = 0; k < 9; ++k) {
                pair.vertices[k] = corners[faces[3 * face + k / 3] * 3 + k % 3];
            }
            sum += cross_column(&pair, axis, &undecided);
        }
        assert_int_equal(sum, 0);
    }
    print_message("%u crossings are not decided by snapped triangles\n", undecided);
    assert_true(undecided > 1000);
}

static int sign_of(wide value)
{
    return value < 0 ? -1 : value > 0;
}

/* Terms at the limits, and sums that nearly cancel. */
static void signs_of_dot_products_are_exact(void **unused)
{
    (void)unused;
    uint64_t seed = 5;
    for (unsigned n = 0; n < 20000; ++n) {
        int64_t a[3];
        int32_t b[3];
        wide sum = 0;
        for (int k = 0; k < 3; ++k) {
            const int64_t limit = INT64_C(1) << (1 + random_below(&seed, 51));
            a[k] = (int64_t)((uint64_t)random_word(&seed) << 32 | random_word(&seed)) % limit;
            b[k] = (int32_t)random_below(&seed, 1u << 26) - (1 << 25);
            sum += (wide)a[k] * b[k];
        }
        assert_int_equal(crossing_sign(a, b), sign_of(sum));
        /* The third term takes back what the others are, but for a little. */
        b[2] = random_below(&seed, 2) != 0 ? 1 : -1;
        a[0] >>= 26;
        a[1] >>= 26;
        const int64_t others = a[0] * b[0] + a[1] * b[1];
        for (int64_t off = -1; off <= 1; ++off) {
            a[2] = (off - others) * b[2];
            assert_int_equal(crossing_sign(a, b), (int)off);
        }
    }
}

TEST_GROUP(solid_crossing)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(crossings_are_those_of_the_reference),
        cmocka_unit_test(planted_mistakes_are_found),
        cmocka_unit_test(given_triangles_cross_as_the_reference_says),
        cmocka_unit_test(planted_mistakes_of_given_triangles_are_found),
        cmocka_unit_test(given_tetrahedra_cancel),
        cmocka_unit_test(signs_of_dot_products_are_exact),
    };
    return cmocka_run_group_tests_name("solid_crossing", tests, NULL, NULL);
}
