/* SPDX-License-Identifier: MIT */
/* Welding of imported meshes: against the rule's own words, vertex by vertex, and what it leaves alone. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "support/import_check.h"
#include "support/suite.h"
#include "support/work_folder.h"

#define FACETS ((size_t)400)

static svo_import *import_welded(const char *name, double tolerance)
{
    const svo_import_options options = {.struct_size = sizeof options, .weld = tolerance};
    svo_import *import = NULL;
    svo_message message = {""};
    if (svo_import_file(path_of(name), &options, NULL, NULL, &import, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return import;
}

static uint64_t welded_count(const svo_import *import)
{
    svo_import_info info = SVO_IMPORT_INFO_INIT;
    assert_int_equal(svo_import_get_info(import, &info), SVO_OK);
    return info.welded_vertices;
}

/* A number below 2^24, by a linear congruence. */
static uint32_t next_random(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(*state >> 40);
}

/* A binary STL of facets whose corners gather around few places; some coordinates are no numbers. */
static void write_facets(const char *name, uint64_t seed, double scale, double offset)
{
    uint8_t *bytes = calloc(1, 84 + 50 * FACETS);
    const uint32_t count = FACETS;
    uint64_t state = seed;
    assert_non_null(bytes);
    memcpy(bytes + 80, &count, sizeof count);
    for (size_t i = 0; i < FACETS * 9; ++i) {
        const uint32_t place = next_random(&state) % 4;
        const double apart = (double)next_random(&state) * 0x1p-24;
        float x = (float)(offset + scale * ((double)place - 2.0 + 0.5 * apart));
        x = next_random(&state) % 200 == 0 ? (place == 0 ? INFINITY : NAN) : next_random(&state) % 50 == 0 ? -0.0F : x;
        memcpy(bytes + 84 + i / 9 * 50 + 12 + i % 9 * 4, &x, sizeof x);
    }
    write_bytes(name, bytes, 84 + 50 * FACETS);
    free(bytes);
}

static bool is_finite_vertex(const float *vertex)
{
    return isfinite(vertex[0]) && isfinite(vertex[1]) && isfinite(vertex[2]);
}

static double squared_distance(const float *a, const float *b)
{
    double sum = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        const double d = (double)a[axis] - (double)b[axis];
        sum += d * d;
    }
    return sum;
}

/* The vertex whose position vertex v gets; stays: of those before it. */
static size_t first_near(const float *positions, size_t v, double tolerance, const bool *stays)
{
    for (size_t i = 0; i < v && is_finite_vertex(positions + v * 3); ++i) {
        if (stays[i] && squared_distance(positions + i * 3, positions + v * 3) <= tolerance * tolerance) {
            return i;
        }
    }
    return v;
}

/* Compares every position of a welded import with the rule applied to the one that is not; returns how many moved. */
static uint64_t check_by_rule(const char *name, double tolerance)
{
    svo_import *plain = import_welded(name, 0.0);
    svo_import *welded = import_welded(name, tolerance);
    const svo_mesh *from = svo_import_mesh(plain);
    const svo_mesh *to = svo_import_mesh(welded);
    bool *stays = calloc(from->vertex_count, sizeof *stays);
    uint64_t moved = 0;
    assert_non_null(stays);
    assert_int_equal(to->vertex_count, from->vertex_count);
    assert_memory_equal(to->indices, from->indices, from->triangle_count * 3 * sizeof *from->indices);
    for (size_t v = 0; v < from->vertex_count; ++v) {
        const size_t first = first_near(from->positions, v, tolerance, stays);
        stays[v] = first == v && is_finite_vertex(from->positions + v * 3);
        moved += squared_distance(from->positions + first * 3, from->positions + v * 3) > 0.0 ? 1 : 0;
        assert_memory_equal(to->positions + v * 3, from->positions + first * 3, 3 * sizeof *to->positions);
    }
    assert_int_equal(welded_count(plain), 0);
    assert_int_equal(welded_count(welded), moved);
    free(stays);
    svo_import_destroy(&welded);
    svo_import_destroy(&plain);
    return moved;
}

static void vertices_go_to_the_first_that_is_near(void **state)
{
    static const struct {
        double scale, offset, tolerance;
    } cases[] = {{1, 0, 0.2},         {1, 0, 0.03},    {1, 0, 100},   {1, 1e6, 0.25},    {1e-40, 0, 1e-41},
                 {1e30, -1e31, 1e29}, {1e38, 0, 1e37}, {1, 0, 1e300}, {1e-38, 0, 1e-39}, {100, -40, 3}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        print_message("case %zu\n", i);
        write_facets("facets.stl", i + 1, cases[i].scale, cases[i].offset);
        assert_int_not_equal(check_by_rule("facets.stl", cases[i].tolerance), 0);
    }
}

/* Each vertex is 0.9 from the one before it: the second moves, so the third has only the first before it, and stays. */
static void what_moved_draws_no_other(void **state)
{
    (void)state;
    write_text("row.obj", "v 0 0 0\nv .9 0 0\nv 1.8 0 0\nv 2.7 0 0\nv 0 5 0\nf 1 2 5\nf 3 4 5\n");
    svo_import *import = import_welded("row.obj", 1.0);
    const svo_mesh *mesh = svo_import_mesh(import);
    static const float expected[] = {0, 0, 0, 0, 0, 0, 0, 5, 0, 1.8F, 0, 0, 1.8F, 0, 0};
    assert_int_equal(mesh->vertex_count, 5);
    assert_memory_equal(mesh->positions, expected, sizeof expected);
    assert_int_equal(mesh->triangle_count, 2);
    assert_int_equal(welded_count(import), 2);
    svo_import_destroy(&import);
}

/* The tolerance itself is near; an ulp more is not. Zeros of two signs are equal. */
static void the_tolerance_is_near(void **state)
{
    (void)state;
    write_text("two.obj", "v 0 0 0\nv .25 -0 0\nv 0 9 0\nf 1 2 3\n");
    svo_import *near = import_welded("two.obj", 0.25);
    svo_import *apart = import_welded("two.obj", nextafter(0.25, 0.0));
    assert_int_equal(welded_count(near), 1);
    assert_int_equal(welded_count(apart), 0);
    svo_import_destroy(&near);
    svo_import_destroy(&apart);
}

/* Vertices with other normals get the position and keep the normals. */
static void attributes_stay(void **state)
{
    (void)state;
    write_text("fold.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv .00001 0 0\nv 1 0 .00001\nv 0 0 1\nvn 0 0 1\nvn 0 1 0\n"
                           "f 1//1 2//1 3//1\nf 4//2 5//2 6//2\n");
    svo_import *import = import_welded("fold.obj", 1e-4);
    const svo_mesh *mesh = svo_import_mesh(import);
    assert_int_equal(mesh->vertex_count, 6);
    assert_int_equal(welded_count(import), 2);
    for (size_t corner = 0; corner < 2; ++corner) {
        const size_t first = mesh->indices[corner], second = mesh->indices[3 + corner];
        assert_memory_equal(mesh->positions + first * 3, mesh->positions + second * 3, 3 * sizeof(float));
        assert_memory_not_equal(mesh->normals + first * 3, mesh->normals + second * 3, 3 * sizeof(float));
    }
    svo_import_destroy(&import);
}

static void tolerances_out_of_range(void **state)
{
    static const double wrong[] = {-1e-9, NAN, INFINITY};
    (void)state;
    write_text("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        const svo_import_options options = {.struct_size = sizeof options, .weld = wrong[i]};
        svo_import *import = NULL;
        svo_message message = {""};
        assert_int_equal(svo_import_file(path_of("one.obj"), &options, NULL, NULL, &import, &message),
                         SVO_INVALID_ARGUMENT);
        assert_non_null(strstr(message.text, "svo_import_file: options.weld "));
        assert_null(import);
    }
}

TEST_GROUP(import_weld)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(vertices_go_to_the_first_that_is_near),
        cmocka_unit_test(what_moved_draws_no_other),
        cmocka_unit_test(the_tolerance_is_near),
        cmocka_unit_test(attributes_stay),
        cmocka_unit_test(tolerances_out_of_range),
    };
    return cmocka_run_group_tests_name("import_weld", tests, work_folder_make, work_folder_remove);
}
