/* SPDX-License-Identifier: MIT */
/*
 * The path-traced reference of light against closed forms: occlusion of walls, disks and spheres, closed rooms, the
 * laws of directional light, point lights and spots, and one bounce. Polygons stand for curves: limits leave room for
 * that and for three standard errors.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "path/albedo.h"
#include "path/outside.h"
#include "path/path.h"
#include "path/surface_points.h"
#include "support/fixture.h"
#include "support/suite.h"

#define PI      3.14159265358979323846
#define SAMPLES 4096u
#define SEED    7u

/* ---- shapes ---- */

typedef struct shape {
    svo_mesh mesh;
    float *positions;
    uint32_t *indices;
    svo_material material;
} shape;

static shape new_shape(size_t vertex_count, size_t triangle_count)
{
    shape made = {.mesh = SVO_MESH_INIT, .material = {.rgba = {255, 255, 255, 255}, .texture_index = SVO_NO_TEXTURE}};
    made.positions = calloc(3 * vertex_count, sizeof *made.positions);
    made.indices = calloc(3 * triangle_count, sizeof *made.indices);
    assert_non_null(made.positions);
    assert_non_null(made.indices);
    made.mesh.positions = made.positions;
    made.mesh.indices = made.indices;
    made.mesh.vertex_count = vertex_count;
    made.mesh.triangle_count = triangle_count;
    return made;
}

static void free_shape(shape *made)
{
    free(made->positions);
    free(made->indices);
}

static void set_position(shape *made, size_t vertex, double x, double y, double z)
{
    made->positions[3 * vertex] = (float)x;
    made->positions[3 * vertex + 1] = (float)y;
    made->positions[3 * vertex + 2] = (float)z;
}

static void set_triangle(shape *made, size_t triangle, size_t a, size_t b, size_t c)
{
    made->indices[3 * triangle] = (uint32_t)a;
    made->indices[3 * triangle + 1] = (uint32_t)b;
    made->indices[3 * triangle + 2] = (uint32_t)c;
}

/* The parallelogram from a corner along two edges. */
static shape make_quad(const double corner[3], const double u[3], const double v[3])
{
    shape made = new_shape(4, 2);
    for (size_t i = 0; i < 4; ++i) {
        const double p = i == 1 || i == 2;
        const double q = i >= 2;
        set_position(&made, i, corner[0] + p * u[0] + q * v[0], corner[1] + p * u[1] + q * v[1],
                     corner[2] + p * u[2] + q * v[2]);
    }
    set_triangle(&made, 0, 0, 1, 2);
    set_triangle(&made, 1, 0, 2, 3);
    return made;
}

/* Level, around the y axis; of the same area as the circle. */
static shape make_disk(double radius, double height)
{
    const size_t sides = 256;
    const double reach = radius * sqrt(2 * PI / (double)sides / sin(2 * PI / (double)sides));
    shape made = new_shape(sides + 1, sides);
    set_position(&made, sides, 0, height, 0);
    for (size_t i = 0; i < sides; ++i) {
        const double angle = 2 * PI * (double)i / (double)sides;
        set_position(&made, i, reach * cos(angle), height, reach * sin(angle));
        set_triangle(&made, i, sides, i, (i + 1) % sides);
    }
    return made;
}

static shape make_sphere(const double center[3], double radius)
{
    const size_t rows = 128;
    const size_t columns = 256;
    shape made = new_shape((rows + 1) * columns, 2 * rows * columns);
    for (size_t i = 0; i < (rows + 1) * columns; ++i) {
        const double polar = PI * (double)(i / columns) / (double)rows; /* NOLINT: a row */
        const double angle = 2 * PI * (double)(i % columns) / (double)columns;
        set_position(&made, i, center[0] + radius * sin(polar) * cos(angle), center[1] + radius * cos(polar),
                     center[2] + radius * sin(polar) * sin(angle));
    }
    for (size_t i = 0; i < rows * columns; ++i) {
        const size_t next = i - i % columns + (i + 1) % columns;
        set_triangle(&made, 2 * i, i, next, i + columns);
        set_triangle(&made, 2 * i + 1, next, next + columns, i + columns);
    }
    return made;
}

static void set_gray(shape *made, uint8_t value)
{
    memset(made->material.rgba, value, 3);
    made->mesh.materials = &made->material;
    made->mesh.material_count = 1;
}

/* ---- the reference on them ---- */

typedef struct truth {
    const shape *given;
    svo_light_setup setup;
    double range, falloff;
    unsigned samples, threads;
} truth;

static truth truth_of(const shape *given)
{
    return (truth){.given = given, .setup = SVO_LIGHT_SETUP_INIT, .samples = SAMPLES, .threads = 2};
}

static svo_gather_point point_at(double x, double y, double z)
{
    return (svo_gather_point){.position = {(float)x, (float)y, (float)z}, .normal = {0, 2, 0}};
}

/* On a grid of width 512 around the origin. */
static void trace_points(void **state, const truth *how, const svo_gather_point *points, size_t count,
                         path_result *results)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_plan_options plan_options = {.need = SVO_NEED_RAYS, .origin = {-256, -256, -256}, .edge = 512};
    built tree;
    fixture_build(&opened, &how->given->mesh, 4, &plan_options, &tree);
    const path_scene paths = {.tree = tree.tree,
                              .mesh = &how->given->mesh,
                              .queue = opened.queue,
                              .setup = &how->setup,
                              .range = how->range,
                              .falloff = how->falloff,
                              .threads = how->threads};
    const svo_status status = path_trace(&paths, points, count, how->samples, SEED, results);
    if (status != SVO_OK) {
        fail_msg("path_trace: %s", svo_device_message(opened.device));
        return;
    }
    built_destroy(&tree);
}

static path_result trace_point(void **state, const truth *how, svo_gather_point point)
{
    path_result result;
    trace_points(state, how, &point, 1, &result);
    assert_true(result.is_gathered);
    return result;
}

static void assert_near(const char *what, double measured, double expected, double limit)
{
    if (!(fabs(measured - expected) <= limit)) {
        fail_msg("%s: %.6f instead of %.6f, more than %.6f off", what, measured, expected, limit);
    }
}

/* ---- occlusion ---- */

static void walls_occlude_by_their_closed_form(void **state)
{
    static const double distances[] = {0.25, 1, 4};
    const double height = 2;
    const shape wall = make_quad((double[]){0, 0, -250}, (double[]){0, height, 0}, (double[]){0, 0, 500});
    const truth how = truth_of(&wall);
    for (size_t i = 0; i < sizeof distances / sizeof distances[0]; ++i) {
        const double d = distances[i];
        const path_result found = trace_point(state, &how, point_at(d, 0, 0));
        assert_near("wall", 1 - found.openness, (1 - d / sqrt(d * d + height * height)) / 2,
                    0.001 + 3 * found.openness_error);
    }
    free_shape((shape *)&wall);
}

static void disks_occlude_by_their_closed_form(void **state)
{
    static const double heights[] = {0.5, 2, 6};
    const double radius = 3;
    for (size_t i = 0; i < sizeof heights / sizeof heights[0]; ++i) {
        const double h = heights[i];
        shape disk = make_disk(radius, h);
        const truth how = truth_of(&disk);
        const path_result found = trace_point(state, &how, point_at(0, 0, 0));
        assert_near("disk", 1 - found.openness, radius * radius / (radius * radius + h * h),
                    0.001 + 3 * found.openness_error);
        free_shape(&disk);
    }
}

/* Two disks above a point, each of which lets .6 through, of a sky, of a sun and of what is seen. */
static void panes_let_their_share_through(void **state)
{
    static const svo_light_source sun = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {0, -1, 0}, .value = {1, 1, 1}};
    shape low = make_disk(1, 1);
    shape high = make_disk(1, 2);
    const size_t vertices = low.mesh.vertex_count;
    const size_t corners = 3 * low.mesh.triangle_count;
    shape both = new_shape(2 * vertices, 2 * low.mesh.triangle_count);
    memcpy(both.positions, low.positions, 3 * vertices * sizeof *both.positions);
    memcpy(both.positions + 3 * vertices, high.positions, 3 * vertices * sizeof *both.positions);
    for (size_t i = 0; i < corners; ++i) {
        both.indices[i] = low.indices[i];
        both.indices[corners + i] = low.indices[i] + (uint32_t)vertices;
    }
    both.material.rgba[3] = 102;
    both.mesh.materials = &both.material;
    both.mesh.material_count = 1;
    truth how = truth_of(&both);
    how.setup.sources = &sun;
    how.setup.source_count = 1;
    how.setup.sky[1] = 1;
    const double open = 0.5 + (0.5 - 0.2) * 0.6 + 0.2 * 0.36;
    const path_result found = trace_point(state, &how, point_at(0.1, 0, 0));
    assert_near("openness", found.openness, open, 0.005 + 3 * found.openness_error);
    assert_near("sun", found.direct[0], 0.36, 1e-6);
    /* The disks are white and reflect the sun, which shines on the upper one, and on the lower one through it. */
    assert_near("sky", found.irradiance[1] - found.irradiance[0], PI * open, 0.02 + 4 * found.irradiance_error[1]);
    free_shape(&both);
    free_shape(&low);
    free_shape(&high);
}

static void spheres_occlude_by_their_closed_form(void **state)
{
    static const double heights[] = {1.5, 2, 5};
    for (size_t i = 0; i < sizeof heights / sizeof heights[0]; ++i) {
        shape ball = make_sphere((double[]){0, heights[i], 0}, 1);
        const truth how = truth_of(&ball);
        const path_result found = trace_point(state, &how, point_at(0, 0, 0));
        assert_near("sphere", 1 - found.openness, 1 / (heights[i] * heights[i]), 0.002 + 3 * found.openness_error);
        free_shape(&ball);
    }
}

/* Everything is equally far from the center of a sphere. */
static void occlusion_falls_off_and_ends_at_its_range(void **state)
{
    shape ball = make_sphere((double[]){0, 0, 0}, 8);
    truth how = truth_of(&ball);
    assert_near("closed", trace_point(state, &how, point_at(0, 0, 0)).openness, 0, 0);
    how.falloff = 0.5;
    assert_near("falloff", trace_point(state, &how, point_at(0, 0, 0)).openness, 1 - 1 / (1 + 0.5 * 8), 0.001);
    how.range = 8.1;
    assert_near("in range", trace_point(state, &how, point_at(0, 0, 0)).openness, 1 - 1 / (1 + 0.5 * 8), 0.001);
    how.range = 7.9;
    assert_near("out of range", trace_point(state, &how, point_at(0, 0, 0)).openness, 1, 0);
    free_shape(&ball);
}

/* ---- radiance from everywhere ---- */

static void equal_radiance_gives_pi_times_it(void **state)
{
    const svo_finish lamp = {.emission = {1, 2, 0}};
    shape ball = make_sphere((double[]){0, 0, 0}, 8);
    set_gray(&ball, 0);
    truth how = truth_of(&ball);
    how.setup.finishes = &lamp;
    how.setup.finish_count = 1;
    const path_result inside = trace_point(state, &how, point_at(1, 2, 3));
    assert_near("room, red", inside.irradiance[0], PI, 1e-9);
    assert_near("room, green", inside.irradiance[1], 2 * PI, 1e-9);
    assert_near("room, blue", inside.irradiance[2], 0, 0);
    assert_near("room, direct", inside.direct[0], 0, 0);

    shape below = make_quad((double[]){-1, -9, -1}, (double[]){2, 0, 0}, (double[]){0, 0, 2});
    truth open = truth_of(&below);
    open.setup.sky[2] = 1;
    const path_result outside = trace_point(state, &open, point_at(0, 0, 0));
    assert_near("sky, blue", outside.irradiance[2], PI, 1e-9);
    assert_near("sky, red", outside.irradiance[0], 0, 0);
    assert_near("sky, openness", outside.openness, 1, 0);
    free_shape(&ball);
    free_shape(&below);
}

/* A map that is read at the centers of its texels and between them, over the turn's end and beyond the last row. */
static void outside_is_read_from_the_map(void **state)
{
    (void)state;
    float texels[3 * 4 * 2] = {0};
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    double radiance[3];
    for (size_t i = 0; i < 8; ++i) {
        texels[3 * i] = (float)(i % 4);
        texels[3 * i + 1] = (float)(i / 4); /* NOLINT: a row */
    }
    setup.sky[2] = 5;
    setup.sky_map = texels;
    setup.sky_width = 4;
    setup.sky_height = 2;
    static const struct {
        double x, y, z, red, green;
    } cases[] = {{-1, 0, -1, 1, 0.5}, /* halfway to the left from -z: the second of four columns */
                 {1, 0, -1, 2, 0.5},   {1, 0, 1, 3, 0.5},   {-1, 0, 1, 0, 0.5},
                 {0, 0, -3, 1.5, 0.5}, {0, 0, 1, 1.5, 0.5}, /* between the last column and the first */
                 {1, 9, -1, 2, 0},     {1, -9, -1, 2, 1}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        path_outside(&setup, vector(cases[i].x, cases[i].y, cases[i].z), radiance);
        assert_near("red of the map", radiance[0], cases[i].red, 1e-12);
        assert_near("green of the map", radiance[1], cases[i].green, 1e-12);
        assert_near("blue of the sky", radiance[2], 5, 1e-12);
    }
}

/* 1 + y, where y is the height of a direction, brings pi + 2 pi / 3; half a sky brings half of its light. */
static void skies_bring_their_integrals(void **state)
{
    enum { ROWS = 180, COLUMNS = 360 };
    static float texels[3 * ROWS * COLUMNS];
    shape below = make_quad((double[]){-1, -9, -1}, (double[]){2, 0, 0}, (double[]){0, 0, 2});
    truth open = truth_of(&below);
    for (size_t i = 0; i < (size_t)ROWS * COLUMNS; ++i) {
        const size_t row = i / COLUMNS;
        texels[3 * i] = (float)(1 + cos(PI * ((double)row + 0.5) / ROWS));
        texels[3 * i + 1] = i % COLUMNS < COLUMNS / 2 ? 1 : 0;
    }
    open.setup.sky_map = texels;
    open.setup.sky_width = COLUMNS;
    open.setup.sky_height = ROWS;
    const path_result up = trace_point(state, &open, point_at(0, 0, 0));
    assert_near("gradient", up.irradiance[0], PI + 2 * PI / 3, 0.001 + 3 * up.irradiance_error[0]);
    assert_near("half a sky", up.irradiance[1], PI / 2, 0.001 + 3 * up.irradiance_error[1]);
    svo_gather_point to_the_left = point_at(0, 0, 0);
    to_the_left.normal[0] = -2;
    const path_result left = trace_point(state, &open, to_the_left);
    assert_near("gradient, tilted", left.irradiance[0], PI + 2 * PI / 3 * sqrt(0.5),
                0.001 + 3 * left.irradiance_error[0]);
    assert_near("half a sky, tilted", left.irradiance[1], PI * (1 + sqrt(0.5)) / 2,
                0.001 + 3 * left.irradiance_error[1]);
    free_shape(&below);
}

/* A disk that covers R^2 / (R^2 + H^2) of a point's cosine-weighted hemisphere, lit from below. */
static void a_lit_disk_reflects_by_its_closed_form(void **state)
{
    const svo_light_source sun = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {0, 3, 3}, .value = {10, 0, 1}};
    shape disk = make_disk(3, 2);
    set_gray(&disk, 188);
    truth how = truth_of(&disk);
    how.setup.sources = &sun;
    how.setup.source_count = 1;
    const path_result found = trace_point(state, &how, point_at(0, 0, 0));
    const double expected = 0.502886 * 10 * sqrt(0.5) * 9 / (9 + 4);
    assert_near("one bounce", found.irradiance[0], expected, 0.01 + 3 * found.irradiance_error[0]);
    assert_near("one bounce, green", found.irradiance[1], 0, 0);
    assert_near("one bounce, blue", found.irradiance[2], expected / 10, 0.001 + 3 * found.irradiance_error[2]);
    assert_near("lit from behind", found.direct[0], 0, 0);
    free_shape(&disk);
}

/* Each bounce in a sphere is spread evenly: albedo times the irradiance before. */
static void one_bounce_in_a_sphere_is_its_albedo_times_the_direct_light(void **state)
{
    const svo_light_source lamp = {.kind = SVO_SOURCE_POINT, .value = {20, 20, 20}};
    shape ball = make_sphere((double[]){0, 0, 0}, 2);
    truth how = truth_of(&ball);
    how.setup.sources = &lamp;
    how.setup.source_count = 1;
    const path_result found = trace_point(state, &how, point_at(0, -1.999, 0));
    assert_near("direct", found.direct[1], 20.0 / 4, 0.01);
    assert_near("one bounce", found.irradiance[1], PATH_CLAY * 20 / 4, 0.01 + 3 * found.irradiance_error[1]);
    free_shape(&ball);
}

/* ---- direct light ---- */

static void point_lights_obey_the_inverse_square_law(void **state)
{
    const double height = 3;
    const svo_light_source lamp = {.kind = SVO_SOURCE_POINT, .position = {0, (float)height, 0}, .value = {2, 4, 8}};
    const shape floor = make_quad((double[]){-100, 0, -100}, (double[]){0, 0, 200}, (double[]){200, 0, 0});
    truth how = truth_of(&floor);
    how.setup.sources = &lamp;
    how.setup.source_count = 1;
    how.samples = 16;
    for (int i = 0; i < 5; ++i) {
        const double away = 4.0 * i;
        const path_result found = trace_point(state, &how, point_at(away, 0, 0));
        const double expected = height / pow(height * height + away * away, 1.5);
        assert_near("red", found.direct[0], 2 * expected, 1e-6);
        assert_near("blue", found.direct[2], 8 * expected, 4e-6);
    }
    free_shape((shape *)&floor);
}

/* A sun and a ball whose middles an edge covers shine with half of their light on what lies right below it, and with
   that of a segment of their disks beside; a ball whose half is below the surface with its upper half, 2 / (3 pi). */
static void lights_with_a_size_have_soft_shadows(void **state)
{
    const double radius = 0.05;
    const svo_light_source sun = {
        .kind = SVO_SOURCE_DIRECTIONAL, .direction = {0, -2, 0}, .value = {1, 1, 1}, .radius = (float)radius};
    const svo_light_source ball = {
        .kind = SVO_SOURCE_POINT, .position = {0, 20, 0}, .value = {400, 400, 400}, .radius = (float)(20 * radius)};
    const svo_light_source *const sources[] = {&sun, &ball};
    shape shade = make_quad((double[]){0, 2, -50}, (double[]){0, 0, 100}, (double[]){50, 0, 0});
    truth how = truth_of(&shade);
    how.setup.source_count = 1;
    how.samples = 16;
    for (int k = 0; k < 2; ++k) {
        how.setup.sources = sources[k];
        for (int i = -3; i <= 3; ++i) {
            /* From so far aside the edge, 2 above, covers the disk up to that height; a ball is 20 above. */
            const double height = -0.3 * i;
            const double aside = 0.3 * i * 2 * radius / (k == 0 ? 1 : 1 - 2.0 / 20);
            const path_result found = trace_point(state, &how, point_at(aside, 0, 0));
            const double share = 0.5 + (height * sqrt(1 - height * height) + asin(height)) / PI;
            assert_near(k == 0 ? "sun" : "ball", found.direct[0], share, 0.03);
        }
    }
    svo_gather_point beside = point_at(-20, 0, 0); /* whose surface the ball's middle lies in */
    beside.normal[0] = 1;
    beside.normal[1] = -1;
    const double squared = 20 * 20 + 20 * 20;
    const double expected = 400 / squared * (20 * radius / sqrt(squared)) * 2 / (3 * PI);
    assert_near("half a ball", trace_point(state, &how, beside).direct[0], expected, 0.08 * expected);
    /* A disk over a floor, at its middle and behind. */
    svo_light_source disk = {
        .kind = SVO_SOURCE_DISK, .position = {-20, 3, 0}, .direction = {0, -5, 0}, .value = {25, 25, 25}, .radius = 4};
    how.setup.sources = &disk;
    assert_near("disk", trace_point(state, &how, point_at(-20, 0, 0)).direct[0], 1, 0.02);
    disk.direction[1] = 5;
    assert_near("behind a disk", trace_point(state, &how, point_at(-20, 0, 0)).direct[0], 0, 0);
    free_shape(&shade);
}

static void directional_light_obeys_the_cosine_law_and_casts_shadows(void **state)
{
    svo_light_source sun = {.kind = SVO_SOURCE_DIRECTIONAL, .value = {1, 1, 1}};
    shape roof = make_quad((double[]){-1, 5, -1}, (double[]){0, 0, 2}, (double[]){2, 0, 0});
    truth how = truth_of(&roof);
    how.setup.sources = &sun;
    how.setup.source_count = 1;
    how.samples = 16;
    for (int degrees = -80; degrees <= 80; degrees += 20) {
        const double angle = degrees * PI / 180;
        sun.direction[0] = (float)(2 * sin(angle));
        sun.direction[1] = (float)(-2 * cos(angle));
        const path_result found = trace_point(state, &how, point_at(0, 0, 0));
        assert_near("sun", found.direct[0], degrees == 0 ? 0 : cos(angle), 1e-6);
    }
    free_shape(&roof);
}

static void spots_are_full_inside_and_end_outside(void **state)
{
    (void)state;
    const svo_light_source spot = {.kind = SVO_SOURCE_SPOT,
                                   .position = {0, 5, 0},
                                   .direction = {0, -3, 0},
                                   .inner_angle = 0.3F,
                                   .outer_angle = 0.5F};
    double before = 2;
    for (int i = 0; i < 16; ++i) {
        source_view view;
        const double angle = 0.05 * i;
        const vector3 place = vector(4 * sin(angle), 5 - 4 * cos(angle), 0);
        const bool lit = path_source_view(&spot, place, &view);
        const double share = lit ? view.strength * 16 : 0;
        assert_true(lit == (angle < 0.4999));
        assert_true(share <= before + 1e-12);
        if (angle < 0.2999) {
            assert_near("inside", share, 1, 1e-9);
        }
        before = share;
    }
}

/* ---- samples ---- */

static void standard_errors_are_honest(void **state)
{
    shape disk = make_disk(3, 2);
    truth how = truth_of(&disk);
    svo_gather_point points[64];
    path_result few[64];
    path_result many[64];
    double squares = 0;
    for (size_t i = 0; i < 64; ++i) {
        points[i] = point_at(0.125 * (double)i, 0, 0);
    }
    how.samples = 256;
    trace_points(state, &how, points, 64, few);
    how.samples = 16384;
    trace_points(state, &how, points, 64, many);
    for (size_t i = 0; i < 64; ++i) {
        squares += pow((few[i].openness - many[i].openness) / few[i].openness_error, 2) / 64;
        assert_true(many[i].openness_error <= 0.004);
    }
    assert_near("errors in standard errors", sqrt(squares), 1, 0.4);
    free_shape(&disk);
}

static void threads_do_not_change_the_result(void **state)
{
    const svo_light_source lamp = {.kind = SVO_SOURCE_POINT, .value = {1, 1, 1}};
    shape ball = make_sphere((double[]){0, 1, 0}, 4);
    truth how = truth_of(&ball);
    svo_gather_point points[200];
    path_result one[200];
    path_result three[200];
    for (size_t i = 0; i < 200; ++i) {
        points[i] = point_at(0.01 * (double)i, 0, 0);
    }
    how.setup.sources = &lamp;
    how.setup.source_count = 1;
    how.threads = 1;
    trace_points(state, &how, points, 200, one);
    how.threads = 3;
    trace_points(state, &how, points, 200, three);
    for (size_t i = 0; i < 200; ++i) {
        assert_true(one[i].openness == three[i].openness && one[i].irradiance[2] == three[i].irradiance[2]);
    }
    free_shape(&ball);
}

static void points_without_a_place_are_open_and_dark(void **state)
{
    shape ball = make_sphere((double[]){0, 0, 0}, 8);
    truth how = truth_of(&ball);
    const svo_gather_point points[3] = {
        {.position = {300, 0, 0}, .normal = {0, 1, 0}}, {.normal = {0, 0, 0}}, {.normal = {NAN, 0, 1}}};
    path_result results[3];
    how.setup.sky[0] = 1;
    how.samples = 16;
    trace_points(state, &how, points, 3, results);
    for (size_t i = 0; i < 3; ++i) {
        assert_false(results[i].is_gathered);
        assert_near("openness", results[i].openness, 1, 0);
        assert_near("irradiance", results[i].irradiance[0], 0, 0);
    }
    assert_int_equal(path_sample_count(16384), 16384);
    assert_int_equal(path_sample_count(1), 16);
    assert_int_equal(path_sample_count(100), 64);
    free_shape(&ball);
}

/* ---- surfaces ---- */

static void colors_are_decoded_after_they_are_multiplied(void **state)
{
    (void)state;
    static const uint8_t texels[] = {0, 0, 0, 255, 255, 255, 255, 255};
    static const float uvs[] = {0.5F, 0.5F, 0.5F, 0.5F, 0.5F, 0.5F};
    static const uint8_t colors[] = {188, 255, 10, 255, 188, 255, 10, 255, 188, 255, 10, 255};
    const svo_texture texture = {.rgba = texels, .width = 2, .height = 1, .wrap_u = SVO_WRAP_CLAMP};
    svo_material material = {.rgba = {255, 0, 255, 255}, .texture_index = SVO_NO_TEXTURE};
    svo_mesh mesh = SVO_MESH_INIT;
    double albedo[3];
    mesh.vertex_count = 3;
    mesh.triangle_count = 1;
    (void)path_albedo(&mesh, 0, 0.2, 0.3, albedo);
    assert_near("clay", albedo[2], 0.6, 0);
    mesh.colors = colors;
    mesh.materials = &material;
    mesh.material_count = 1;
    (void)path_albedo(&mesh, 0, 0.2, 0.3, albedo);
    assert_near("red", albedo[0], 0.502886, 1e-6);
    assert_near("green", albedo[1], 0, 0);
    assert_near("blue", albedo[2], 10 / 255.0 / 12.92, 1e-12);
    material.texture_index = 0;
    mesh.textures = &texture;
    mesh.texture_count = 1;
    mesh.uvs = uvs;
    (void)path_albedo(&mesh, 0, 0.2, 0.3, albedo);
    assert_near("between two texels", albedo[0], pow((94 / 255.0 + 0.055) / 1.055, 2.4), 1e-9);
}

/* A green that shows beside texels that do not: the color is the green's, alpha that of the place. */
static void hidden_texels_have_no_color(void **state)
{
    (void)state;
    static const uint8_t texels[] = {0, 255, 0, 255, 255, 0, 255, 0};
    static const float uvs[] = {0.5F, 0.5F, 0.5F, 0.5F, 0.5F, 0.5F};
    const svo_texture texture = {.rgba = texels, .width = 2, .height = 1, .wrap_u = SVO_WRAP_CLAMP};
    const svo_material material = {.rgba = {255, 255, 255, 51}};
    const svo_mesh mesh = {.struct_size = sizeof mesh,
                           .vertex_count = 3,
                           .triangle_count = 1,
                           .uvs = uvs,
                           .materials = &material,
                           .material_count = 1,
                           .textures = &texture,
                           .texture_count = 1};
    double albedo[3];
    const double alpha = path_albedo(&mesh, 0, 0.2, 0.3, albedo);
    assert_near("red", albedo[0], 0, 1e-12);
    assert_near("green", albedo[1], 1, 1e-12);
    assert_near("alpha", alpha, 0.1, 1e-12);
}

/* The faces of a box, two triangles each, get points in proportion to their areas; refused triangles get none. */
static void points_are_spread_by_area(void **state)
{
    (void)state;
    static const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 5, 3, 0, 5, 0, 1, 5, NAN, 0, 0};
    static const uint32_t indices[] = {0, 1, 2, 3, 4, 5, 0, 1, 6, 0, 1, 99, 0, 0, 1};
    svo_gather_point points[400];
    size_t above = 0;
    svo_mesh mesh = SVO_MESH_INIT;
    mesh.positions = positions;
    mesh.vertex_count = 7;
    mesh.indices = indices;
    mesh.triangle_count = 5;
    assert_true(surface_points(&mesh, 400, SEED, points));
    for (size_t i = 0; i < 400; ++i) {
        const double width = points[i].position[2] > 2 ? 3 : 1;
        above += points[i].position[2] > 2;
        assert_true(points[i].position[0] >= 0 && points[i].position[1] >= 0);
        assert_true((double)points[i].position[0] / width + (double)points[i].position[1] <= 1 + 1e-6);
        assert_near("normal", (double)points[i].normal[2], 1, 1e-6);
    }
    assert_int_equal(above, 300);
    mesh.triangle_count = 0;
    assert_false(surface_points(&mesh, 400, SEED, points));
}

TEST_GROUP(path)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(walls_occlude_by_their_closed_form),
        cmocka_unit_test(disks_occlude_by_their_closed_form),
        cmocka_unit_test(panes_let_their_share_through),
        cmocka_unit_test(spheres_occlude_by_their_closed_form),
        cmocka_unit_test(occlusion_falls_off_and_ends_at_its_range),
        cmocka_unit_test(equal_radiance_gives_pi_times_it),
        cmocka_unit_test(outside_is_read_from_the_map),
        cmocka_unit_test(skies_bring_their_integrals),
        cmocka_unit_test(a_lit_disk_reflects_by_its_closed_form),
        cmocka_unit_test(one_bounce_in_a_sphere_is_its_albedo_times_the_direct_light),
        cmocka_unit_test(point_lights_obey_the_inverse_square_law),
        cmocka_unit_test(lights_with_a_size_have_soft_shadows),
        cmocka_unit_test(directional_light_obeys_the_cosine_law_and_casts_shadows),
        cmocka_unit_test(spots_are_full_inside_and_end_outside),
        cmocka_unit_test(standard_errors_are_honest),
        cmocka_unit_test(threads_do_not_change_the_result),
        cmocka_unit_test(points_without_a_place_are_open_and_dark),
        cmocka_unit_test(colors_are_decoded_after_they_are_multiplied),
        cmocka_unit_test(hidden_texels_have_no_color),
        cmocka_unit_test(points_are_spread_by_area),
    };
    return cmocka_run_group_tests_name("path", tests, fixture_group_setup, fixture_group_teardown);
}
