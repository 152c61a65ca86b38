/* SPDX-License-Identifier: MIT */
/*
 * Crossings of lines and triangles (kernels/solid/crossing.clh, compiled as C): closed parts cancel on every line, also
 * through corners and edges; each crossing lies in the voxel that the reference says. The same with a planted mistake
 * fails: a wrong tie, heights that a voxel owns at the wrong end, triangles taken the wrong way around.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "oracle_solid.h"
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
static int cross_face(crossing_function *cross, const int32_t *vertices, const uint32_t *face, const line *along,
                      int32_t height)
{
    int32_t corners[9];
    for (unsigned k = 0; k < 9; ++k) {
        corners[k] = vertices[face[k / 3] * 3 + k % 3];
    }
    return cross(corners, along->axis, along->point, height * WIDTH, (height + 1) * WIDTH);
}

/* Lines on which the crossings of closed parts do not cancel. */
static unsigned count_open(crossing_function *cross)
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
static unsigned count_wrong(crossing_function *cross)
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
    assert_int_equal(count_open(crossing_sound), 0);
    assert_int_equal(count_wrong(crossing_sound), 0);
}

/* Another rule for ties is consistent too: it cancels, but single faces differ. */
static void planted_mistakes_are_found(void **unused)
{
    (void)unused;
    assert_int_equal(count_open(crossing_tie), 0);
    assert_true(count_wrong(crossing_tie) > 0);
    assert_true(count_open(crossing_both) > 0);
    assert_true(count_wrong(crossing_both) > 0);
    assert_true(count_open(crossing_none) > 0);
    assert_true(count_wrong(crossing_none) > 0);
    assert_true(count_wrong(crossing_far) > 0);
    assert_true(count_wrong(crossing_turned) > 0);
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
        cmocka_unit_test(signs_of_dot_products_are_exact),
    };
    return cmocka_run_group_tests_name("solid_crossing", tests, NULL, NULL);
}
