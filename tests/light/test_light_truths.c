/* SPDX-License-Identifier: MIT */
/*
 * What cones gather beside what is known: the occlusion of simple shapes, floors, closed rooms, clutter, sealed boxes.
 * Each bound is on errors over many poses, so that no place on the grid is special. Seeds are fixed.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>

#include "cone_scene.h"
#include "support/meshes.h"
#include "support/suite.h"

#define DEPTH 7u

static const double up[3] = {0, 0, 1};

static void check_below(const char *what, double value, double limit)
{
    print_message("%s: %.4f, at most %.4f\n", what, value, limit);
    if (!(value <= limit)) {
        fail_msg("%s: %.4f is above %.4f", what, value, limit);
        return;
    }
}

/* ---- simple shapes ---- */

/* A wall in front of the point: an edge of it is level with the point. */
static void pose_wall(cone_scene *scene)
{
    const double distance = 16 + 16 * random_unit(&scene->seed);
    const double height = 32 + 16 * random_unit(&scene->seed);
    const double o[3] = {distance / 2, -62, -20};
    const double u[3] = {0, 124, 0};
    const double v[3] = {0, 0, height};
    const double point[3] = {-distance / 2, 0, -20};
    cone_scene_add_quad(scene, o, u, v);
    cone_scene_add_point(scene, point, up, 1 - (1 - distance / hypot(distance, height)) / 2);
}

static void pose_disk(cone_scene *scene)
{
    const double height = 16 + 32 * random_unit(&scene->seed);
    const double radius = 16 + 16 * random_unit(&scene->seed);
    const double center[3] = {0, 0, height / 2};
    const double point[3] = {0, 0, -height / 2};
    cone_scene_add_disk(scene, center, radius);
    cone_scene_add_point(scene, point, up, 1 - radius * radius / (radius * radius + height * height));
}

static void pose_sphere(cone_scene *scene)
{
    const double radius = 16 + 8 * random_unit(&scene->seed);
    const double height = radius + 16 + 16 * random_unit(&scene->seed);
    const double center[3] = {0, 0, height - 28};
    const double point[3] = {0, 0, -28};
    cone_scene_add_sphere(scene, center, radius);
    cone_scene_add_point(scene, point, up, 1 - radius * radius / (height * height));
}

static void occlusion_of_simple_shapes(void **state)
{
    static const struct {
        const char *name;
        void (*pose)(cone_scene *);
    } shapes[] = {{"wall", pose_wall}, {"disk", pose_disk}, {"sphere", pose_sphere}};
    const fixture opened = fixture_cl_of_group(state);
    cone_scene *scene = cone_scene_new(DEPTH, 11);
    cone_errors all = {.count = 0};
    for (size_t i = 0; i < sizeof shapes / sizeof shapes[0]; ++i) {
        cone_errors errors = {.count = 0};
        for (int pose = 0; pose < 20; ++pose) {
            cone_scene_clear(scene);
            cone_scene_pose(scene, pose % 4 != 0, 4);
            shapes[i].pose(scene);
            cone_scene_gather_form(&opened, scene, SVO_LIGHT_FACES, NULL);
            cone_errors_add_scene(&errors, scene);
            cone_errors_add_scene(&all, scene);
        }
        print_message("%s: mean %+.4f, worst %.4f\n", shapes[i].name, cone_errors_mean(&errors), errors.worst);
        check_below(shapes[i].name, cone_errors_rms(&errors), 0.10);
    }
    check_below("wall, disk and sphere", cone_errors_rms(&all), 0.10);
    cone_scene_free(scene);
}

/* ---- floors ---- */

static void bare_floors_are_open(void **state)
{
    static const uint32_t sets[] = {6, 16};
    const fixture opened = fixture_cl_of_group(state);
    cone_scene *scene = cone_scene_new(DEPTH, 12);
    for (size_t set = 0; set < 2; ++set) {
        svo_gather_options options = SVO_GATHER_OPTIONS_INIT;
        cone_errors all = {.count = 0};
        double mean = 0;
        options.cones = sets[set];
        for (int pose = 0; pose < 24; ++pose) {
            static const double o[3] = {-36, -36, 0};
            static const double u[3] = {72, 0, 0};
            static const double v[3] = {0, 72, 0};
            cone_errors errors = {.count = 0};
            cone_scene_clear(scene);
            cone_scene_pose(scene, pose % 3 != 0, 4);
            cone_scene_add_quad(scene, o, u, v);
            for (int k = 0; k < 64; ++k) {
                const double at[3] = {64 * random_unit(&scene->seed) - 32, 64 * random_unit(&scene->seed) - 32, 0};
                cone_scene_add_point(scene, at, up, 1);
            }
            cone_scene_gather_form(&opened, scene, SVO_LIGHT_FACES, &options);
            cone_errors_add_scene(&errors, scene);
            cone_errors_add_scene(&all, scene);
            mean += fabs(cone_errors_mean(&errors)) / 24;
        }
        check_below("floors, mean of a floor", mean, 0.02);
        check_below("floors, worst point", all.worst, 0.05);
    }
    cone_scene_free(scene);
}

/* ---- closed rooms ---- */

static void fill_room(cone_scene *scene)
{
    static const double half[3] = {32, 29, 26};
    cone_scene_add_room(scene, half);
    for (int k = 0; k < 96; ++k) {
        double at[3];
        double normal[3] = {0};
        for (int axis = 0; axis < 3; ++axis) {
            at[axis] = half[axis] * (1.7 * random_unit(&scene->seed) - 0.85);
        }
        const double side = k / 3 % 2 == 0 ? 1 : -1;
        at[k % 3] = side * half[k % 3];
        normal[k % 3] = -side;
        cone_scene_add_point(scene, at, normal, 0);
    }
}

static void closed_rooms_are_dark(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    cone_scene *scene = cone_scene_new(DEPTH, 13);
    cone_errors turned = {.count = 0};
    cone_errors aligned = {.count = 0};
    for (int pose = 0; pose < 24; ++pose) {
        cone_scene_clear(scene);
        cone_scene_pose(scene, pose < 20, 4);
        fill_room(scene);
        cone_scene_gather_form(&opened, scene, SVO_LIGHT_FACES, NULL);
        cone_errors_add_scene(pose < 20 ? &turned : &aligned, scene);
    }
    check_below("turned room, mean", cone_errors_mean(&turned), 0.07);
    check_below("aligned room, mean", cone_errors_mean(&aligned), 0.02);
    cone_scene_free(scene);
}

/* The openness of the middle of a cube of 64 voxels, whose triangles face inwards, or outwards where it is flipped. */
static double open_cube(const fixture *opened, bool flipped, const svo_light_options *options)
{
    static const double half[3] = {32, 32, 32};
    static const double middle[3] = {1, 2, 3};
    static const double normal[3] = {0.3, 1, 0.2};
    cone_scene *scene = cone_scene_new(DEPTH, 18);
    svo_light *light = NULL;
    cone_scene_pose(scene, false, 0);
    cone_scene_add_room(scene, half);
    if (flipped) {
        cone_scene_flip(scene);
    }
    cone_scene_add_point(scene, middle, normal, 0);
    svo_tree *tree = cone_scene_build(opened, scene, SVO_NEED_NORMAL | SVO_NEED_PROJECTED_AREA);
    light_succeed(opened, svo_light_create(tree, options, opened->queue, &light));
    cone_scene_gather(opened, scene, light, NULL);
    const double openness = (double)scene->results[0].openness;
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
    return openness;
}

/* Files wind triangles as they like; forms without direction leak. */
static void closed_cubes_are_closed_whatever_their_winding(void **state)
{
    static const svo_light_options one_side = {.struct_size = sizeof one_side, .one_side = 1};
    const fixture opened = fixture_cl_of_group(state);
    check_below("a cube seen from its front", open_cube(&opened, false, NULL), 0.02);
    check_below("a cube seen from its back", open_cube(&opened, true, NULL), 0.02);
    check_below("a cube of one side, from its front", open_cube(&opened, false, &one_side), 0.02);
    check_below("a cube of one side, from its back: closed share", 1 - open_cube(&opened, true, &one_side), 0.001);
    for (int form = SVO_LIGHT_BRICKS; form <= SVO_LIGHT_VOXELS; ++form) {
        const svo_light_options options = {.struct_size = sizeof options, .form = (svo_light_form)form};
        const double front = open_cube(&opened, false, &options);
        check_below("forms without direction, front and back", fabs(front - open_cube(&opened, true, &options)), 1e-6);
        assert_true(front > 0.6);
    }
}

/* ---- clutter ---- */

static void clutter_of_quads(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    cone_scene *scene = cone_scene_new(DEPTH, 14);
    cone_errors errors = {.count = 0};
    for (int pose = 0; pose < 2; ++pose) {
        cone_scene_clear(scene);
        for (int k = 0; k < 300; ++k) {
            static const double center[3] = {0, 0, 0};
            const double size = 8 + 12 * random_unit(&scene->seed);
            const double o[3] = {-size / 2, -size / 2, 0};
            const double u[3] = {size, 0, 0};
            const double v[3] = {0, size, 0};
            cone_scene_pose(scene, true, 50);
            cone_scene_add_quad(scene, o, u, v);
            cone_scene_add_point(scene, center, up, 0);
        }
        cone_scene_trace_openness(&opened, scene, 20);
        cone_scene_gather_form(&opened, scene, SVO_LIGHT_FACES, NULL);
        cone_errors_add_scene(&errors, scene);
    }
    print_message("clutter: mean %+.4f, worst %.4f\n", cone_errors_mean(&errors), errors.worst);
    check_below("clutter", cone_errors_rms(&errors), 0.16);
    cone_scene_free(scene);
}

/* ---- a room that emits ---- */

/* Emits 1 from all surfaces. */
static void light_up(const fixture *opened, svo_light *light, float sky)
{
    static const svo_finish finish = {.emission = {1, 1, 1}};
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    setup.finishes = &finish;
    setup.finish_count = 1;
    for (int channel = 0; channel < 3; ++channel) {
        setup.sky[channel] = sky;
    }
    light_succeed(opened, svo_light_set_sources(light, &setup, opened->queue));
}

static void check_furnace(const cone_scene *scene, const char *what)
{
    double worst = 0;
    for (size_t i = 0; i < scene->point_count; ++i) {
        for (int channel = 0; channel < 3; ++channel) {
            worst = fmax(worst, fabs(scene->results[i].irradiance[channel] / 3.14159265358979 - 1));
        }
        worst = fmax(worst, fabs(scene->results[i].specular[1] - 1.0));
    }
    check_below(what, worst, 0.01);
}

static void a_room_that_emits_is_even(void **state)
{
    static const uint32_t sets[] = {1, 5, 6, 16, 64};
    static const float steps[] = {0.5F, 0.75F, 1.0F};
    const fixture opened = fixture_cl_of_group(state);
    cone_scene *scene = cone_scene_new(DEPTH, 15);
    for (uint32_t depth = 5; depth <= DEPTH; ++depth) {
        const double size = ldexp(1, (int)depth);
        const double half[3] = {0.25 * size, 0.22 * size, 0.2 * size};
        scene->depth = depth;
        cone_scene_clear(scene);
        cone_scene_pose(scene, true, 1);
        cone_scene_add_room(scene, half);
        for (int k = 0; k < 32; ++k) {
            const double at[3] = {0.2 * size * (2 * random_unit(&scene->seed) - 1),
                                  0.2 * size * (2 * random_unit(&scene->seed) - 1), -half[2]};
            cone_scene_add_point(scene, at, up, 0);
            scene->points[k].exponent = (float)k;
            scene->points[k].reflected[k % 3] = 1;
        }
        svo_tree *tree =
            cone_scene_build(&opened, scene, SVO_NEED_NORMAL | SVO_NEED_PROJECTED_AREA | SVO_NEED_MATERIAL);
        for (int form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
            svo_light *light = light_of(&opened, tree, (svo_light_form)form);
            light_up(&opened, light, 1);
            for (int k = 0; k < 15; ++k) {
                svo_gather_options options = SVO_GATHER_OPTIONS_INIT;
                options.cones = sets[k % 5];
                options.step = steps[k / 5];
                cone_scene_gather(&opened, scene, light, &options);
                print_message("depth %u, %s, %u cones, step %g: ", depth,
                              svo_name(SVO_NAME_LIGHT_FORM, (svo_light_form)form), options.cones, (double)options.step);
                check_furnace(scene, "worst error");
            }
            svo_light_destroy(&light);
        }
        svo_tree_destroy(&tree);
    }
    cone_scene_free(scene);
}

/* ---- walls without direction ---- */

/* What a cone brings of a wall that emits 1, is one voxel thick and of a form without direction. A cell of level L
   above the leaves holds 2^-L of it, and the layer of such cells passes 1 - 2^-L, however wide it is. The march blends
   the extinctions of the two levels around half of the cone's width. */
static double isotropic_wall(double width)
{
    const int finer = ilogb(width) - 1;
    const double share = ldexp(width, -finer - 1) - 1;
    return 1 - pow(1 - ldexp(1, -finer), 1 - share) * pow(1 - ldexp(1, -finer - 1), share);
}

/* The specular cone alone, since its width is known: cos q = 0.8^(1 / (exponent + 1)). */
static void walls_without_direction_leak_as_they_must(void **state)
{
    static const double u[3] = {0, 120, 0};
    static const double v[3] = {0, 0, 120};
    static const double normal[3] = {1, 0, 0};
    const fixture opened = fixture_cl_of_group(state);
    const double slope = tan(acos(pow(0.8, 1 / 9.0)));
    cone_scene *scene = cone_scene_new(DEPTH, 18);
    double expected = 0;
    double brought[SVO_LIGHT_FORM_COUNT] = {0};
    for (int pose = 0; pose < 16; ++pose) {
        const double distance = 40 + 24 * random_unit(&scene->seed);
        const double o[3] = {distance - 30, -60, -60};
        const double at[3] = {-32, 0, 0};
        cone_scene_clear(scene);
        cone_scene_pose(scene, false, 2);
        cone_scene_add_quad(scene, o, u, v);
        cone_scene_add_point(scene, at, normal, 0);
        scene->points[0].exponent = 8;
        scene->points[0].reflected[0] = 1;
        svo_tree *tree =
            cone_scene_build(&opened, scene, SVO_NEED_NORMAL | SVO_NEED_PROJECTED_AREA | SVO_NEED_MATERIAL);
        for (int form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
            svo_light *light = light_of(&opened, tree, (svo_light_form)form);
            light_up(&opened, light, 0);
            cone_scene_gather(&opened, scene, light, NULL);
            brought[form] += (double)scene->results[0].specular[1] / 16;
            svo_light_destroy(&light);
        }
        expected += isotropic_wall(2 * distance * slope) / 16;
        svo_tree_destroy(&tree);
    }
    print_message("closed form %.4f, faces %.4f, bricks %.4f, voxels %.4f\n", expected, brought[SVO_LIGHT_FACES],
                  brought[SVO_LIGHT_BRICKS], brought[SVO_LIGHT_VOXELS]);
    check_below("faces: lost", 1 - brought[SVO_LIGHT_FACES], 0.01);
    check_below("bricks beside the closed form", fabs(brought[SVO_LIGHT_BRICKS] / expected - 1), 0.2);
    check_below("voxels beside the closed form", fabs(brought[SVO_LIGHT_VOXELS] / expected - 1), 0.2);
    cone_scene_free(scene);
}

/* ---- one bounce ---- */

/* A room without anything in it, of albedo 0.6, and a light inside. */
static const double room_half[3] = {0.26, 0.23, 0.2}; /* of the grid's width */
#define ALBEDO 0.6

/* The light's place at a time 0 .. 1, of the grid's width from the middle. */
static void light_at(double time, double at[3])
{
    at[0] = 0.16 * cos(2.2 * time);
    at[1] = 0.12 * sin(2.2 * time) - 0.03;
    at[2] = 0.1 * (time - 0.4);
}

/* Where a point of a wall is: wall 0 .. 5, and two coordinates -1 .. 1. */
static void place_on_wall(int wall, double u, double v, double at[3], double normal[3])
{
    const int axis = wall % 3;
    const double side = wall < 3 ? 1 : -1;
    at[axis] = side * room_half[axis];
    at[(axis + 1) % 3] = u * room_half[(axis + 1) % 3];
    at[(axis + 2) % 3] = v * room_half[(axis + 2) % 3];
    normal[0] = normal[1] = normal[2] = 0;
    normal[axis] = -side;
}

/* The cosine at a place towards another over the square of their distance, at least 0; and the direction. */
static double cosine_over_square(const double at[3], const double normal[3], const double other[3], double towards[3])
{
    double square = 0;
    double cosine = 0;
    for (int k = 0; k < 3; ++k) {
        towards[k] = other[k] - at[k];
        square += towards[k] * towards[k];
    }
    for (int k = 0; k < 3; ++k) {
        towards[k] /= sqrt(square);
        cosine += normal[k] * towards[k];
    }
    return fmax(cosine, 0) / square;
}

#define PATCHES 24
typedef struct wall_patch {
    double at[3], normal[3];
    double area;
} wall_patch;

static void make_patches(wall_patch patches[6 * PATCHES * PATCHES])
{
    for (int i = 0; i < 6 * PATCHES * PATCHES; ++i) {
        const int axis = i % 3;
        const int column = i / 6 % PATCHES;
        const int row = i / 6 / PATCHES;
        const double u = (2.0 * column + 1) / PATCHES - 1;
        const double v = (2.0 * row + 1) / PATCHES - 1;
        place_on_wall(i % 6, u, v, patches[i].at, patches[i].normal);
        patches[i].area = 4 * room_half[(axis + 1) % 3] * room_half[(axis + 2) % 3] / (PATCHES * PATCHES);
    }
}

/* What a unit light at a place, reflected once, brings to points: a sum over patches of the walls. */
static void sum_one_bounce(const double light[3], const wall_patch *points, size_t point_count, double *irradiance)
{
    static wall_patch patches[6 * PATCHES * PATCHES];
    double direction[3];
    make_patches(patches);
    for (size_t k = 0; k < point_count; ++k) {
        irradiance[k] = 0;
    }
    for (size_t i = 0; i < sizeof patches / sizeof patches[0]; ++i) {
        const wall_patch *patch = &patches[i];
        const double radiance =
            ALBEDO / 3.14159265358979 * cosine_over_square(patch->at, patch->normal, light, direction);
        for (size_t k = 0; k < point_count; ++k) {
            const double form = cosine_over_square(points[k].at, points[k].normal, patch->at, direction);
            const double leaving =
                -(direction[0] * patch->normal[0] + direction[1] * patch->normal[1] + direction[2] * patch->normal[2]);
            irradiance[k] += radiance * form * fmax(leaving, 0) * patch->area;
        }
    }
}

typedef struct lit_room {
    cone_scene *scene;
    svo_tree *tree;
    svo_light *light;
    wall_patch *points; /* of the grid's width, from the middle */
} lit_room;

static void open_room(const fixture *opened, uint32_t depth, size_t point_count, lit_room *out)
{
    const double size = ldexp(1, (int)depth);
    const double half[3] = {room_half[0] * size, room_half[1] * size, room_half[2] * size};
    out->scene = cone_scene_new(depth, 16);
    out->points = calloc(point_count, sizeof *out->points);
    assert_non_null(out->points);
    cone_scene_add_room(out->scene, half);
    for (size_t k = 0; k < point_count; ++k) {
        wall_patch *point = &out->points[k];
        place_on_wall((int)(k % 6), 1.6 * random_unit(&out->scene->seed) - 0.8,
                      1.6 * random_unit(&out->scene->seed) - 0.8, point->at, point->normal);
        const double at[3] = {point->at[0] * size, point->at[1] * size, point->at[2] * size};
        cone_scene_add_point(out->scene, at, point->normal, 0);
    }
    out->tree = cone_scene_build(opened, out->scene, SVO_NEED_NORMAL | SVO_NEED_PROJECTED_AREA | SVO_NEED_RAYS);
    out->light = light_of(opened, out->tree, SVO_LIGHT_FACES);
}

static void close_room(lit_room *room)
{
    svo_light_destroy(&room->light);
    svo_tree_destroy(&room->tree);
    cone_scene_free(room->scene);
    free(room->points);
}

/* Gathers with a light whose intensity is the square of the grid's width, so that irradiance is that of a grid of
   width 1. */
static void gather_in_room(const fixture *opened, lit_room *room, const double at[3])
{
    const double size = ldexp(1, (int)room->scene->depth);
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    svo_light_source source = {.kind = SVO_SOURCE_POINT};
    for (int k = 0; k < 3; ++k) {
        source.position[k] = (float)((at[k] + 0.5) * size);
        source.value[k] = (float)(size * size);
    }
    setup.sources = &source;
    setup.source_count = 1;
    light_succeed(opened, svo_light_set_sources(room->light, &setup, opened->queue));
    cone_scene_gather(opened, room->scene, room->light, NULL);
}

/* The mean of the truth at points so far above the surface, of the grid's width. */
static double mean_above(const double light[3], const wall_patch *points, size_t point_count, double height)
{
    wall_patch *apexes = calloc(point_count, sizeof *apexes);
    double *truth = calloc(point_count, sizeof *truth);
    double sum = 0;
    assert_non_null(apexes);
    assert_non_null(truth);
    for (size_t k = 0; k < point_count; ++k) {
        apexes[k] = points[k];
        for (int axis = 0; axis < 3; ++axis) {
            apexes[k].at[axis] += height * points[k].normal[axis];
        }
    }
    sum_one_bounce(light, apexes, point_count, truth);
    for (size_t k = 0; k < point_count; ++k) {
        sum += truth[k];
    }
    free(apexes);
    free(truth);
    return sum / (double)point_count;
}

/* Most of the change from depth to depth is that of the truth at the apexes of cones, two voxels above the surface: at
   depth 6 they are 1/32 of the grid's width away. Without it, cones change by less than 1 % from depth 6 on. */
static void one_bounce_is_the_same_at_each_depth(void **state)
{
    enum { POINTS = 384 };
    static double truth[POINTS];
    const fixture opened = fixture_cl_of_group(state);
    double before = 0;
    double before_at_apex = 0;
    for (uint32_t depth = 6; depth <= 9; ++depth) {
        lit_room room;
        double light[3];
        double mean = 0;
        double sum = 0;
        cone_errors errors = {.count = 0};
        open_room(&opened, depth, POINTS, &room);
        light_at(0.3, light);
        gather_in_room(&opened, &room, light);
        sum_one_bounce(light, room.points, POINTS, truth);
        for (size_t k = 0; k < POINTS; ++k) {
            mean += (double)room.scene->results[k].irradiance[1] / POINTS;
            sum += truth[k] / POINTS;
        }
        for (size_t k = 0; k < POINTS; ++k) {
            cone_errors_add(&errors, ((double)room.scene->results[k].irradiance[1] - truth[k]) / sum);
        }
        const double at_apex = mean_above(light, room.points, POINTS, ldexp(2, -(int)depth));
        print_message("depth %u: mean %.4f, truth %.4f, at the apexes %.4f, rms error %.4f of it\n", depth, mean, sum,
                      at_apex, cone_errors_rms(&errors));
        if (depth > 6) {
            check_below("change of the mean", fabs(mean / before - 1), depth > 7 ? 0.02 : 0.025);
            check_below("beside the truth at the apexes", fabs(mean / at_apex / before_at_apex - 1), 0.01);
        }
        before = mean;
        before_at_apex = mean / at_apex;
        close_room(&room);
    }
}

/* At the default of four photons a leaf. The truth's own jumps, three times, are allowed for; with ever more photons
   the cones' own error leaves 0.009. */
static void a_moving_light_does_not_flicker(void **state)
{
    enum { POINTS = 256, STEPS = 100 };
    static double truth[2][POINTS];
    static double gathered[2][POINTS];
    const fixture opened = fixture_cl_of_group(state);
    lit_room room;
    double worst = 0;
    double mean = 0;
    open_room(&opened, 6, POINTS, &room);
    for (int step = 0; step <= STEPS; ++step) {
        const int now = step % 2;
        double light[3];
        light_at(0.01 * step, light);
        gather_in_room(&opened, &room, light);
        sum_one_bounce(light, room.points, POINTS, truth[now]);
        for (size_t k = 0; k < POINTS; ++k) {
            gathered[now][k] = (double)room.scene->results[k].irradiance[1];
            mean += step == 0 ? truth[now][k] / POINTS : 0;
        }
        for (size_t k = 0; step > 0 && k < POINTS; ++k) {
            const double jump = fabs(gathered[now][k] - gathered[!now][k]);
            worst = fmax(worst, (jump - 3 * fabs(truth[now][k] - truth[!now][k])) / mean);
        }
    }
    check_below("jumps beyond three times the truth's, of its mean", worst, 0.022);
    close_room(&room);
}

TEST_GROUP(light_truths)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(occlusion_of_simple_shapes),
        cmocka_unit_test(bare_floors_are_open),
        cmocka_unit_test(closed_rooms_are_dark),
        cmocka_unit_test(closed_cubes_are_closed_whatever_their_winding),
        cmocka_unit_test(clutter_of_quads),
        cmocka_unit_test(a_room_that_emits_is_even),
        cmocka_unit_test(walls_without_direction_leak_as_they_must),
        cmocka_unit_test(one_bounce_is_the_same_at_each_depth),
        cmocka_unit_test(a_moving_light_does_not_flicker),
    };
    return cmocka_run_group_tests_name("light_truths", tests, fixture_group_setup, fixture_group_teardown);
}
