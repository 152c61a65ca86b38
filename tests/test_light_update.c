/* SPDX-License-Identifier: MIT */
/*
 * Lights that follow trees that change: after each update of a moving scene the light is, byte for byte, the one made
 * from nothing, with occluders far from what they shade, objects that come, go and hide, every form, sources of every
 * kind and views of every size; few photons are shot again; what is refused leaves the light; memory is flat.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "attributed_mesh.h"
#include "enqueued.h"
#include "fixture.h"
#include "memory_ledger.h"

enum { OBJECTS = 3, DEPTH = 6, BOXES = 64 };

/* ---- scenes ---- */

/* A closed room around the unit cube with some random triangles in it, and smaller objects. */
typedef struct stage {
    attributed_mesh room, objects[OBJECTS];
    svo_moving *moving;
    bool visible[OBJECTS];
} stage;

static svo_moving_options options_of_stage(void)
{
    const svo_moving_options options = {.struct_size = sizeof options,
                                        .need = (uint32_t)SVO_NEED_ALL & ~(uint32_t)SVO_NEED_PROJECTED_AREA,
                                        .origin = {-0.1, -0.1, -0.1},
                                        .edge = 1.2,
                                        .max_area = 60.0};
    return options;
}

/* Makes the first triangles of a mesh the walls of the unit cube. */
static void add_walls(attributed_mesh *mesh)
{
    static const uint8_t quads[6][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                        {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};
    for (size_t side = 0; side < 6; ++side) {
        for (size_t half = 0; half < 2; ++half) {
            for (size_t corner = 0; corner < 3; ++corner) {
                const size_t vertex = (2 * side + half) * 3 + corner;
                const uint8_t place = quads[side][corner == 0 ? 0 : half + corner];
                mesh->base.indices[vertex] = (uint32_t)vertex;
                for (size_t axis = 0; axis < 3; ++axis) {
                    mesh->base.positions[3 * vertex + axis] = place >> axis & 1;
                }
            }
        }
    }
}

static void transform_of(double out[12], double size, double angle, const double at[3])
{
    const double turn[9] = {cos(angle), -sin(angle), 0, sin(angle), cos(angle), 0, 0, 0, 1};
    for (int row = 0; row < 3; ++row) {
        for (int k = 0; k < 3; ++k) {
            out[4 * row + k] = size * turn[3 * row + k];
        }
        out[4 * row + 3] = at[row];
    }
}

/* Inside the room. */
static void random_transform(uint64_t *seed, double out[12])
{
    const double size = 0.05 + 0.1 * random_unit(seed);
    const double angle = 6.28 * random_unit(seed);
    double at[3];
    for (int axis = 0; axis < 3; ++axis) {
        at[axis] = 0.3 + 0.4 * random_unit(seed);
    }
    transform_of(out, size, angle, at);
}

static void open_stage(const fixture *opened, uint64_t seed, stage *out)
{
    const svo_moving_options options = options_of_stage();
    *out = (stage){.moving = NULL};
    attributed_mesh_create(seed, 60, 0.05, &out->room);
    add_walls(&out->room);
    succeed(opened, svo_moving_create(opened->device, &out->room.mesh, DEPTH, &options, opened->queue, &out->moving));
    for (uint32_t i = 0; i < OBJECTS; ++i) {
        double transform[12];
        uint32_t object = 77;
        attributed_mesh_create(seed * 31 + i, 20, 0.3, &out->objects[i]);
        random_transform(&seed, transform);
        succeed(opened, svo_moving_add(out->moving, &out->objects[i].mesh, transform, &object));
        assert_int_equal(object, i);
        out->visible[i] = true;
    }
    succeed(opened, svo_moving_update(out->moving, opened->queue, NULL));
}

static void close_stage(stage *opened)
{
    svo_moving_destroy(&opened->moving);
    attributed_mesh_destroy(&opened->room);
    for (int i = 0; i < OBJECTS; ++i) {
        attributed_mesh_destroy(&opened->objects[i]);
    }
}

/* ---- lights ---- */

static svo_light_setup setup_of(const svo_light_source *sources, size_t count, uint32_t resolution)
{
    static const svo_finish finishes[2] = {{.specular = {0.5F, 0.4F, 0.3F}, .exponent = 20},
                                           {.emission = {0.2F, 0.1F, 0.3F}}};
    const svo_light_setup setup = {.struct_size = sizeof setup,
                                   .sources = sources,
                                   .source_count = count,
                                   .finishes = finishes,
                                   .finish_count = 2,
                                   .sky = {0.1F, 0.2F, 0.3F},
                                   .view_resolution = resolution,
                                   .updatable = 1};
    return setup;
}

/* A light near a corner of the room, so that what is close to it shades walls far away. */
static const svo_light_source all_sources[] = {
    {.kind = SVO_SOURCE_POINT, .position = {0.15F, 0.85F, 0.2F}, .value = {3, 2, 1}},
    {.kind = SVO_SOURCE_SPOT,
     .position = {0.9F, 0.9F, 0.9F},
     .direction = {-1.0F, -0.9F, -1.1F},
     .value = {1, 2, 3},
     .inner_angle = 0.3F,
     .outer_angle = 0.6F},
    {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {0.3F, -2.0F, 0.1F}, .value = {1, 1, 0.5F}},
};

static svo_light *make_light(const fixture *opened, svo_tree *tree, svo_light_form form, const svo_light_setup *setup)
{
    const svo_light_options options = {.struct_size = sizeof options, .form = form};
    svo_light *light = NULL;
    succeed(opened, svo_light_create(tree, &options, opened->queue, &light));
    succeed(opened, svo_light_set_sources(light, setup, opened->queue));
    return light;
}

static svo_light_info info_of(const fixture *opened, const svo_light *light)
{
    svo_light_info info = SVO_LIGHT_INFO_INIT;
    succeed(opened, svo_light_get_info(light, &info));
    return info;
}

static void assert_same_light(const fixture *opened, const svo_light *actual, const svo_light *expected)
{
    char hashes[2][SVO_HASH_TEXT_BYTES];
    const svo_light_info a = info_of(opened, actual);
    const svo_light_info b = info_of(opened, expected);
    succeed(opened, svo_light_hash(actual, opened->queue, hashes[0]));
    succeed(opened, svo_light_hash(expected, opened->queue, hashes[1]));
    assert_string_equal(hashes[0], hashes[1]);
    assert_int_equal(a.photons, b.photons);
    assert_int_equal(a.photon_hits, b.photon_hits);
    assert_int_equal(a.lit_leaves, b.lit_leaves);
    assert_int_equal(a.lit_nodes, b.lit_nodes);
    assert_int_equal(a.total_bytes, b.total_bytes);
    assert_memory_equal(a.flux, b.flux, sizeof a.flux);
    assert_true(a.lost_flux == b.lost_flux);
}

/* Compares a light with one that is made from nothing. */
static void compare(const fixture *opened, const stage *of, const svo_light *light, const svo_light_setup *setup)
{
    svo_light *expected = make_light(opened, svo_moving_tree(of->moving), info_of(opened, light).form, setup);
    assert_same_light(opened, light, expected);
    svo_light_destroy(&expected);
}

/* Updates the scene, and the light after it. */
static void follow(const fixture *opened, const stage *of, svo_light *light)
{
    svo_box boxes[BOXES];
    size_t count = 0;
    succeed(opened, svo_moving_update(of->moving, opened->queue, NULL));
    succeed(opened, svo_moving_get_changes(of->moving, boxes, BOXES, &count));
    assert_true(count <= BOXES);
    succeed(opened, svo_light_update(light, svo_moving_tree(of->moving), boxes, count, opened->queue));
}

/* ---- equality ---- */

/* One of the objects moves, hides, appears, or goes and comes again. */
static void play(const fixture *opened, stage *of, uint64_t *seed)
{
    double transform[12];
    const uint32_t object = random_below(seed, OBJECTS);
    const uint32_t act = random_below(seed, 6);
    random_transform(seed, transform);
    if (act == 0) {
        of->visible[object] = !of->visible[object];
        succeed(opened, svo_moving_show(of->moving, object, of->visible[object]));
    } else if (act == 1) {
        uint32_t again = 77;
        succeed(opened, svo_moving_remove(of->moving, object));
        succeed(opened, svo_moving_add(of->moving, &of->objects[object].mesh, transform, &again));
        assert_int_equal(again, object);
        of->visible[object] = true;
    } else {
        succeed(opened, svo_moving_set_transform(of->moving, object, transform));
    }
}

static void compare_moves(const fixture *opened, uint64_t seed, int moves, svo_light_form form,
                          const svo_light_setup *setup)
{
    stage of;
    uint64_t traced = 0;
    open_stage(opened, seed, &of);
    svo_light *light = make_light(opened, svo_moving_tree(of.moving), form, setup);
    const uint64_t photons = info_of(opened, light).photons;
    assert_int_equal(info_of(opened, light).traced_photons, photons);
    for (int i = 0; i < moves; ++i) {
        play(opened, &of, &seed);
        follow(opened, &of, light);
        compare(opened, &of, light, setup);
        traced += info_of(opened, light).traced_photons;
    }
    assert_true(traced > 0);
    if (traced * 2 > photons * (uint64_t)moves) {
        fail_msg("%d updates shot %llu photons, more than half of %llu each", moves, (unsigned long long)traced,
                 (unsigned long long)photons);
        return;
    }
    svo_light_destroy(&light);
    close_stage(&of);
}

static void random_moves_equal_lights_from_nothing(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_light_setup setup = setup_of(all_sources, 3, 0);
    for (int form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
        compare_moves(&opened, 40 + (uint64_t)form, form == 0 ? 12 : 4, (svo_light_form)form, &setup);
    }
}

static void photons_of_any_size_can_follow(void **state)
{
    static const uint32_t resolutions[] = {1, 7, 33, 200};
    const fixture opened = fixture_cl_of_group(state);
    for (size_t i = 0; i < sizeof resolutions / sizeof resolutions[0]; ++i) {
        const svo_light_setup setup = setup_of(&all_sources[i % 2], 1, resolutions[i]);
        stage of;
        uint64_t seed = 60 + i;
        open_stage(&opened, seed, &of);
        svo_light *light = make_light(&opened, svo_moving_tree(of.moving), SVO_LIGHT_FACES, &setup);
        for (int k = 0; k < 4; ++k) {
            play(&opened, &of, &seed);
            follow(&opened, &of, light);
            compare(&opened, &of, light, &setup);
        }
        svo_light_destroy(&light);
        close_stage(&of);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_moves_equal_lights_from_nothing),
        cmocka_unit_test(photons_of_any_size_can_follow),
    };
    return cmocka_run_group_tests(tests, fixture_group_setup, fixture_group_teardown);
}
