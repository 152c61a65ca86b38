/* SPDX-License-Identifier: MIT */
/* Scenes: their pictures beside those of trees, what they refuse and how they say so, the bytes that they plan. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/handle.h"
#include "scene_check.h"
#include "support/suite.h"

/* ---- pictures ---- */

#define WIDTH  64
#define HEIGHT 48

static void draw(svo_scene *scene, const svo_render_options *options, uint8_t *rgba)
{
    if (svo_render(svo_scene_target(scene), options, svo_in_host(rgba), &(svo_submit){.queue = opened.queue}) !=
        SVO_OK) {
        fail_msg("%s", svo_device_message(opened.device));
    }
}

/* Pixels with a component that differs by more than a tenth. */
static size_t count_different(const uint8_t *a, const uint8_t *b)
{
    size_t different = 0;
    for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; ++i) {
        bool same = true;
        for (size_t k = 4 * i; k < 4 * i + 4; ++k) {
            same = same && abs(a[k] - b[k]) <= 25;
        }
        different += !same;
    }
    return different;
}

/* A tree alone is drawn as without a scene: the same light, colors, normals and shadows. */
static void a_placed_tree_is_drawn_as_the_tree(void **state)
{
    (void)state;
    static uint8_t alone[WIDTH * HEIGHT * 4];
    static uint8_t placed[WIDTH * HEIGHT * 4];
    const svo_tree_info *info = &shapes.trees[0].info;
    const double voxels = (double)(1u << info->depth);
    const double voxel = ldexp(1.0, (int)info->snap_bits) / info->scale / voxels;
    svo_render_options of_tree = {.struct_size = sizeof of_tree, .width = WIDTH, .height = HEIGHT};
    svo_scene *scene = make_placed_scene(&shapes, &identity, 1, SVO_NEED_DEFAULT);
    (void)svo_camera_fit(svo_tree_target(shapes.handles[0]), (float)WIDTH / HEIGHT, &of_tree.camera);
    const svo_render_options of_scene = {.struct_size = sizeof of_scene,
                                         .width = WIDTH,
                                         .height = HEIGHT,
                                         .camera = of_tree.camera,
                                         .occlusion_range = (float)((voxels / 14 + 2) * voxel)};
    assert_int_equal(svo_render(svo_tree_target(shapes.handles[0]), &of_tree, svo_in_host(alone),
                                &(svo_submit){.queue = opened.queue}),
                     SVO_OK);
    draw(scene, &of_scene, placed);
    const size_t different = count_different(alone, placed);
    if (different > (size_t)WIDTH * HEIGHT / 100) {
        fail_msg("%zu of %d pixels differ", different, WIDTH * HEIGHT);
    }
    /* In launches of a tile each it is the same, byte for byte. */
    const cl_uint band_tiles = opened.device->band_tiles;
    memcpy(alone, placed, sizeof alone);
    memset(placed, 0, sizeof placed);
    opened.device->band_tiles = 1;
    draw(scene, &of_scene, placed);
    opened.device->band_tiles = band_tiles;
    assert_memory_equal(alone, placed, sizeof alone);
    svo_scene_destroy(&scene);
}

/* A red light reddens, more of it the more; without shadows nothing gets darker. */
static void lights_light(void **state)
{
    (void)state;
    static uint8_t pictures[3][WIDTH * HEIGHT * 4];
    svo_instance placed[30];
    uint64_t random = 12;
    random_instances(&random, PLACE_MOVED, 6, placed, 30);
    svo_scene *scene = make_placed_scene(&shapes, placed, 30, SVO_NEED_NONE);
    for (int i = 0; i < 3; ++i) {
        const svo_scene_light light = {.direction = {0, 3, 1}, .shadows = i == 1, .color = {i > 0 ? 0.5F : 0, 0, 0}};
        svo_render_options options = {
            .struct_size = sizeof options, .width = WIDTH, .height = HEIGHT, .light_count = 1, .lights = &light};
        (void)svo_camera_fit(svo_scene_target(scene), (float)WIDTH / HEIGHT, &options.camera);
        draw(scene, &options, pictures[i]);
    }
    size_t redder = 0;
    size_t shadowed = 0;
    for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; ++i) {
        assert_true(pictures[1][4 * i] >= pictures[0][4 * i] && pictures[2][4 * i] >= pictures[1][4 * i]);
        redder += pictures[1][4 * i] > pictures[0][4 * i];
        shadowed += pictures[2][4 * i] > pictures[1][4 * i];
    }
    assert_true(redder > WIDTH * HEIGHT / 20);
    assert_true(shadowed > 10);
    svo_scene_destroy(&scene);
}

/* Of two instances far apart a plane between them leaves one, with its light, from either side of the plane. */
static void a_plane_cuts_instances_away(void **state)
{
    (void)state;
    static uint8_t pictures[3][WIDTH * HEIGHT * 4];
    const svo_instance placed[2] = {{.transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}},
                                    {.transform = {1, 0, 0, 100, 0, 1, 0, 0, 0, 0, 1, 0}}};
    svo_scene *both = make_placed_scene(&shapes, placed, 2, SVO_NEED_NONE);
    svo_scene *one = make_placed_scene(&shapes, placed, 1, SVO_NEED_NONE);
    const svo_scene_light light = {.direction = {1, 0.2F, 0}, .shadows = 1, .color = {1, 1, 1}};
    svo_render_options options = {
        .struct_size = sizeof options, .width = WIDTH, .height = HEIGHT, .light_count = 1, .lights = &light};
    for (int side = 0; side < 2; ++side) {
        (void)svo_camera_fit(svo_scene_target(one), (float)WIDTH / HEIGHT, &options.camera);
        if (side == 1) { /* through the one that is cut away */
            memcpy(options.camera.eye, options.camera.target, sizeof options.camera.eye);
            options.camera.eye[0] += 150;
            options.camera.vertical_fov = 0.05F;
        }
        memset(options.clip, 0, sizeof options.clip);
        draw(one, &options, pictures[0]);
        draw(both, &options, pictures[1]);
        options.clip[0] = -2;
        options.clip[3] = 2 * 60;
        draw(both, &options, pictures[2]);
        assert_true(side == 0 || count_different(pictures[0], pictures[1]) > 20);
        assert_int_equal(count_different(pictures[0], pictures[2]), 0);
    }
    svo_scene_destroy(&both);
    svo_scene_destroy(&one);
}

/* ---- rays ---- */

/* Rays along an axis within an edge of a box, from near it or from very far: both directions, of three lengths, with
   zeros of both signs beside it. Every second one is the one before it, up to the greatest float instead of infinity.
   */
static void edge_rays(const svo_i_instance_box *box, size_t first, svo_ray *rays)
{
    static const float lengths[] = {1, 1e-30F, 1e30F};
    for (size_t i = 0; i < 48; ++i) {
        const size_t axis = i / 2 % 3;
        const float way = i / 6 % 2 == 0 ? 1.0F : -1.0F;
        const float beside = i % 4 < 2 ? 0.0F : -0.0F;
        svo_ray *ray = &rays[first + i];
        *ray = (svo_ray){.direction = {beside, beside, beside}, .t_max = i % 2 == 0 ? INFINITY : FLT_MAX};
        ray->direction[axis] = way * lengths[(first / 48 + i / 2) % 3];
        for (size_t k = 1; k < 3; ++k) {
            const size_t side = (axis + k) % 3;
            ray->origin[side] = (i / 12 >> (k - 1) & 1) == 0 ? box->low[side] : box->high[side];
        }
        ray->origin[axis] = first / 48 % 4 == 3 ? -way * 0x1p100F
                            : way > 0           ? box->low[axis] - 1.0F
                                                : box->high[axis] + 1.0F;
    }
}

/* In the slab test, such rays divide by zero and multiply up to infinity. */
static void rays_in_edges_of_boxes_have_one_answer(void **state)
{
    (void)state;
    enum { COUNT = RAYS / 48 };
    static svo_ray rays[RAYS];
    static svo_scene_hit hits[RAYS];
    static svo_scene_hit every[RAYS];
    svo_instance placed[COUNT];
    uint64_t random = 11;
    size_t met = 0;
    random_instances(&random, PLACE_SCALED, 3, placed, COUNT);
    svo_scene *scene = make_placed_scene(&shapes, placed, COUNT, SVO_NEED_NONE);
    random_scene_rays(&random, &shapes, placed, COUNT, rays, RAYS);
    for (size_t i = 0; i < COUNT; ++i) {
        edge_rays(&scene->boxes[i], 48 * i, rays);
    }
    trace_scene(scene, rays, hits, RAYS, 0, SVO_SCENE_CLOSEST);
    trace_scene(scene, rays, every, RAYS, 0, SVO_SCENE_EVERY_INSTANCE);
    assert_same_hits("edges of boxes", COUNT, hits, every, sizeof hits[0]);
    for (size_t i = 0; i + 1 < (size_t)48 * COUNT; i += 2) {
        const void *to_infinity = &hits[i];
        const void *to_greatest = &hits[i + 1];
        if (isnan(hits[i].t) || memcmp(to_infinity, to_greatest, sizeof hits[i]) != 0) {
            fail_msg("ray %zu: t %a to infinity, %a to the greatest float", i, (double)hits[i].t,
                     (double)hits[i + 1].t);
            return;
        }
        met += hits[i].instance != SVO_NO_INSTANCE;
    }
    assert_in_range(met, 10, 24 * COUNT);
    svo_scene_destroy(&scene);
}

/* ---- refusals ---- */

static void bad_matrices_are_refused_and_named(void **state)
{
    (void)state;
    static const struct {
        float transform[12];
        const char *words;
    } bad[] = {{{NAN, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, "matrix of instance 2 is not finite"},
               {{1, 0, 0, INFINITY, 0, 1, 0, 0, 0, 0, 1, 0}, "matrix of instance 2 is not finite"},
               {{0}, "matrix of instance 2 is flat"},
               {{1, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0}, "matrix of instance 2 is flat"},
               {{1, 1, 0, 0, 0, 1e-13F, 0, 0, 0, 0, 1, 0}, "matrix of instance 2 is flat"},
               {{1e35F, 0, 0, 0, 0, 1e35F, 0, 0, 0, 0, 1e35F, 0}, "instance 2 or its inverse leads beyond 2^100"},
               {{1e-35F, 0, 0, 0, 0, 1e-35F, 0, 0, 0, 0, 1e-35F, 0}, "instance 2 or its inverse leads beyond 2^100"},
               {{1, 0, 0, 3e38F, 0, 1, 0, 0, 0, 0, 1, 0}, "instance 2 or its inverse leads beyond 2^100"}};
    static svo_ray rays[RAYS];
    svo_instance placed[4] = {identity, identity, identity, identity};
    uint64_t random = 9;
    svo_scene *scene = make_placed_scene(&shapes, placed, 4, SVO_NEED_NONE);
    random_scene_rays(&random, &shapes, placed, 4, rays, RAYS);
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        float transforms[24] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0};
        svo_instance wrong[4] = {identity, identity, identity, identity};
        svo_scene *none = NULL;
        const svo_scene_options options = {sizeof options, shapes.handles, NULL, wrong, MODELS, 4, SVO_NEED_NONE, 0};
        memcpy(transforms + 12, bad[i].transform, sizeof bad[i].transform);
        memcpy(wrong[2].transform, bad[i].transform, sizeof bad[i].transform);
        expect_words(svo_scene_set_transforms(scene, 1, 2, transforms, opened.queue), SVO_INVALID_ARGUMENT,
                     bad[i].words);
        expect_words(svo_scene_create(opened.device, &options, opened.queue, &none), SVO_INVALID_ARGUMENT,
                     bad[i].words);
        assert_null(none);
    }
    /* Nothing moved. A thin one, far from flat, is accepted. */
    compare_with_new_scene(scene, placed, 4, rays);
    const float thin[12] = {1, 1, 0, 0, 0, 1e-3F, 0, 0, 0, 0, -1e3F, 0};
    assert_int_equal(svo_scene_set_transforms(scene, 3, 1, thin, opened.queue), SVO_OK);
    svo_scene_destroy(&scene);
}

static void wrong_options_are_refused(void **state)
{
    (void)state;
    const svo_scene_options good = {sizeof good, shapes.handles, NULL, &identity, MODELS, 1, SVO_NEED_NONE, 0};
    svo_tree *const with_null[MODELS] = {shapes.handles[0], NULL, shapes.handles[2]};
    const svo_instance elsewhere = {MODELS, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    svo_scene *scene = NULL;
    svo_scene_info info = SVO_SCENE_INFO_INIT;
#define REFUSED(field, value, words)                                                                        \
    do {                                                                                                    \
        svo_scene_options wrong = good;                                                                     \
        wrong.field = (value);                                                                              \
        expect_words(svo_scene_create(opened.device, &wrong, NULL, &scene), SVO_INVALID_ARGUMENT, (words)); \
        assert_null(scene);                                                                                 \
    } while (0)
    REFUSED(struct_size, 8, "struct_size is 8");
    REFUSED(trees, NULL, "options.trees and options.compacts are NULL");
    REFUSED(trees, with_null, "trees[1] is NULL");
    REFUSED(tree_count, 0, "tree_count 0 is not in 1 .. 65536");
    REFUSED(tree_count, SVO_SCENE_TREES_MAX + 1, "tree_count 65537");
    REFUSED(instance_count, 0, "instance_count 0 is not in 1 .. 16777216");
    REFUSED(instance_count, SVO_SCENE_INSTANCES_MAX + 1, "instance_count 16777217");
    REFUSED(instances, NULL, "options.instances is NULL");
    REFUSED(instances, &elsewhere, "the tree of instance 0 is 3, not below 3");
    REFUSED(need, SVO_NEED_FILL, "options.need 0x10 has bits other than");
#undef REFUSED
    assert_int_equal(svo_scene_create(NULL, &good, NULL, &scene), SVO_INVALID_ARGUMENT);
    expect_words(svo_scene_create(opened.device, NULL, NULL, &scene), SVO_INVALID_ARGUMENT, "options is NULL");
    expect_words(svo_scene_create(opened.device, &good, NULL, NULL), SVO_INVALID_ARGUMENT, "scene is NULL");
    expect_words(svo_scene_plan(opened.device, &good, NULL), SVO_INVALID_ARGUMENT, "info is NULL");
    assert_int_equal(svo_scene_plan(NULL, &good, &info), SVO_INVALID_ARGUMENT);
    svo_scene_destroy(NULL);
    svo_scene_destroy(&scene);
}

static void wrong_arguments_are_refused(void **state)
{
    (void)state;
    svo_scene *scene = make_placed_scene(&shapes, &identity, 1, SVO_NEED_NONE);
    svo_ray ray = {.t_max = 1};
    svo_scene_hit hit;
    svo_scene_triangle_hit triangle;
    svo_scene_info info = {.struct_size = 4};
    expect_words(svo_scene_set_transforms(scene, 1, 1, identity.transform, NULL), SVO_INVALID_ARGUMENT,
                 "first 1 and count 1 lead beyond the 1 instances");
    expect_words(svo_scene_set_transforms(scene, 0xffffffffu, 2, identity.transform, NULL), SVO_INVALID_ARGUMENT,
                 "lead beyond");
    expect_words(svo_scene_set_transforms(scene, 0, 1, NULL, NULL), SVO_INVALID_ARGUMENT, "transforms is NULL");
    assert_int_equal(svo_scene_set_transforms(scene, 1, 0, NULL, NULL), SVO_OK);
    assert_int_equal(svo_scene_set_transforms(NULL, 0, 0, NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_scene_rebuild(NULL, NULL), SVO_INVALID_ARGUMENT);
    expect_words(svo_trace_voxels(svo_scene_target(scene), svo_in_host(NULL), svo_in_host(&hit), 1, 0, 0, NULL),
                 SVO_INVALID_ARGUMENT, "rays is NULL");
    expect_words(svo_trace_voxels(svo_scene_target(scene), svo_in_host(&ray), svo_in_host(NULL), 1, 0, 0, NULL),
                 SVO_INVALID_ARGUMENT, "hits is NULL");
    expect_words(svo_trace_voxels(svo_scene_target(scene), svo_in_host(&ray), svo_in_host(&hit),
                                  (size_t)SVO_TRACE_RAYS_MAX + 1, 0, 0, NULL),
                 SVO_INVALID_ARGUMENT, "are above");
    expect_words(svo_trace_voxels(svo_scene_target(scene), svo_in_host(&ray), svo_in_host(&hit), 1, -1, 0, NULL),
                 SVO_INVALID_ARGUMENT, "footprint -1");
    expect_words(svo_trace_voxels(svo_scene_target(scene), svo_in_host(&ray), svo_in_host(&hit), 1, NAN, 0, NULL),
                 SVO_INVALID_ARGUMENT, "footprint");
    expect_words(svo_trace_voxels(svo_scene_target(scene), svo_in_host(&ray), svo_in_host(&hit), 1, 0, 4, NULL),
                 SVO_INVALID_ARGUMENT, "flags 4 is not in 0 .. 3");
    expect_words(svo_trace_triangles(svo_scene_target(scene), svo_in_host(&ray), svo_in_host(&triangle), 1, 0, NULL),
                 SVO_INVALID_ARGUMENT, "holds no triangles");
    assert_int_equal(svo_trace_voxels(svo_scene_target(scene), svo_in_host(NULL), svo_in_host(NULL), 0, 0, 0, NULL),
                     SVO_OK);
    assert_int_equal(svo_trace_voxels(svo_scene_target(NULL), svo_in_host(&ray), svo_in_host(&hit), 1, 0, 0, NULL),
                     SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_trace_triangles(svo_scene_target(NULL), svo_in_host(&ray), svo_in_host(&triangle), 1, 0, NULL),
                     SVO_INVALID_ARGUMENT);
    expect_words(svo_scene_get_info(scene, &info), SVO_INVALID_ARGUMENT, "info.struct_size");
    assert_int_equal(svo_scene_get_info(NULL, &info), SVO_INVALID_ARGUMENT);
    svo_scene_destroy(&scene);
}

static void wrong_pictures_are_refused(void **state)
{
    (void)state;
    static uint8_t rgba[8 * 8 * 4];
    const svo_scene_light light = {.direction = {0, 1, 0}, .color = {1, 1, 1}};
    const svo_scene_light dark = {.direction = {0, 1, 0}, .color = {1, -1, 1}};
    svo_render_options good = {.struct_size = sizeof good, .width = 8, .height = 8, .light_count = 1, .lights = &light};
    svo_scene *scene = make_placed_scene(&shapes, &identity, 1, SVO_NEED_NONE);
    (void)svo_camera_fit(svo_scene_target(scene), 1, &good.camera);
#define REFUSED(field, value, words)                                                                              \
    do {                                                                                                          \
        svo_render_options wrong = good;                                                                          \
        wrong.field = (value);                                                                                    \
        expect_words(                                                                                             \
            svo_render(svo_scene_target(scene), &wrong, svo_in_host(rgba), &(svo_submit){.queue = opened.queue}), \
            SVO_INVALID_ARGUMENT, (words));                                                                       \
    } while (0)
    REFUSED(struct_size, 16, "struct_size is 16");
    REFUSED(width, 0, "0 x 8 pixels");
    REFUSED(height, 16385, "8 x 16385 pixels");
    REFUSED(camera.vertical_fov, 4, "vertical_fov 4");
    REFUSED(camera.up[1], NAN, "camera.eye, target and up");
    REFUSED(light_count, SVO_SCENE_LIGHTS_MAX + 1, "light_count 9 is above 8");
    REFUSED(lights, NULL, "or options.lights is NULL");
    REFUSED(lights, &dark, "options.lights[0]");
    REFUSED(occlusion_range, -1, "occlusion_range -1");
    REFUSED(clip[1], NAN, "is not finite");
#undef REFUSED
    expect_words(svo_render(svo_scene_target(scene), NULL, svo_in_host(rgba), NULL), SVO_INVALID_ARGUMENT,
                 "options is NULL");
    expect_words(svo_render(svo_scene_target(scene), &good, svo_in_host(NULL), NULL), SVO_INVALID_ARGUMENT,
                 "pixels is NULL");
    assert_int_equal(svo_render(svo_scene_target(NULL), &good, svo_in_host(rgba), NULL), SVO_INVALID_ARGUMENT);
    svo_scene_destroy(&scene);
}

/* ---- bytes ---- */

static void a_plan_lists_what_is_allocated(void **state)
{
    (void)state;
    svo_instance placed[70];
    uint64_t random = 10;
    random_instances(&random, PLACE_MOVED, 10, placed, 70);
    static const uint32_t needs[] = {SVO_NEED_NONE, SVO_NEED_DEFAULT,
                                     (uint32_t)SVO_NEED_RAYS | (uint32_t)SVO_NEED_COLOR};
    for (size_t k = 0; k < sizeof needs / sizeof needs[0]; ++k) {
        const svo_scene_options options = {sizeof options, shapes.handles, NULL, NULL, MODELS, 70, needs[k], 0};
        svo_scene_info planned = SVO_SCENE_INFO_INIT;
        svo_scene_info made = SVO_SCENE_INFO_INIT;
        assert_int_equal(svo_scene_plan(opened.device, &options, &planned), SVO_OK);
        svo_scene *scene = make_placed_scene(&shapes, placed, 70, needs[k]);
        assert_int_equal(svo_scene_get_info(scene, &made), SVO_OK);
        uint64_t bytes = 0;
        for (int i = 0; i < SVO_I_SCENE_BUFFERS; ++i) {
            size_t of_buffer = 0;
            if (scene->buffers[i] != NULL) {
                clGetMemObjectInfo(scene->buffers[i], CL_MEM_SIZE, sizeof of_buffer, &of_buffer, NULL);
            }
            bytes += of_buffer;
        }
        assert_int_equal(made.total_bytes, bytes);
        assert_int_equal(planned.total_bytes, bytes);
        assert_int_equal(planned.tree_bytes + planned.instance_bytes + planned.hierarchy_bytes + planned.sort_bytes,
                         bytes);
        assert_int_equal(planned.tree_bytes, made.tree_bytes);
        const uint32_t payload = (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL;
        const uint32_t held = needs[k] == SVO_NEED_DEFAULT ? payload : needs[k] & ~(uint32_t)SVO_NEED_NONE;
        assert_int_equal(made.need, held);
        assert_int_equal(planned.need, held);
        assert_int_equal(scene->buffers[SVO_I_SCENE_NORMALS] != NULL, (held & (uint32_t)SVO_NEED_NORMAL) != 0);
        svo_scene_destroy(&scene);
    }
}

TEST_GROUP(scene_limits)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_placed_tree_is_drawn_as_the_tree),
        cmocka_unit_test(lights_light),
        cmocka_unit_test(a_plane_cuts_instances_away),
        cmocka_unit_test(wrong_pictures_are_refused),
        cmocka_unit_test(bad_matrices_are_refused_and_named),
        cmocka_unit_test(wrong_options_are_refused),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(a_plan_lists_what_is_allocated),
        cmocka_unit_test(rays_in_edges_of_boxes_have_one_answer),
    };
    return cmocka_run_group_tests_name("scene_limits", tests, scene_group_open, scene_group_close);
}
