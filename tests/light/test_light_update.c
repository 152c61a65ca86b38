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

#include "support/attributed_mesh.h"
#include "support/enqueued.h"
#include "support/fixture.h"
#include "support/memory_ledger.h"
#include "support/suite.h"

enum { OBJECTS = 5, DEPTH = 6, BOXES = 64 };

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
                                        .need = SVO_NEED_ALL,
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
    succeed(opened, svo_moving_update(out->moving, NULL, NULL));
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
    svo_moving_report report = SVO_MOVING_REPORT_INIT;
    succeed(opened, svo_moving_update(of->moving, &(svo_submit){.queue = opened->queue}, &report));
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

/* A hundred moves where SVOCL_LONG_TESTS is set (tools/dev long). */
static void random_moves_equal_lights_from_nothing(void **state)
{
    const int moves = suite_is_long() ? 100 : 8;
    const fixture opened = fixture_cl_of_group(state);
    const svo_light_setup setup = setup_of(all_sources, 3, 0);
    for (int form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
        compare_moves(&opened, 40 + (uint64_t)form, form == 0 ? moves : 4, (svo_light_form)form, &setup);
    }
    /* Photons that go through what shows in part, whose alpha what moves changes. */
    svo_light_setup clear = setup;
    clear.photon_alpha = 1;
    compare_moves(&opened, 44, moves, SVO_LIGHT_FACES, &clear);
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

/* ---- what is the same for all leaves ---- */

/* The unit of radiance, when something comes to the source and goes. Most leaves keep their light. */
static void the_brightest_leaf_sets_the_unit(void **state)
{
    static const double at[2][3] = {{0.17, 0.82, 0.22}, {0.5, 0.5, 0.5}};
    const fixture opened = fixture_cl_of_group(state);
    const svo_light_setup setup = setup_of(all_sources, 1, 60);
    stage of;
    open_stage(&opened, 17, &of);
    svo_light *light = make_light(&opened, svo_moving_tree(of.moving), SVO_LIGHT_FACES, &setup);
    for (int i = 0; i < 4; ++i) {
        double transform[12];
        transform_of(transform, 0.05, 0.3, at[i % 2]);
        succeed(&opened, svo_moving_set_transform(of.moving, 0, transform));
        follow(&opened, &of, light);
        assert_true(info_of(&opened, light).traced_photons < info_of(&opened, light).photons);
        compare(&opened, &of, light, &setup);
    }
    svo_light_destroy(&light);
    close_stage(&of);
}

/* A lid closes a box: areas of leaves far from it count from one side then, and from both without it. */
static void a_lid_changes_all_areas(void **state)
{
    static const float corners[8][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0},
                                        {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}};
    static const uint32_t walls[30] = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5,
                                       0, 5, 4, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
    static const uint32_t lid[6] = {2, 6, 7, 2, 7, 3};
    const fixture opened = fixture_cl_of_group(state);
    const svo_light_setup setup = setup_of(all_sources, 1, 40);
    const svo_moving_options options = {.struct_size = sizeof options,
                                        .need = (uint32_t)SVO_NEED_RAYS | (uint32_t)SVO_NEED_PROJECTED_AREA,
                                        .origin = {-0.1, -0.1, -0.1},
                                        .edge = 1.2,
                                        .max_area = 9.0};
    svo_mesh mesh = {.struct_size = sizeof mesh, .positions = &corners[0][0], .vertex_count = 8};
    stage of = {.moving = NULL};
    uint32_t object = 77;
    mesh.indices = walls;
    mesh.triangle_count = 10;
    succeed(&opened, svo_moving_create(opened.device, &mesh, 5, &options, opened.queue, &of.moving));
    mesh.indices = lid;
    mesh.triangle_count = 2;
    succeed(&opened, svo_moving_add(of.moving, &mesh, NULL, &object));
    succeed(&opened, svo_moving_update(of.moving, NULL, NULL));
    svo_light *light = make_light(&opened, svo_moving_tree(of.moving), SVO_LIGHT_FACES, &setup);
    for (int i = 0; i < 4; ++i) {
        svo_box boxes[2]; /* the grid and the lid */
        size_t count = 0;
        succeed(&opened, svo_moving_show(of.moving, object, i % 2 != 0));
        follow(&opened, &of, light);
        succeed(&opened, svo_moving_get_changes(of.moving, boxes, 2, &count));
        assert_int_equal(count, 2);
        assert_true(boxes[0].low[1] < -0.09 && boxes[0].high[1] > 1.09);
        compare(&opened, &of, light, &setup);
    }
    svo_light_destroy(&light);
    svo_moving_destroy(&of.moving);
}

/* ---- when all photons are shot ---- */

static void assert_all_are_shot(const fixture *opened, const svo_light *light)
{
    const svo_light_info info = info_of(opened, light);
    assert_int_equal(info.traced_photons, info.photons);
}

/* What moves through a wall changes the bounds of the leaves, and so the views. */
static void bounds_that_change_make_other_views(void **state)
{
    static const double at[3] = {1.02, 0.5, 0.5};
    const fixture opened = fixture_cl_of_group(state);
    const svo_light_setup setup = setup_of(all_sources, 3, 0);
    uint64_t seed = 5;
    double transform[12];
    stage of;
    open_stage(&opened, seed, &of);
    svo_light *light = make_light(&opened, svo_moving_tree(of.moving), SVO_LIGHT_FACES, &setup);
    transform_of(transform, 0.06, 0.5, at);
    succeed(&opened, svo_moving_set_transform(of.moving, 1, transform));
    follow(&opened, &of, light);
    assert_all_are_shot(&opened, light);
    compare(&opened, &of, light, &setup);
    random_transform(&seed, transform);
    succeed(&opened, svo_moving_set_transform(of.moving, 2, transform)); /* inside; the other stays */
    follow(&opened, &of, light);
    assert_true(info_of(&opened, light).traced_photons < info_of(&opened, light).photons / 2);
    compare(&opened, &of, light, &setup);
    svo_light_destroy(&light);
    close_stage(&of);
}

/* Other sources between updates; photons that are counted, not kept, or not there. */
static void every_setup_can_follow(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    uint64_t seed = 9;
    stage of;
    open_stage(&opened, seed, &of);
    svo_light_setup setup = setup_of(all_sources, 3, 40);
    svo_light *light = make_light(&opened, svo_moving_tree(of.moving), SVO_LIGHT_BRICKS, &setup);
    for (int i = 0; i < 8; ++i) {
        setup = setup_of(&all_sources[i % 3], i == 4 ? 0 : 1, 40);
        setup.bounces = i == 6 ? 3 : 1;
        setup.emission_photons = i == 7 ? 5000 : 0;
        setup.diagnose = i == 1;
        setup.updatable = i != 2;
        setup.no_photons = i == 3;
        succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
        assert_int_equal(info_of(&opened, light).kept_bytes > 0, i != 1 && i != 2 && i < 6);
        for (int k = 0; k < 2; ++k) {
            play(&opened, &of, &seed);
            follow(&opened, &of, light);
            compare(&opened, &of, light, &setup);
        }
    }
    svo_light_destroy(&light);
    close_stage(&of);
}

/* A light without sources has opacity alone. */
static void dark_lights_can_follow(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_light_options options = {.struct_size = sizeof options, .form = SVO_LIGHT_VOXELS};
    char hashes[2][SVO_HASH_TEXT_BYTES];
    uint64_t seed = 3;
    stage of;
    svo_light *light = NULL;
    svo_light *expected = NULL;
    open_stage(&opened, seed, &of);
    succeed(&opened, svo_light_create(svo_moving_tree(of.moving), &options, opened.queue, &light));
    play(&opened, &of, &seed);
    follow(&opened, &of, light);
    succeed(&opened, svo_light_create(svo_moving_tree(of.moving), &options, opened.queue, &expected));
    succeed(&opened, svo_light_hash(light, opened.queue, hashes[0]));
    succeed(&opened, svo_light_hash(expected, opened.queue, hashes[1]));
    assert_string_equal(hashes[0], hashes[1]);
    svo_light_destroy(&expected);
    svo_light_destroy(&light);
    close_stage(&of);
}

/* ---- failures ---- */

static void assert_refused(const fixture *opened, svo_status status, const char *words)
{
    assert_int_equal(status, SVO_INVALID_ARGUMENT);
    if (strstr(svo_device_message(opened->device), words) == NULL) {
        fail_msg("\"%s\" does not say \"%s\"", svo_device_message(opened->device), words);
        return;
    }
}

static void what_is_refused_leaves_the_light(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_light_setup setup = setup_of(all_sources, 3, 40);
    svo_box box = {.low = {0, 0, 0}, .high = {1, 1, 1}};
    uint64_t seed = 12;
    stage of;
    open_stage(&opened, seed, &of);
    svo_tree *tree = svo_moving_tree(of.moving);
    svo_light *light = make_light(&opened, tree, SVO_LIGHT_FACES, &setup);
    assert_int_equal(svo_light_update(NULL, tree, NULL, 0, NULL), SVO_INVALID_ARGUMENT);
    assert_refused(&opened, svo_light_update(light, NULL, NULL, 0, NULL), "tree is NULL");
    assert_refused(&opened, svo_light_update(light, tree, NULL, 1, NULL), "changed is NULL");
    assert_refused(&opened, svo_light_update(light, tree, &box, SVO_LIGHT_BOXES_MAX + 1u, NULL), "above 1048576");
    box.high[1] = -1;
    assert_refused(&opened, svo_light_update(light, tree, &box, 1, NULL), "changed[0].low[1] 0 is above high -1");
    box.high[1] = (double)NAN;
    assert_refused(&opened, svo_light_update(light, tree, &box, 1, NULL), "changed[0] is not finite");
    compare(&opened, &of, light, &setup);
    play(&opened, &of, &seed);
    follow(&opened, &of, light);
    assert_true(info_of(&opened, light).traced_photons < info_of(&opened, light).photons);
    compare(&opened, &of, light, &setup);
    svo_light_destroy(&light);
    close_stage(&of);
}

/* Boxes of a later change are not all that has changed since. */
static void updates_after_a_failure_begin_anew(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_light_setup setup = setup_of(all_sources, 3, 40);
    const svo_plan_options refused = {.need = SVO_NEED_NORMAL, .payload_level = 1};
    uint64_t seed = 33;
    stage of;
    built other;
    open_stage(&opened, seed, &of);
    fixture_build(&opened, &of.room.mesh, DEPTH, &refused, &other);
    svo_light *light = make_light(&opened, svo_moving_tree(of.moving), SVO_LIGHT_FACES, &setup);
    follow(&opened, &of, light);
    play(&opened, &of, &seed);
    succeed(&opened, svo_moving_update(of.moving, NULL, NULL));
    assert_refused(&opened, svo_light_update(light, other.tree, NULL, 0, opened.queue), "payload begins at level 1");
    assert_int_equal(info_of(&opened, light).kept_bytes, 0);
    play(&opened, &of, &seed);
    follow(&opened, &of, light);
    assert_all_are_shot(&opened, light);
    compare(&opened, &of, light, &setup);
    svo_light_destroy(&light);
    built_destroy(&other);
    close_stage(&of);
}

/* Without the box of an object that has gone. The next update shoots all photons. */
static void missing_boxes_are_told(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_light_setup setup = setup_of(all_sources, 3, 0);
    stage of;
    open_stage(&opened, 21, &of);
    svo_light *light = make_light(&opened, svo_moving_tree(of.moving), SVO_LIGHT_FACES, &setup);
    succeed(&opened, svo_moving_show(of.moving, 0, 0));
    succeed(&opened, svo_moving_update(of.moving, NULL, NULL));
    assert_refused(&opened, svo_light_update(light, svo_moving_tree(of.moving), NULL, 0, opened.queue),
                   "outside the boxes");
    assert_int_equal(info_of(&opened, light).kept_bytes, 0);
    succeed(&opened, svo_light_update(light, svo_moving_tree(of.moving), NULL, 0, opened.queue));
    assert_all_are_shot(&opened, light);
    compare(&opened, &of, light, &setup);
    svo_light_destroy(&light);
    close_stage(&of);
}

/* ---- memory ---- */

static void memory_is_flat(void **state)
{
    enum { PERIOD = 16 * 5, UPDATES = 6 * PERIOD + 24, WARM = PERIOD + 23 }; /* in the same place at the end */
    (void)state;
    if (getenv("SVOCL_TEST_PATH") != NULL) {
        print_message("skipped: the host's memory does not depend on the kernels\n");
        skip();
    }
    const svo_device_options device_options = {.struct_size = sizeof device_options, .memory = &ledger_callbacks};
    const float positions[27] = {0,    0,    0,    1,    0,    0,    0,    0,    1, /* floor */
                                 0,    0,    0,    1,    0.9F, 1,    0,    0,    1, /* slope */
                                 0.5F, 0.5F, 0.5F, 0.6F, 0.5F, 0.5F, 0.5F, 0.5F, 0.6F};
    const svo_mesh room = {.struct_size = sizeof room, .positions = positions, .vertex_count = 6, .triangle_count = 2};
    const svo_mesh tile = {
        .struct_size = sizeof tile, .positions = positions + 18, .vertex_count = 3, .triangle_count = 1};
    const svo_moving_options options = {
        .struct_size = sizeof options, .need = SVO_NEED_RAYS, .edge = 1.2, .max_area = 9.0};
    const svo_light_setup setup = setup_of(&all_sources[2], 1, 0);
    fixture opened = {.device = NULL};
    stage of = {.moving = NULL};
    uint64_t blocks = 0;
    uint64_t bytes = 0;
    uint32_t object = 0;
    assert_int_equal(svo_device_create_default(&device_options, &opened.device, NULL), SVO_OK);
    succeed(&opened, svo_moving_create(opened.device, &room, 4, &options, NULL, &of.moving));
    succeed(&opened, svo_moving_add(of.moving, &tile, NULL, &object));
    succeed(&opened, svo_moving_update(of.moving, NULL, NULL));
    svo_light *light = make_light(&opened, svo_moving_tree(of.moving), SVO_LIGHT_FACES, &setup);
    for (int i = 0; i < UPDATES; ++i) {
        const double shift = (double)(i % 16) / 64.0 - 0.1;
        const double transform[12] = {1, 0, 0, shift, 0, 1, 0, 0, 0, 0, 1, -shift};
        succeed(&opened, svo_moving_set_transform(of.moving, object, transform));
        succeed(&opened, svo_moving_show(of.moving, object, i % 5 != 0));
        follow(&opened, &of, light);
        if (i == WARM) {
            ledger_begin(LEDGER_NEVER);
            blocks = ledger_end().live_blocks;
            bytes = info_of(&opened, light).kept_bytes;
        }
    }
    assert_int_equal(info_of(&opened, light).kept_bytes, bytes);
    assert_true(info_of(&opened, light).traced_photons < info_of(&opened, light).photons);
    compare(&opened, &of, light, &setup);
    assert_int_equal(ledger_end().live_blocks, blocks);
    assert_null(ledger_end().wrong);
    svo_light_destroy(&light);
    svo_moving_destroy(&of.moving);
    fixture_close(&opened);
}

TEST_GROUP(light_update)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_moves_equal_lights_from_nothing),
        cmocka_unit_test(photons_of_any_size_can_follow),
        cmocka_unit_test(the_brightest_leaf_sets_the_unit),
        cmocka_unit_test(a_lid_changes_all_areas),
        cmocka_unit_test(bounds_that_change_make_other_views),
        cmocka_unit_test(every_setup_can_follow),
        cmocka_unit_test(dark_lights_can_follow),
        cmocka_unit_test(what_is_refused_leaves_the_light),
        cmocka_unit_test(updates_after_a_failure_begin_anew),
        cmocka_unit_test(missing_boxes_are_told),
        cmocka_unit_test(memory_is_flat),
    };
    return cmocka_run_group_tests_name("light_update", tests, fixture_group_setup, fixture_group_teardown);
}
