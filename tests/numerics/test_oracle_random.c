/* SPDX-License-Identifier: MIT */
/*
 * Tests that the two exact references agree on single (triangle, box) pairs: random ones of every kind that is hard
 * for an overlap test, up to the ends of the coordinate range. If a generator knows a common point of triangle and box,
 * both references must report an overlap. No answer may depend on vertex order, axis order or (closed) reflection.
 *
 * The seed is printed and can be set: SVOCL_TEST_SEED=n test_oracle_random.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "oracle.h"
#include "support/suite.h"

#define PAIRS_PER_CLASS 1000000
#define COORDINATE_END  (1 << 30) /* the references' limit, twice the library's */

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
static int64_t between(int64_t low, int64_t high)
{
    return low + (int64_t)(next_random() % (uint64_t)(high - low + 1));
}

/* One pair, and a common point if its generator knows one. */
typedef struct sample {
    int64_t vertex[3][3];
    oracle_box box;
    bool has_point; /* `point` lies on the triangle */
    int64_t point[3];
} sample;

static void random_point(int64_t low, int64_t high, int64_t out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = between(low, high);
}

/* Moves the box to a point of the triangle, or up to `slack` past it. */
static void place_box_on_triangle(sample *s, int64_t width, int64_t slack)
{
    double u = (double)between(0, 1000000) * 1e-6, v = (double)between(0, 1000000) * 1e-6;

    if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
    }
    s->box.width = width;
    for (int k = 0; k < 3; k++) {
        double a = (double)s->vertex[0][k], b = (double)s->vertex[1][k], c = (double)s->vertex[2][k];

        s->box.corner[k] = (int64_t)(a + u * (b - a) + v * (c - a)) - between(-slack, width + slack);
    }
}

/* Small enough that every kind of coincidence happens often. */
static void make_tiny(sample *s)
{
    for (int i = 0; i < 3; i++)
        random_point(-2, 6, s->vertex[i]);
    random_point(-1, 3, s->box.corner);
    s->box.width = between(1, 3);
}

/* Vertices on voxel corners. */
static void make_lattice(sample *s)
{
    int64_t width = (int64_t)1 << between(0, 18);

    for (int i = 0; i < 3; i++) {
        random_point(-3, 4, s->vertex[i]);
        for (int k = 0; k < 3; k++)
            s->vertex[i][k] *= width;
    }
    random_point(-2, 2, s->box.corner);
    for (int k = 0; k < 3; k++)
        s->box.corner[k] *= width;
    s->box.width = width;
}

static void make_small(sample *s)
{
    int64_t width = between(1, 1 << 20);

    for (int i = 0; i < 3; i++)
        random_point(-2 * width, 2 * width, s->vertex[i]);
    place_box_on_triangle(s, width, width);
}

static void make_huge(sample *s)
{
    int64_t width = (int64_t)1 << between(0, 20);

    for (int i = 0; i < 3; i++)
        random_point(1 - COORDINATE_END, COORDINATE_END - 1, s->vertex[i]);
    place_box_on_triangle(s, width, width);
}

/* The third vertex a few units from the line through the others: aspect up to 1e9. */
static void make_sliver(sample *s)
{
    int64_t reach = (int64_t)1 << between(8, 28), width = between(1, 1 << 10);
    double t = (double)between(0, 1000000) * 1e-6;

    random_point(-reach, reach, s->vertex[0]);
    random_point(-reach, reach, s->vertex[1]);
    for (int k = 0; k < 3; k++)
        s->vertex[2][k] = s->vertex[0][k] + (int64_t)(t * (double)(s->vertex[1][k] - s->vertex[0][k])) + between(-3, 3);
    place_box_on_triangle(s, width, width + 2);
}

/* In the plane of one of the box's faces, or one unit away from it. */
static void make_coplanar(sample *s)
{
    int64_t width = (int64_t)1 << between(0, 20), reach = width << between(0, 8);
    int axis = (int)between(0, 2);

    for (int i = 0; i < 3; i++)
        random_point(-reach, reach, s->vertex[i]);
    place_box_on_triangle(s, width, width / 2);
    for (int i = 0; i < 3; i++)
        s->vertex[i][axis] = s->vertex[0][axis];
    s->box.corner[axis] = s->vertex[0][axis] - between(0, 1) * width + between(-1, 1);
}

/* Points, segments, and three collinear points. */
static void make_degenerate(sample *s)
{
    int64_t step[3], width = between(1, 64);

    random_point(-40, 40, step);
    random_point(-1000, 1000, s->vertex[0]);
    for (int i = 1; i < 3; i++) {
        int64_t factor = between(-20, 20) * between(0, 1);

        for (int k = 0; k < 3; k++)
            s->vertex[i][k] = s->vertex[0][k] + factor * step[k];
    }
    place_box_on_triangle(s, width, 1);
}

/* A point on the surface of the box, or one unit away from it: at a corner, on an edge or on a face. */
static void pick_contact(sample *s, int64_t width)
{
    s->box.width = width;
    random_point(-width, width, s->box.corner);
    for (int k = 0; k < 3; k++) {
        int64_t places[4] = {0, width, between(0, width), between(0, 1) * width + between(-1, 1)};

        s->point[k] = s->box.corner[k] + places[between(0, 3)];
    }
    s->has_point = true;
}

/* An edge that passes exactly through a point on the surface of the box. */
static void make_edge_contact(sample *s)
{
    int64_t direction[3], before = between(0, 50), after = between(0, 50), reach = (int64_t)9 << between(0, 12);

    pick_contact(s, (int64_t)1 << between(0, 12));
    random_point(-reach, reach, direction);
    random_point(-100000, 100000, s->vertex[2]);
    for (int k = 0; k < 3; k++) {
        s->vertex[0][k] = s->point[k] - before * direction[k];
        s->vertex[1][k] = s->point[k] + after * direction[k];
    }
}

/* The interior of a triangle passes exactly through a point on the surface of the box. */
static void make_face_contact(sample *s)
{
    int64_t reach = (int64_t)9 << between(0, 24), u[3], v[3];

    pick_contact(s, (int64_t)1 << between(0, 12));
    random_point(-reach, reach, u);
    random_point(-reach, reach, v);
    for (int k = 0; k < 3; k++) {
        s->vertex[0][k] = s->point[k] + u[k];
        s->vertex[1][k] = s->point[k] + v[k];
        s->vertex[2][k] = s->point[k] - u[k] - v[k];
    }
}

/* Adds one of the catalog's offsets if the coordinates remain in range. */
static void move_sample(sample *s)
{
    static const int64_t offsets[] = {0, 1000, 1 << 16, 1 << 20, 1000000, 100000000, 536870911, -500000000};
    int64_t offset = offsets[between(0, 7)], largest = 0;

    for (int i = 0; i < 9; i++) {
        int64_t magnitude = llabs(s->vertex[i / 3][i % 3]);

        largest = magnitude > largest ? magnitude : largest;
    }
    if (largest + llabs(offset) >= COORDINATE_END - (1 << 23))
        return;
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < 3; i++)
            s->vertex[i][k] += offset;
        s->box.corner[k] += offset;
        s->point[k] += offset;
    }
}

static oracle_triangle triangle_of(const sample *s)
{
    oracle_triangle triangle;

    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            triangle.vertex[i][k] = (int32_t)s->vertex[i][k];
    return triangle;
}

static void print_sample(const char *words, const sample *s)
{
    print_error("%s: triangle", words);
    for (int i = 0; i < 9; i++)
        print_error(" %lld", (long long)s->vertex[i / 3][i % 3]);
    print_error(", box %lld %lld %lld width %lld\n", (long long)s->box.corner[0], (long long)s->box.corner[1],
                (long long)s->box.corner[2], (long long)s->box.width);
}

/* The answer of both references; fails the test if they differ. */
static bool ask_both(const sample *s, oracle_coverage coverage)
{
    oracle_triangle triangle = triangle_of(s);
    bool sat = oracle_sat_touches(&triangle, &s->box, coverage);
    bool clip = oracle_clip_touches(&triangle, &s->box, coverage);

    if (sat != clip) {
        print_sample(coverage == ORACLE_CLOSED ? "closed" : "half-open", s);
        fail_msg("sat says %d, clip says %d", sat, clip);
    }
    return sat;
}

static bool box_has(const oracle_box *box, const int64_t point[3], oracle_coverage coverage)
{
    for (int k = 0; k < 3; k++) {
        int64_t local = point[k] - box->corner[k];

        if (local < 0 || local > box->width || (local == box->width && coverage == ORACLE_HALF_OPEN))
            return false;
    }
    return true;
}

/* The same pair with vertices and axes permuted, and reflected. */
static void check_symmetry(const sample *s, bool half_open, bool closed)
{
    sample turned = *s, mirrored = *s;
    int shift = (int)between(1, 2);

    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            turned.vertex[2 - i][(k + shift) % 3] = s->vertex[i][k];
    for (int k = 0; k < 3; k++)
        turned.box.corner[(k + shift) % 3] = s->box.corner[k];
    assert_int_equal(ask_both(&turned, ORACLE_HALF_OPEN), half_open);
    assert_int_equal(ask_both(&turned, ORACLE_CLOSED), closed);

    for (int i = 0; i < 3; i++)
        mirrored.vertex[i][shift] = -s->vertex[i][shift];
    mirrored.box.corner[shift] = -s->box.corner[shift] - s->box.width;
    assert_int_equal(ask_both(&mirrored, ORACLE_CLOSED), closed);
}

/* least_percent: the minimum for half-open hits and for misses, so that no class is trivial. */
static void check_class(void (*make)(sample *), int64_t least_percent)
{
    int64_t half_open_count = 0, boundary_count = 0;

    for (int64_t i = 0; i < PAIRS_PER_CLASS; i++) {
        sample s = {.has_point = false};
        bool half_open, closed;

        make(&s);
        move_sample(&s);
        half_open = ask_both(&s, ORACLE_HALF_OPEN);
        closed = ask_both(&s, ORACLE_CLOSED);
        if ((half_open && !closed) || (s.has_point && box_has(&s.box, s.point, ORACLE_HALF_OPEN) && !half_open) ||
            (s.has_point && box_has(&s.box, s.point, ORACLE_CLOSED) && !closed)) {
            print_sample("missed by both", &s);
            fail_msg("half-open %d, closed %d", half_open, closed);
        }
        if (i % 4 == 0)
            check_symmetry(&s, half_open, closed);
        half_open_count += half_open;
        boundary_count += closed && !half_open;
    }
    print_message("%lld of %d touch half-open, %lld more closed\n", (long long)half_open_count, PAIRS_PER_CLASS,
                  (long long)boundary_count);
    assert_in_range(half_open_count, PAIRS_PER_CLASS * least_percent / 100, PAIRS_PER_CLASS);
    assert_in_range(PAIRS_PER_CLASS - half_open_count, PAIRS_PER_CLASS * least_percent / 100, PAIRS_PER_CLASS);
}

#define CLASS_TEST(name, least_percent)           \
    static void references_agree_##name(void **s) \
    {                                             \
        (void)s;                                  \
        check_class(make_##name, least_percent);  \
    }

CLASS_TEST(tiny, 10)
CLASS_TEST(lattice, 10)
CLASS_TEST(small, 10)
CLASS_TEST(huge, 5)
CLASS_TEST(sliver, 5)
CLASS_TEST(coplanar, 10)
CLASS_TEST(degenerate, 10)
CLASS_TEST(edge_contact, 10)
CLASS_TEST(face_contact, 10)

/* Coordinates at the very ends of the range, with all signs: an overflow would happen here. */
static void references_agree_at_the_ends_of_the_range(void **state)
{
    const int64_t ends[4] = {1 - COORDINATE_END, -1, 0, COORDINATE_END - 1};
    int64_t touch_count = 0;

    (void)state;
    for (int i = 0; i < 200000; i++) {
        sample s = {.has_point = false};

        for (int j = 0; j < 9; j++)
            s.vertex[j / 3][j % 3] = ends[next_random() & 3];
        for (int k = 0; k < 3; k++)
            s.box.corner[k] = ends[next_random() & 3];
        s.box.width = (next_random() & 1) ? 1 << between(0, 30) : 1;
        touch_count += ask_both(&s, ORACLE_HALF_OPEN);
        ask_both(&s, ORACLE_CLOSED);
    }
    assert_in_range(touch_count, 1000, 199000);
}

TEST_GROUP(oracle_random)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(references_agree_tiny),         cmocka_unit_test(references_agree_lattice),
        cmocka_unit_test(references_agree_small),        cmocka_unit_test(references_agree_huge),
        cmocka_unit_test(references_agree_sliver),       cmocka_unit_test(references_agree_coplanar),
        cmocka_unit_test(references_agree_degenerate),   cmocka_unit_test(references_agree_edge_contact),
        cmocka_unit_test(references_agree_face_contact), cmocka_unit_test(references_agree_at_the_ends_of_the_range),
    };
    const char *seed = getenv("SVOCL_TEST_SEED");

    random_state = seed ? strtoull(seed, NULL, 10) : 20240321;
    print_message("seed %llu\n", (unsigned long long)random_state);
    return cmocka_run_group_tests_name("oracle_random", tests, NULL, NULL);
}
