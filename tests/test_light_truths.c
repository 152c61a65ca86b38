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

#include "cone_scene.h"
#include "meshes.h"

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

/* Emits 1 from all surfaces, under a sky of 1. */
static void light_up(const fixture *opened, svo_light *light)
{
    static const svo_finish finish = {.emission = {1, 1, 1}};
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    setup.finishes = &finish;
    setup.finish_count = 1;
    for (int channel = 0; channel < 3; ++channel) {
        setup.sky[channel] = 1;
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
            light_up(&opened, light);
            for (int k = 0; k < 15; ++k) {
                svo_gather_options options = SVO_GATHER_OPTIONS_INIT;
                options.cones = sets[k % 5];
                options.step = steps[k / 5];
                cone_scene_gather(&opened, scene, light, &options);
                print_message("depth %u, %s, %u cones, step %g: ", depth, svo_light_form_name((svo_light_form)form),
                              options.cones, (double)options.step);
                check_furnace(scene, "worst error");
            }
            svo_light_destroy(&light);
        }
        svo_tree_destroy(&tree);
    }
    cone_scene_free(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(occlusion_of_simple_shapes), cmocka_unit_test(bare_floors_are_open),
        cmocka_unit_test(closed_rooms_are_dark),      cmocka_unit_test(clutter_of_quads),
        cmocka_unit_test(a_room_that_emits_is_even),
    };
    return cmocka_run_group_tests(tests, fixture_group_setup, fixture_group_teardown);
}
