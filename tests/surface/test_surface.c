/* SPDX-License-Identifier: MIT */
/*
 * Surfaces of fields of numbers: closed forms, whose vertices lie on them; numbers at random, whose surfaces are closed
 * manifolds all the same; bands with the bytes of dense fields; levels; the field's end; and what is refused.
 */
#include "svocl/surface.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/meshes.h"
#include "support/suite.h"
#include "surface_check.h"
#include "svocl/nodes.h"

#define PI      3.141592653589793
#define SPACING 0.25

static const double first[3] = {-1.0, 2.0, 5.0};

/* ---- fields ---- */

/* A dense field with its numbers, or a band with its codes. */
typedef struct numbers {
    svo_surface_field field;
    float *distances;
    uint64_t *codes;
} numbers;

/* The signed distance of a shape at a place, in voxels from the first center on. */
typedef double shape(const double at[3]);

static numbers make_numbers(uint32_t x, uint32_t y, uint32_t z)
{
    const size_t count = (size_t)x * y * z;
    numbers made = {.field = {.struct_size = sizeof made.field,
                              .voxel_count = count,
                              .size = {x, y, z},
                              .first = {first[0], first[1], first[2]},
                              .spacing = SPACING}};
    made.distances = malloc(count * sizeof *made.distances);
    made.codes = malloc(count * sizeof *made.codes);
    assert_non_null(made.distances);
    assert_non_null(made.codes);
    made.field.distances = made.distances;
    return made;
}

static void free_numbers(numbers *made)
{
    free(made->distances);
    free(made->codes);
}

static numbers sample(uint32_t size, shape *of)
{
    numbers made = make_numbers(size, size, size);
    for (uint32_t i = 0; i < size * size * size; ++i) {
        const uint32_t y = i / size % size;
        const uint32_t z = i / size / size;
        const double at[3] = {i % size, y, z};
        made.distances[i] = (float)(of(at) * SPACING);
    }
    return made;
}

static int compare_codes(const void *a, const void *b)
{
    const uint64_t left = *(const uint64_t *)a;
    const uint64_t right = *(const uint64_t *)b;
    return (left > right) - (left < right);
}

/* The voxels of a dense field whose distance from a level is below width voxels. */
static numbers take_band(const numbers *dense, double level, double width)
{
    const uint32_t *size = dense->field.size;
    numbers made = make_numbers(size[0], size[1], size[2]);
    size_t count = 0;
    for (size_t i = 0; i < dense->field.voxel_count; ++i) {
        const uint32_t cell[3] = {(uint32_t)(i % size[0]), (uint32_t)(i / size[0] % size[1]),
                                  (uint32_t)(i / size[0] / size[1])};
        if (fabs((double)dense->distances[i] - level) < width * SPACING) {
            made.codes[count++] = svo_cell_to_code(cell);
        }
    }
    qsort(made.codes, count, sizeof *made.codes, compare_codes);
    for (size_t i = 0; i < count; ++i) {
        uint32_t cell[3];
        svo_code_to_cell(made.codes[i], cell);
        made.distances[i] = dense->distances[cell[0] + (size_t)size[0] * (cell[1] + (size_t)size[1] * cell[2])];
    }
    made.field.codes = made.codes;
    made.field.voxel_count = count;
    return made;
}

static double length_of(double x, double y, double z)
{
    return sqrt(x * x + y * y + z * z);
}

static double sphere(const double at[3])
{
    return length_of(at[0] - 15.3, at[1] - 14.8, at[2] - 16.1) - 10.3;
}

static double torus(const double at[3])
{
    return length_of(hypot(at[0] - 15.3, at[1] - 15.9) - 8.6, at[2] - 14.2, 0) - 4.1;
}

/* With sides through centers. */
static double cube(const double at[3])
{
    double outside[3];
    double most = -100;
    for (int axis = 0; axis < 3; ++axis) {
        const double away = fabs(at[axis] - 15.0) - 8.0;
        most = fmax(most, away);
        outside[axis] = fmax(away, 0);
    }
    return most > 0 ? length_of(outside[0], outside[1], outside[2]) : most;
}

static double two_spheres(const double at[3])
{
    return fmin(length_of(at[0] - 8.2, at[1] - 8.4, at[2] - 8.9) - 6.1,
                length_of(at[0] - 22.3, at[1] - 21.8, at[2] - 22.7) - 7.2);
}

/* ---- closed forms ---- */

/* Fails where a vertex is farther from the shape than bound, in voxels: at most 3/8 over the radius, for a mean of
   points half a diagonal away. Returns the measures, with the volume in voxels. */
static surface_measures check_shape(const numbers *dense, const svo_surface_options *options, shape *of, double bound)
{
    svo_surface *made = surface_make(&dense->field, options);
    const svo_mesh *mesh = svo_surface_get_mesh(made);
    const double level = options != NULL ? (double)options->level / SPACING : 0;
    surface_measures measures = surface_check(made);
    measures.volume /= SPACING * SPACING * SPACING;
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        double at[3];
        for (size_t axis = 0; axis < 3; ++axis) {
            at[axis] = ((double)mesh->positions[3 * i + axis] - first[axis]) / SPACING;
        }
        if (!(fabs(of(at) - level) <= bound)) {
            fail_msg("vertex %zu is %g voxels from the shape, above %g", i, of(at) - level, bound);
        }
    }
    svo_surface_destroy(&made);
    return measures;
}

static void assert_near(double got, double expected, double tolerance)
{
    if (!(fabs(got - expected) <= tolerance * fabs(expected))) {
        fail_msg("%.9g is not %.9g", got, expected);
    }
}

static void vertices_lie_on_closed_forms(void **state)
{
    (void)state;
    numbers dense = sample(32, sphere);
    surface_measures measures = check_shape(&dense, NULL, sphere, 0.04);
    assert_int_equal(measures.euler, 2);
    assert_near(measures.volume, 4.0 / 3.0 * PI * 10.3 * 10.3 * 10.3, 0.015);
    free_numbers(&dense);
    dense = sample(32, torus);
    measures = check_shape(&dense, NULL, torus, 0.1);
    assert_int_equal(measures.euler, 0);
    assert_near(measures.volume, 2.0 * PI * PI * 8.6 * 4.1 * 4.1, 0.06);
    free_numbers(&dense);
    dense = sample(32, two_spheres);
    measures = check_shape(&dense, NULL, two_spheres, 0.07);
    assert_int_equal(measures.euler, 4);
    free_numbers(&dense);
    /* Its corners are cut off, by two thirds of a voxel. */
    dense = sample(32, cube);
    measures = check_shape(&dense, NULL, cube, 0.67);
    assert_int_equal(measures.euler, 2);
    assert_near(measures.volume, 16.0 * 16.0 * 16.0, 0.04);
    free_numbers(&dense);
}

/* A level moves the surface; without signs there is one on each side. */
static void levels_are_offsets(void **state)
{
    (void)state;
    const svo_surface_options outer = {.struct_size = sizeof outer, .level = (float)(2.5 * SPACING)};
    const svo_surface_options inner = {.struct_size = sizeof inner, .level = (float)(-3 * SPACING)};
    numbers dense = sample(32, sphere);
    surface_measures measures = check_shape(&dense, &outer, sphere, 0.04);
    assert_int_equal(measures.euler, 2);
    assert_near(measures.volume, 4.0 / 3.0 * PI * pow(12.8, 3), 0.01);
    measures = check_shape(&dense, &inner, sphere, 0.06);
    assert_near(measures.volume, 4.0 / 3.0 * PI * pow(7.3, 3), 0.03);
    for (size_t i = 0; i < dense.field.voxel_count; ++i) {
        dense.distances[i] = fabsf(dense.distances[i]);
    }
    svo_surface *both = surface_make(&dense.field, &outer);
    measures = surface_check(both);
    assert_int_equal(measures.euler, 4);
    assert_near(measures.volume / (SPACING * SPACING * SPACING), 4.0 / 3.0 * PI * (pow(12.8, 3) - pow(7.8, 3)), 0.02);
    svo_surface_destroy(&both);
    svo_surface *none = surface_make(&dense.field, NULL);
    assert_int_equal(svo_surface_get_mesh(none)->triangle_count, 0);
    svo_surface_destroy(&none);
    free_numbers(&dense);
}

static void normals_are_gradients(void **state)
{
    (void)state;
    const svo_surface_options options = {.struct_size = sizeof options, .parts = SVO_SURFACE_NORMALS};
    static const double center[3] = {15.3, 14.8, 16.1};
    numbers dense = sample(32, sphere);
    svo_surface *made = surface_make(&dense.field, &options);
    const svo_mesh *mesh = svo_surface_get_mesh(made);
    assert_non_null(mesh->normals);
    assert_null(mesh->colors);
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        double along = 0;
        double squared = 0;
        for (size_t axis = 0; axis < 3; ++axis) {
            const double normal = (double)mesh->normals[3 * i + axis];
            const double at = ((double)mesh->positions[3 * i + axis] - first[axis]) / SPACING;
            along += normal * (at - center[axis]) / 10.3;
            squared += normal * normal;
        }
        assert_true(along > 0.995 && fabs(squared - 1) < 1e-6);
    }
    svo_surface_destroy(&made);
    free_numbers(&dense);
}

/* ---- numbers at random ---- */

/* Signs alone at random, so that all cases of cubes meet; then numbers that are often the same and often 0. */
static void fill_at_random(numbers *made, uint64_t seed, bool coarse)
{
    for (size_t i = 0; i < made->field.voxel_count; ++i) {
        const double number = random_unit(&seed) - 0.5;
        made->distances[i] =
            (float)(coarse ? floor(4 * number + 0.5) * (random_below(&seed, 2) != 0 ? 1 : -1) : number);
    }
}

static void numbers_at_random_make_manifolds(void **state)
{
    (void)state;
    static const uint32_t sizes[][3] = {{9, 17, 12}, {1, 1, 40}, {2, 3, 1}, {8, 8, 8}, {16, 7, 25}, {5, 33, 9}};
    for (uint64_t seed = 1; seed <= 24; ++seed) {
        const uint32_t *size = sizes[seed % (sizeof sizes / sizeof sizes[0])];
        numbers made = make_numbers(size[0], size[1], size[2]);
        print_message("seed %llu\n", (unsigned long long)seed);
        fill_at_random(&made, seed, seed % 3 == 0);
        svo_surface *surface = surface_make(&made.field, NULL);
        svo_surface *again = surface_make(&made.field, NULL);
        const surface_measures measures = surface_check(surface);
        assert_true(svo_surface_get_mesh(surface)->triangle_count > 0 && measures.volume > 0);
        surface_compare(surface, again);
        svo_surface_destroy(&surface);
        svo_surface_destroy(&again);
        /* All voxels, as a band. */
        numbers band = take_band(&made, 0, 1000);
        surface = surface_make(&made.field, NULL);
        again = surface_make(&band.field, NULL);
        surface_compare(surface, again);
        svo_surface_destroy(&surface);
        svo_surface_destroy(&again);
        free_numbers(&band);
        free_numbers(&made);
    }
}

/* ---- bands, ends, empty fields ---- */

static void bands_have_the_bytes_of_dense_fields(void **state)
{
    (void)state;
    static shape *const shapes[] = {sphere, torus, cube, two_spheres};
    for (size_t i = 0; i < sizeof shapes / sizeof shapes[0]; ++i) {
        for (int level = -1; level <= 1; ++level) {
            const svo_surface_options options = {
                .struct_size = sizeof options, .level = (float)(level * SPACING), .parts = SVO_SURFACE_NORMALS};
            numbers dense = sample(32, shapes[i]);
            numbers band = take_band(&dense, (double)options.level, 2.5);
            svo_surface *of_dense = surface_make(&dense.field, &options);
            svo_surface *of_band = surface_make(&band.field, &options);
            assert_true(band.field.voxel_count < dense.field.voxel_count / 2);
            surface_compare(of_dense, of_band);
            svo_surface_destroy(&of_dense);
            svo_surface_destroy(&of_band);
            free_numbers(&dense);
            free_numbers(&band);
        }
    }
}

static double ball_at_the_end(const double at[3])
{
    return length_of(at[0], at[1] - 7.1, at[2] - 15.0) - 5.2;
}

/* A surface that reaches the field's end is closed there. */
static void surfaces_are_closed_at_the_end(void **state)
{
    (void)state;
    svo_surface_info info = SVO_SURFACE_INFO_INIT;
    numbers dense = sample(16, ball_at_the_end);
    svo_surface *made = surface_make(&dense.field, NULL);
    const surface_measures measures = surface_check(made);
    assert_int_equal(svo_surface_get_info(made, &info), SVO_OK);
    assert_int_equal(measures.euler, 2);
    assert_true(info.end_triangles > 100 && info.end_triangles < info.triangle_count);
    assert_int_equal(info.bytes, 12 * (info.vertex_count + info.triangle_count));
    svo_surface_destroy(&made);
    free_numbers(&dense);
    /* One voxel: a body around its center. */
    dense = make_numbers(1, 1, 1);
    for (int i = 0; i < 3; ++i) {
        static const float inside[3] = {-1.0F, -0.0F, -FLT_MAX};
        dense.distances[0] = inside[i];
        made = surface_make(&dense.field, NULL);
        assert_int_equal(surface_check(made).euler, 2);
        assert_int_equal(svo_surface_get_info(made, &info), SVO_OK);
        assert_int_equal(info.vertex_count, 8);
        assert_int_equal(info.triangle_count, 12);
        assert_int_equal(info.end_triangles, 12);
        svo_surface_destroy(&made);
    }
    dense.distances[0] = 0.0F; /* not inside, as -0 is */
    made = surface_make(&dense.field, NULL);
    assert_int_equal(svo_surface_get_mesh(made)->triangle_count, 0);
    svo_surface_destroy(&made);
    dense.field.codes = dense.codes;
    dense.field.voxel_count = 0;
    made = surface_make(&dense.field, NULL);
    assert_int_equal(surface_check(made).euler, 0);
    svo_surface_destroy(&made);
    free_numbers(&dense);
}

/* ---- what is refused ---- */

static void expect_refusal(const svo_surface_field *field, const svo_surface_options *options, const char *words)
{
    svo_surface *made = NULL;
    svo_message message = {""};
    assert_int_equal(svo_surface_create(field, options, &made, &message), SVO_INVALID_ARGUMENT);
    assert_null(made);
    if (strstr(message.text, words) == NULL) {
        fail_msg("'%s' does not say '%s'", message.text, words);
    }
}

static void wrong_fields_are_refused(void **state)
{
    (void)state;
    numbers dense = sample(32, sphere);
    numbers band = take_band(&dense, 0, 1.5);
    expect_refusal(&band.field, NULL, "a band of 2.5 voxels");
    svo_surface_field field = band.field;
    const uint64_t code = band.codes[7];
    band.codes[7] = band.codes[8];
    expect_refusal(&field, NULL, "field.codes[8] is not above the code before it");
    band.codes[7] = code;
    field.size[1] = 20;
    expect_refusal(&field, NULL, "not in 32 x 20 x 32");
    field = dense.field;
    field.size[2] = 0;
    expect_refusal(&field, NULL, "field.size[2] 0 is not in 1 .. 65536");
    field.size[2] = 31;
    expect_refusal(&field, NULL, "field.voxel_count 32768 is not that of 32 x 32 x 31 voxels");
    field = dense.field;
    field.spacing = 0;
    expect_refusal(&field, NULL, "field.spacing 0 is not finite and above 0");
    field.spacing = 1e-9;
    expect_refusal(&field, NULL, "where floats are");
    field = dense.field;
    field.first[1] = INFINITY;
    expect_refusal(&field, NULL, "field.first[1] inf is not finite");
    field = dense.field;
    field.distances = NULL;
    expect_refusal(&field, NULL, "field.distances is NULL");
    dense.distances[5 + 32 * (6 + 32 * 7)] = NAN;
    expect_refusal(&dense.field, NULL, "the field's number at voxel 5, 6, 7 is nan");
    free_numbers(&dense);
    free_numbers(&band);
}

static void wrong_arguments_are_refused(void **state)
{
    (void)state;
    numbers dense = sample(8, sphere);
    svo_surface_options options = {.struct_size = sizeof options, .level = INFINITY};
    expect_refusal(&dense.field, &options, "options.level inf is not finite");
    options.level = 0;
    options.parts = 8;
    expect_refusal(&dense.field, &options, "options.parts 8 has bits besides 7");
    options.parts = SVO_SURFACE_COLORS;
    expect_refusal(&dense.field, &options, "options.tree is NULL");
    expect_refusal(NULL, NULL, "field is NULL");
    options.struct_size = 3;
    expect_refusal(&dense.field, &options, "struct_size");
    dense.field.struct_size = 3;
    expect_refusal(&dense.field, NULL, "struct_size");
    svo_surface *none = NULL;
    svo_surface_destroy(&none);
    svo_surface_destroy(NULL);
    assert_int_equal(svo_surface_get_info(NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_surface_field_of(NULL, NULL), SVO_INVALID_ARGUMENT);
    free_numbers(&dense);
}

TEST_GROUP(surface)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(vertices_lie_on_closed_forms),
        cmocka_unit_test(levels_are_offsets),
        cmocka_unit_test(normals_are_gradients),
        cmocka_unit_test(numbers_at_random_make_manifolds),
        cmocka_unit_test(bands_have_the_bytes_of_dense_fields),
        cmocka_unit_test(surfaces_are_closed_at_the_end),
        cmocka_unit_test(wrong_fields_are_refused),
        cmocka_unit_test(wrong_arguments_are_refused),
    };
    return cmocka_run_group_tests_name("surface", tests, NULL, NULL);
}
