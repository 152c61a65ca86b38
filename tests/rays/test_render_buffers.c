/* SPDX-License-Identifier: MIT */
/*
 * Pictures in buffers of the caller's: of trees, compact trees, scenes and lights. Their bytes are those of pictures
 * for the host; they wait for the caller's events and nothing waits for them, but where there is no svo_submit; what
 * cannot take a picture is refused and stays as it is. And what of each pixel is written: bytes or floats, samples,
 * backgrounds, and what shows in part.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "light/light_fixture.h"
#include "scenes.h"
#include "support/info_of.h"
#include "support/suite.h"

#define DEPTH 5
/* No multiples of a tile's edge. */
#define WIDTH         37
#define HEIGHT        41
#define PICTURE_BYTES ((size_t)WIDTH * HEIGHT * 4)
/* Behind a picture's bytes; nothing may touch them. */
#define GUARD_BYTES 4096
#define BYTES       (PICTURE_BYTES + GUARD_BYTES)
#define UNTOUCHED   0x5a

/* ---- what is drawn ---- */

/* Pictures of different kinds of handles. */
enum { SHADED, NORMALS, COMPACT, SCENE, LIGHT, PICTURES };
static const char *const names[PICTURES] = {"shaded", "normals", "compact", "scene", "light"};

typedef struct drawn {
    fixture opened;
    built made;
    svo_compact *compact;
    svo_scene *scene;
    svo_light *light;
    svo_target targets[PICTURES];
    svo_render_options asked[PICTURES];
    svo_gather_options gather; /* of the light */
} drawn;

/* Where a picture goes, and when. */
typedef struct place {
    cl_mem pixels;
    svo_submit submit;
} place;

static svo_status enqueue(const drawn *of, size_t picture, const place *to)
{
    return svo_render(of->targets[picture], &of->asked[picture], svo_in_buffer(to->pixels), &to->submit);
}

/* For the host. */
static svo_status draw(const drawn *of, size_t picture, void *pixels)
{
    return svo_render(of->targets[picture], &of->asked[picture], svo_in_host(pixels), NULL);
}

static void make_light(drawn *of)
{
    const svo_light_source lamp = {.kind = SVO_SOURCE_POINT, .position = {0.5F, 0.5F, 2.0F}, .value = {9, 9, 9}};
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    setup.sources = &lamp;
    setup.source_count = 1;
    setup.sky[0] = setup.sky[1] = setup.sky[2] = 0.5F;
    of->light = light_of(&of->opened, of->made.tree, SVO_LIGHT_VOXELS);
    light_succeed(&of->opened, svo_light_set_sources(of->light, &setup, of->opened.queue));
    of->gather = (svo_gather_options){.struct_size = sizeof of->gather, .cones = 5};
    of->asked[LIGHT].gather = &of->gather;
}

static drawn *make_drawn(void **state)
{
    static const svo_instance instance = {0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    const svo_plan_options everything = {.struct_size = sizeof everything, .need = SVO_NEED_ALL};
    const svo_compact_options masks = {.struct_size = sizeof masks, .form = SVO_FORM_IMPLIED};
    drawn *of = calloc(1, sizeof *of);
    struct scene *knot = fixture_scene("knot:500");
    assert_non_null(of);
    of->opened = fixture_cl_of_group(state);
    fixture_build(&of->opened, scene_mesh(knot), DEPTH, &everything, &of->made);
    const svo_scene_options options = {.struct_size = sizeof options,
                                       .trees = &of->made.tree,
                                       .instances = &instance,
                                       .tree_count = 1,
                                       .instance_count = 1};
    light_succeed(&of->opened,
                  svo_compact_create(of->opened.device, of->made.tree, &masks, of->opened.queue, &of->compact));
    light_succeed(&of->opened, svo_scene_create(of->opened.device, &options, of->opened.queue, &of->scene));
    svo_render_options asked = {.struct_size = sizeof asked, .width = WIDTH, .height = HEIGHT};
    (void)svo_camera_fit(svo_tree_target(of->made.tree), (float)WIDTH / HEIGHT, &asked.camera);
    for (size_t i = 0; i < PICTURES; ++i) {
        of->asked[i] = asked;
    }
    of->asked[NORMALS].view = SVO_VIEW_NORMAL;
    make_light(of);
    of->targets[SHADED] = of->targets[NORMALS] = svo_tree_target(of->made.tree);
    of->targets[COMPACT] = svo_compact_target(of->compact);
    of->targets[SCENE] = svo_scene_target(of->scene);
    of->targets[LIGHT] = svo_light_target(of->light);
    scene_destroy(&knot);
    return of;
}

static void release_drawn(drawn *of)
{
    svo_light_destroy(&of->light);
    svo_scene_destroy(&of->scene);
    svo_compact_destroy(&of->compact);
    built_destroy(&of->made);
    free(of);
}

/* ---- buffers ---- */

static cl_mem make_pixels(const drawn *of, cl_mem_flags flags, size_t bytes)
{
    cl_int error = CL_SUCCESS;
    uint8_t *content = malloc(bytes);
    assert_non_null(content);
    memset(content, UNTOUCHED, bytes);
    cl_mem made =
        clCreateBuffer(info_of_device(of->opened.device).context, flags | CL_MEM_COPY_HOST_PTR, bytes, content, &error);
    free(content);
    assert_int_equal(error, CL_SUCCESS);
    return made;
}

/* By a queue that no picture is drawn on. */
static void read_pixels(const drawn *of, cl_mem pixels, size_t bytes, uint8_t *out)
{
    cl_command_queue queue = clCreateCommandQueue(info_of_device(of->opened.device).context,
                                                  info_of_device(of->opened.device).device, 0, NULL);
    assert_non_null(queue);
    assert_int_equal(clEnqueueReadBuffer(queue, pixels, CL_TRUE, 0, bytes, out, 0, NULL, NULL), CL_SUCCESS);
    clReleaseCommandQueue(queue);
}

static void assert_untouched(const char *what, const uint8_t *bytes, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        if (bytes[i] != UNTOUCHED) {
            fail_msg("%s: byte %zu of %zu is 0x%02x", what, i, count, bytes[i]);
            return;
        }
    }
}

static void succeed(const drawn *of, const char *function, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s: %s", function, svo_name(SVO_NAME_STATUS, status), svo_device_message(of->opened.device));
    }
}

/* ---- bytes ---- */

static void compare_with_host(const drawn *of, size_t picture, cl_command_queue queue)
{
    static uint8_t expected[PICTURE_BYTES];
    static uint8_t found[BYTES];
    cl_event done = NULL;
    cl_mem pixels = make_pixels(of, CL_MEM_WRITE_ONLY, BYTES);
    const place to = {.pixels = pixels, .submit = {.queue = queue, .event = &done}};
    memset(expected, UNTOUCHED, sizeof expected);
    succeed(of, names[picture], draw(of, picture, expected));
    succeed(of, names[picture], enqueue(of, picture, &to));
    assert_non_null(done);
    assert_int_equal(clWaitForEvents(1, &done), CL_SUCCESS);
    clReleaseEvent(done);
    read_pixels(of, pixels, BYTES, found);
    assert_memory_equal(found, expected, PICTURE_BYTES);
    assert_untouched(names[picture], found + PICTURE_BYTES, GUARD_BYTES);
    clReleaseMemObject(pixels);
}

/* The call waits: for a buffer without an svo_submit, and for the host with one. */
static void compare_what_waits(const drawn *of, size_t picture, cl_command_queue queue)
{
    static uint8_t expected[PICTURE_BYTES];
    static uint8_t found[BYTES];
    cl_event done = NULL;
    cl_int state = CL_QUEUED;
    cl_mem pixels = make_pixels(of, CL_MEM_WRITE_ONLY, BYTES);
    succeed(of, names[picture], draw(of, picture, expected));
    succeed(of, names[picture], svo_render(of->targets[picture], &of->asked[picture], svo_in_buffer(pixels), NULL));
    read_pixels(of, pixels, BYTES, found);
    assert_memory_equal(found, expected, PICTURE_BYTES);
    assert_untouched(names[picture], found + PICTURE_BYTES, GUARD_BYTES);
    memset(found, UNTOUCHED, sizeof found);
    succeed(of, names[picture],
            svo_render(of->targets[picture], &of->asked[picture], svo_in_host(found),
                       &(svo_submit){.queue = queue, .event = &done}));
    assert_non_null(done);
    assert_int_equal(clGetEventInfo(done, CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof state, &state, NULL), CL_SUCCESS);
    assert_int_equal(state, CL_COMPLETE);
    assert_memory_equal(found, expected, PICTURE_BYTES);
    assert_untouched(names[picture], found + PICTURE_BYTES, GUARD_BYTES);
    clReleaseEvent(done);
    clReleaseMemObject(pixels);
}

static void buffers_have_the_bytes_of_host_pictures(void **state)
{
    drawn *of = make_drawn(state);
    cl_command_queue any_order =
        clCreateCommandQueue(info_of_device(of->opened.device).context, info_of_device(of->opened.device).device,
                             CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, NULL);
    for (size_t i = 0; i < PICTURES; ++i) {
        compare_with_host(of, i, of->opened.queue);
        compare_what_waits(of, i, of->opened.queue);
        if (any_order != NULL) {
            compare_with_host(of, i, any_order);
            compare_what_waits(of, i, any_order);
        }
    }
    if (any_order != NULL) {
        clReleaseCommandQueue(any_order);
    }
    release_drawn(of);
}

/* A part of a larger buffer. */
static void sub_buffers_put_pictures_elsewhere(void **state)
{
    static uint8_t expected[PICTURE_BYTES];
    static uint8_t found[BYTES];
    drawn *of = make_drawn(state);
    for (size_t i = 0; i < PICTURES; ++i) {
        cl_int error = CL_SUCCESS;
        const cl_buffer_region region = {GUARD_BYTES, PICTURE_BYTES};
        cl_mem pixels = make_pixels(of, CL_MEM_READ_WRITE, BYTES);
        cl_mem part = clCreateSubBuffer(pixels, 0, CL_BUFFER_CREATE_TYPE_REGION, &region, &error);
        assert_int_equal(error, CL_SUCCESS);
        const place to = {.pixels = part, .submit = {.queue = of->opened.queue}};
        succeed(of, names[i], draw(of, i, expected));
        succeed(of, names[i], enqueue(of, i, &to));
        assert_int_equal(clFinish(of->opened.queue), CL_SUCCESS);
        clReleaseMemObject(part);
        read_pixels(of, pixels, BYTES, found);
        assert_memory_equal(found + GUARD_BYTES, expected, PICTURE_BYTES);
        assert_untouched(names[i], found, GUARD_BYTES);
        clReleaseMemObject(pixels);
    }
    release_drawn(of);
}

/* The second band alone, at its place in the picture. */
static void bands_of_light_go_to_their_place(void **state)
{
    static uint8_t expected[PICTURE_BYTES];
    static uint8_t found[BYTES];
    const size_t begin = (size_t)WIDTH * SVO_LIGHT_BAND_ROWS * 4;
    drawn *of = make_drawn(state);
    cl_mem pixels = make_pixels(of, CL_MEM_READ_WRITE, BYTES);
    const place to = {.pixels = pixels, .submit = {.queue = of->opened.queue}};
    succeed(of, "light", draw(of, LIGHT, expected));
    of->asked[LIGHT].first_row = of->asked[LIGHT].row_count = SVO_LIGHT_BAND_ROWS;
    succeed(of, "band", enqueue(of, LIGHT, &to));
    assert_int_equal(clFinish(of->opened.queue), CL_SUCCESS);
    read_pixels(of, pixels, BYTES, found);
    assert_untouched("above the band", found, begin);
    assert_memory_equal(found + begin, expected + begin, begin);
    assert_untouched("below the band", found + 2 * begin, BYTES - 2 * begin);
    clReleaseMemObject(pixels);
    release_drawn(of);
}

/* ---- what of a pixel is written ---- */

#define SKY   0 /* a corner of the picture, where nothing is met */
#define SHARE (1.0 / 255.0)

/* Of all pictures. */
static void ask(drawn *of, const svo_picture_output *output)
{
    for (size_t i = 0; i < PICTURES; ++i) {
        of->asked[i].output = *output;
    }
}

/* The share of white that a byte of a picture stands for, and the light before the tone curve. */
static double light_of_byte(size_t picture, uint8_t byte)
{
    const double coded = byte * SHARE;
    const double share = picture == 1   ? 2 * coded - 1
                         : picture == 4 ? (coded <= 0.04045 ? coded / 12.92 : pow((coded + 0.055) / 1.055, 2.4))
                                        : coded * coded;
    return picture == 1 || share <= 0.5 ? share : 0.5 - 0.5 * log(2 - 2 * share);
}

static void asking_for_the_default_changes_no_byte(void **state)
{
    static uint8_t expected[PICTURE_BYTES];
    static uint8_t found[PICTURE_BYTES];
    drawn *of = make_drawn(state);
    for (size_t i = 0; i < PICTURES; ++i) {
        const svo_picture_output same = {.samples = i == 1 ? 1 : 4};
        const svo_picture_output none = {.samples = 0};
        ask(of, &none);
        succeed(of, names[i], draw(of, i, expected));
        ask(of, &same);
        succeed(of, names[i], draw(of, i, found));
        assert_memory_equal(found, expected, PICTURE_BYTES);
    }
    release_drawn(of);
}

/* What is met looks the same, whatever is behind it; edges of a transparent picture are partly covered. */
static void backgrounds_are_behind_everything(void **state)
{
    static uint8_t own[PICTURE_BYTES];
    static uint8_t colored[PICTURE_BYTES];
    static uint8_t clear[PICTURE_BYTES];
    static const uint8_t color[4] = {200, 7, 90, 255};
    static const uint8_t nothing[4] = {0, 0, 0, 0};
    const svo_picture_output behind[3] = {
        {.samples = 9},
        {.samples = 9, .background = SVO_BACKGROUND_COLOR, .background_color = {200 / 255.0F, 7 / 255.0F, 90 / 255.0F}},
        {.samples = 9, .background = SVO_BACKGROUND_TRANSPARENT}};
    uint8_t *const shown[3] = {own, colored, clear};
    drawn *of = make_drawn(state);
    for (size_t i = 0; i < PICTURES; ++i) {
        size_t edges = 0;
        for (int k = 0; k < 3; ++k) {
            ask(of, &behind[k]);
            succeed(of, names[i], draw(of, i, shown[k]));
        }
        assert_memory_equal(colored + SKY, color, 4);
        assert_memory_equal(clear + SKY, nothing, 4);
        for (size_t at = 0; at < PICTURE_BYTES; at += 4) {
            assert_int_equal(own[at + 3], 255);
            edges += clear[at + 3] > 0 && clear[at + 3] < 255;
            if (clear[at + 3] == 255) {
                assert_memory_equal(colored + at, own + at, 4);
                assert_memory_equal(clear + at, own + at, 4);
            }
            /* A view of numbers is coded as it is: where a pixel is partly covered, what was met shows as itself, and
               over a color it is that of the picture with this color. */
            for (size_t channel = 0; channel < 3 && i == NORMALS; ++channel) {
                const double share = clear[at + 3] / 255.0;
                const double over = clear[at + channel] * share + color[channel] * (1 - share);
                assert_true(fabs(over - colored[at + channel]) <= 2);
            }
        }
        assert_true(edges > WIDTH);
    }
    release_drawn(of);
}

/* Floats are what the bytes are made of, with one sample; alpha is the share of the samples that met something. */
static void floats_are_the_light_of_bytes(void **state)
{
    static uint8_t bytes[PICTURE_BYTES];
    static float floats[PICTURE_BYTES];
    const svo_picture_output asked[2] = {
        {.samples = 1, .background = SVO_BACKGROUND_TRANSPARENT},
        {.samples = 1, .background = SVO_BACKGROUND_TRANSPARENT, .format = SVO_PIXELS_LINEAR}};
    drawn *of = make_drawn(state);
    for (size_t i = 0; i < PICTURES; ++i) {
        ask(of, &asked[0]);
        succeed(of, names[i], draw(of, i, bytes));
        ask(of, &asked[1]);
        succeed(of, names[i], draw(of, i, floats));
        for (size_t at = 0; at < PICTURE_BYTES; ++at) {
            const double low = light_of_byte(i, (uint8_t)(bytes[at] > 0 ? bytes[at] - 1 : 0));
            const double high = light_of_byte(i, (uint8_t)(bytes[at] < 254 ? bytes[at] + 1 : 254));
            const double value = (double)floats[at];
            if (at % 4 == 3 || bytes[at | 3] == 0) {
                assert_true(fabs(value - bytes[at] * SHARE) <= 1e-6);
            } else if (bytes[at] < 254 && !(value >= low - 1e-6 && value <= high + 1e-6)) {
                fail_msg("%s: channel %zu is %g, not within %g .. %g of byte %u", names[i], at, value, low, high,
                         bytes[at]);
            }
        }
    }
    release_drawn(of);
}

/* Many samples converge, and any number of them is allowed. */
static void more_samples_come_closer(void **state)
{
    static float truth[PICTURE_BYTES];
    static float found[PICTURE_BYTES];
    drawn *of = make_drawn(state);
    for (size_t i = 0; i < PICTURES; ++i) {
        double before = HUGE_VAL;
        svo_picture_output asked = {
            .samples = 121, .background = SVO_BACKGROUND_TRANSPARENT, .format = SVO_PIXELS_LINEAR};
        ask(of, &asked);
        succeed(of, names[i], draw(of, i, truth));
        for (uint32_t samples = 1; samples <= 49; samples *= 7) {
            double sum = 0;
            asked.samples = samples;
            ask(of, &asked);
            succeed(of, names[i], draw(of, i, found));
            for (size_t at = 3; at < PICTURE_BYTES; at += 4) {
                sum += fabs((double)found[at] - (double)truth[at]);
            }
            if (!(sum < 0.6 * before)) {
                fail_msg("%s: %u samples are %g off, fewer %g", names[i], samples, sum, before);
            }
            before = sum;
        }
    }
    release_drawn(of);
}

/* Squares one behind the other that show in part, over a wall that is not there. need: of the tree. */
static void make_panes(const drawn *of, const uint8_t alphas[2], uint32_t need, built *made)
{
    static const float positions[24] = {0, 0, 0.3F, 1, 0, 0.3F, 1, 1, 0.3F, 0, 1, 0.3F,
                                        0, 0, 0.7F, 1, 0, 0.7F, 1, 1, 0.7F, 0, 1, 0.7F};
    static const uint32_t indices[12] = {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7};
    static const uint16_t of_triangles[4] = {0, 0, 1, 1};
    const svo_material materials[2] = {{.rgba = {255, 255, 255, alphas[0]}, .texture_index = SVO_NO_TEXTURE},
                                       {.rgba = {255, 255, 255, alphas[1]}, .texture_index = SVO_NO_TEXTURE}};
    const svo_plan_options options = {.struct_size = sizeof options, .need = need, .edge = 1};
    const svo_mesh mesh = {.struct_size = sizeof mesh,
                           .positions = positions,
                           .vertex_count = 8,
                           .indices = indices,
                           .triangle_count = 4,
                           .triangle_materials = of_triangles,
                           .materials = materials,
                           .material_count = 2};
    fixture_build(&of->opened, &mesh, DEPTH, &options, made);
}

/* The share of a picture's samples that met a pane, and the largest deviation of a pixel's from it. */
static double share_of_panes(const drawn *of, svo_target target, const char *name, float fov, double *deviation)
{
    enum { SIDE = 16 };
    static float pixels[SIDE * SIDE * 4];
    const svo_render_options asked = {
        .struct_size = sizeof asked,
        .width = SIDE,
        .height = SIDE,
        .camera = {.eye = {0.515F, 0.515F, 40}, .target = {0.515F, 0.515F, 0}, .up = {0, 1, 0}, .vertical_fov = fov},
        .output = {.samples = 4, .background = SVO_BACKGROUND_TRANSPARENT, .format = SVO_PIXELS_LINEAR}};
    double share = 0;
    succeed(of, name, svo_render(target, &asked, svo_in_host(pixels), NULL));
    for (size_t i = 0; i < (size_t)SIDE * SIDE; ++i) {
        share += (double)pixels[4 * i + 3] / (SIDE * SIDE);
    }
    *deviation = 0;
    for (size_t i = 0; i < (size_t)SIDE * SIDE; ++i) {
        *deviation = fmax(*deviation, fabs((double)pixels[4 * i + 3] - share));
    }
    return share;
}

/* Of a tree where it is. */
static svo_scene *scene_of_tree(const drawn *of, svo_tree *tree)
{
    static const svo_instance here = {0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    const svo_scene_options options = {
        .struct_size = sizeof options, .trees = &tree, .instances = &here, .tree_count = 1, .instance_count = 1};
    svo_scene *placed = NULL;
    light_succeed(&of->opened, svo_scene_create(of->opened.device, &options, of->opened.queue, &placed));
    return placed;
}

/* A pane takes as many of a pixel's samples as its alpha tells, whatever is drawn; two take theirs by chance. */
static void panes_take_their_share_of_samples(void **state)
{
    static const struct {
        uint8_t alphas[2];
        double share, bound, deviation;
    } cases[] = {{{128, 0}, 0.5, 0, 0},  {{0, 64}, 0.25, 0, 0},       {{255, 128}, 1, 0, 0},
                 {{0, 0}, 0, 0, 0},      {{128, 128}, 0.75, 0.06, 1}, {{1, 254}, 1, 0, 0},
                 {{192, 0}, 0.75, 0, 0}, {{200, 200}, 0.94, 0.06, 1}};
    drawn *of = make_drawn(state);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const svo_compact_options masks = {.struct_size = sizeof masks, .form = SVO_FORM_IMPLIED};
        svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
        svo_compact *compact = NULL;
        built made;
        built voxels;
        make_panes(of, cases[i].alphas, SVO_NEED_ALL, &made);
        make_panes(of, cases[i].alphas, SVO_NEED_COLOR, &voxels);
        svo_light *light = light_of(&of->opened, made.tree, SVO_LIGHT_VOXELS);
        svo_scene *placed = scene_of_tree(of, made.tree);
        light_succeed(&of->opened, svo_light_set_sources(light, &setup, of->opened.queue));
        light_succeed(&of->opened,
                      svo_compact_create(of->opened.device, made.tree, &masks, of->opened.queue, &compact));
        svo_light *voxel_light = light_of(&of->opened, voxels.tree, SVO_LIGHT_VOXELS);
        light_succeed(&of->opened, svo_light_set_sources(voxel_light, &setup, of->opened.queue));
        const svo_target targets[5] = {svo_tree_target(made.tree), svo_compact_target(compact), svo_light_target(light),
                                       svo_scene_target(placed), svo_light_target(voxel_light)};
        for (size_t k = 0; k < 5; ++k) {
            static const char *const kinds[5] = {"panes of a tree", "of a compact tree", "of a light", "of a scene",
                                                 "of a light of voxels"};
            double deviation = 0;
            const double share =
                share_of_panes(of, targets[k], kinds[k], cases[i].bound > 0 ? 0.02F : 0.0002F, &deviation);
            if (!(fabs(share - cases[i].share) <= cases[i].bound && deviation <= cases[i].deviation)) {
                fail_msg("%s, %u and %u: share %g, not %g within %g; pixels deviate by %g", kinds[k],
                         cases[i].alphas[0], cases[i].alphas[1], share, cases[i].share, cases[i].bound, deviation);
            }
        }
        svo_compact_destroy(&compact);
        svo_light_destroy(&light);
        svo_light_destroy(&voxel_light);
        svo_scene_destroy(&placed);
        built_destroy(&made);
        built_destroy(&voxels);
    }
    release_drawn(of);
}

/* Instances of one tree behind each other do not take the same samples, although a ray meets the same cells of them.
   And each tree has its own colors. */
static void instances_take_their_own_share_of_samples(void **state)
{
    static const svo_instance instances[3] = {{1, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}},
                                              {1, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -0.25F}},
                                              {0, {1, 0, 0, 9, 0, 1, 0, 0, 0, 0, 1, 0}}};
    static const uint8_t alphas[2][2] = {{255, 254}, {128, 0}};
    drawn *of = make_drawn(state);
    svo_tree *trees[2];
    built made[2];
    for (size_t i = 0; i < 2; ++i) {
        make_panes(of, alphas[i], SVO_NEED_ALL, &made[i]);
        trees[i] = made[i].tree;
    }
    const svo_scene_options options = {
        .struct_size = sizeof options, .trees = trees, .instances = instances, .tree_count = 2, .instance_count = 3};
    svo_scene *placed = NULL;
    double deviation = 0;
    light_succeed(&of->opened, svo_scene_create(of->opened.device, &options, of->opened.queue, &placed));
    const double share = share_of_panes(of, svo_scene_target(placed), "two instances", 0.02F, &deviation);
    if (!(fabs(share - 0.75) <= 0.06)) {
        fail_msg("share %g, not 0.75", share);
    }
    svo_scene_destroy(&placed);
    built_destroy(&made[0]);
    built_destroy(&made[1]);
    release_drawn(of);
}

/* What light comes through a pane: from an alpha of a half on it has a shadow. The floor below it is drawn alone. */
static void panes_of_scenes_shade_from_a_half_on(void **state)
{
    static const struct {
        uint8_t alpha;
        bool shades;
    } cases[] = {{0, false}, {64, false}, {127, false}, {128, true}, {255, true}};
    float light[sizeof cases / sizeof cases[0]];
    drawn *of = make_drawn(state);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const svo_scene_light sun = {.direction = {0, 0, 1}, .shadows = 1, .color = {1, 1, 1}};
        const uint8_t alphas[2] = {255, cases[i].alpha};
        static float pixels[4 * 4];
        built made;
        make_panes(of, alphas, SVO_NEED_ALL, &made);
        svo_scene *placed = scene_of_tree(of, made.tree);
        const svo_render_options asked = {.struct_size = sizeof asked,
                                          .width = 2,
                                          .height = 2,
                                          .camera = {.eye = {0.515F, 0.515F, 0.5F},
                                                     .target = {0.515F, 0.515F, 0},
                                                     .up = {0, 1, 0},
                                                     .vertical_fov = 1},
                                          .lights = &sun,
                                          .light_count = 1,
                                          .occlusion_range = 0.01F,
                                          .output = {.samples = 1, .format = SVO_PIXELS_LINEAR}};
        succeed(of, "a floor", svo_render(svo_scene_target(placed), &asked, svo_in_host(pixels), NULL));
        light[i] = pixels[0];
        if (cases[i].shades != (light[i] < light[0] - 0.5F)) {
            fail_msg("alpha %u: the floor shows %g, without a pane %g", cases[i].alpha, (double)light[i],
                     (double)light[0]);
        }
        svo_scene_destroy(&placed);
        built_destroy(&made);
    }
    release_drawn(of);
}

/* The number that a view shows: how far away what it meets is, in world units. */
static void depths_are_distances(void **state)
{
    static float depths[PICTURE_BYTES];
    static float normals[PICTURE_BYTES];
    drawn *of = make_drawn(state);
    const svo_picture_output linear = {.format = SVO_PIXELS_LINEAR};
    const svo_camera *camera = &of->asked[NORMALS].camera;
    double nearest = HUGE_VAL;
    double away = 0;
    ask(of, &linear);
    succeed(of, names[NORMALS], draw(of, NORMALS, normals));
    of->asked[NORMALS].view = SVO_VIEW_DEPTH;
    succeed(of, names[NORMALS], draw(of, NORMALS, depths));
    for (int axis = 0; axis < 3; ++axis) {
        away = hypot(away, (double)camera->eye[axis] - (double)camera->target[axis]);
    }
    for (size_t at = 0; at < PICTURE_BYTES; at += 4) {
        assert_float_equal(depths[at + 3], normals[at + 3], 0);
        if (depths[at + 3] > 0) {
            const double length = hypot(hypot((double)normals[at], (double)normals[at + 1]), (double)normals[at + 2]);
            assert_float_equal(length, 1, 1e-5);
            nearest = fmin(nearest, (double)depths[at]);
        } else {
            assert_true(depths[at] == 0);
        }
    }
    if (!(nearest > 0.3 * away && nearest < away)) {
        fail_msg("the nearest hit is at %g, the target at %g", nearest, away);
    }
    release_drawn(of);
}

static void wrong_outputs_are_refused(void **state)
{
    static uint8_t rgba[4 * PICTURE_BYTES];
    static const struct {
        svo_picture_output output;
        const char *words;
    } wrong[] = {{{.format = (svo_pixel_format)2}, "output.format 2 is not in 0 .. 1"},
                 {{.background = (svo_background)3}, "output.background 3 is not in 0 .. 2"},
                 {{.background_color = {0, 1.5F, 0}}, "output.background_color[1] 1.5 is not in 0 .. 1"},
                 {{.background_color = {0, 0, -1}}, "output.background_color[2] -1 is not in 0 .. 1"},
                 {{.background_color = {(float)NAN, 0, 0}}, "output.background_color[0]"},
                 {{.samples = 4097}, "output.samples 4097 is above 4096"}};
    drawn *of = make_drawn(state);
    const svo_picture_output floats = {.format = SVO_PIXELS_LINEAR};
    cl_mem small = make_pixels(of, CL_MEM_WRITE_ONLY, 4 * PICTURE_BYTES - 1);
    const place to = {.pixels = small, .submit = {.queue = of->opened.queue}};
    for (size_t i = 0; i < PICTURES; ++i) {
        for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; ++k) {
            ask(of, &wrong[k].output);
            assert_int_equal(draw(of, i, rgba), SVO_INVALID_ARGUMENT);
            assert_non_null(strstr(svo_device_message(of->opened.device), wrong[k].words));
        }
        ask(of, &floats);
        assert_int_equal(enqueue(of, i, &to), SVO_INVALID_ARGUMENT);
        assert_non_null(strstr(svo_device_message(of->opened.device), "pixels"));
    }
    clReleaseMemObject(small);
    release_drawn(of);
}

/* ---- events ---- */

/* The call returns while its picture cannot begin; pictures that are enqueued one after the other need no host. */
static void pictures_wait_for_events_and_not_the_host(void **state)
{
    static uint8_t expected[PICTURE_BYTES];
    static uint8_t found[BYTES];
    drawn *of = make_drawn(state);
    for (size_t i = 0; i < PICTURES; ++i) {
        cl_event done[2] = {NULL, NULL};
        cl_event gate = clCreateUserEvent(info_of_device(of->opened.device).context, NULL);
        cl_mem pixels[2] = {make_pixels(of, CL_MEM_WRITE_ONLY, BYTES), make_pixels(of, CL_MEM_WRITE_ONLY, BYTES)};
        const place first = {pixels[0], {of->opened.queue, 1, &gate, &done[0]}};
        const place second = {pixels[1], {of->opened.queue, 1, &done[0], &done[1]}};
        succeed(of, names[i], draw(of, i, expected));
        succeed(of, names[i], enqueue(of, i, &first));
        succeed(of, names[i], enqueue(of, i, &second));
        read_pixels(of, pixels[0], BYTES, found);
        assert_untouched(names[i], found, BYTES);
        assert_int_equal(clSetUserEventStatus(gate, CL_COMPLETE), CL_SUCCESS);
        assert_int_equal(clWaitForEvents(1, &done[1]), CL_SUCCESS);
        for (int k = 0; k < 2; ++k) {
            read_pixels(of, pixels[k], BYTES, found);
            assert_memory_equal(found, expected, PICTURE_BYTES);
            clReleaseMemObject(pixels[k]);
            clReleaseEvent(done[k]);
        }
        clReleaseEvent(gate);
    }
    release_drawn(of);
}

/* ---- refusals ---- */

static void expect_refused(const drawn *of, size_t picture, const place *to, const char *words)
{
    char expected[256];
    (void)snprintf(expected, sizeof expected, "svo_render: %s", words);
    assert_int_equal(enqueue(of, picture, to), SVO_INVALID_ARGUMENT);
    assert_string_equal(svo_device_message(of->opened.device), expected);
}

/* The same device in another context. */
static void refuse_foreign_objects(const drawn *of, size_t picture, cl_mem pixels)
{
    const cl_device_id device = info_of_device(of->opened.device).device;
    cl_context context = clCreateContext(NULL, 1, &device, NULL, NULL, NULL);
    cl_command_queue queue = clCreateCommandQueue(context, device, 0, NULL);
    cl_mem memory = clCreateBuffer(context, CL_MEM_READ_WRITE, BYTES, NULL, NULL);
    cl_event event = clCreateUserEvent(context, NULL);
    cl_event done = NULL;
    assert_true(context != NULL && queue != NULL && memory != NULL && event != NULL);
    expect_refused(of, picture, &(place){memory, {of->opened.queue, 0, NULL, &done}}, "pixels is of another context");
    expect_refused(of, picture, &(place){pixels, {queue, 0, NULL, &done}},
                   "queue is of another context than the device");
    expect_refused(of, picture, &(place){pixels, {of->opened.queue, 1, &event, &done}},
                   "wait holds an event of another context");
    assert_null(done);
    clReleaseEvent(event);
    clReleaseMemObject(memory);
    clReleaseCommandQueue(queue);
    clReleaseContext(context);
}

static void what_cannot_take_a_picture_is_refused(void **state)
{
    static uint8_t found[BYTES];
    drawn *of = make_drawn(state);
    const cl_command_queue queue = of->opened.queue;
    const cl_image_format format = {CL_RGBA, CL_UNSIGNED_INT8};
    const cl_image_desc shape = {.image_type = CL_MEM_OBJECT_IMAGE2D, .image_width = 64, .image_height = 64};
    cl_mem pixels = make_pixels(of, CL_MEM_READ_WRITE, BYTES);
    cl_mem fixed = make_pixels(of, CL_MEM_READ_ONLY, BYTES);
    cl_mem small = make_pixels(of, CL_MEM_READ_WRITE, PICTURE_BYTES - 1);
    cl_mem image = clCreateImage(info_of_device(of->opened.device).context, CL_MEM_READ_WRITE, &format, &shape, NULL,
                                 NULL); /* NULL without images */
    for (size_t i = 0; i < PICTURES; ++i) {
        cl_event done = NULL;
        expect_refused(of, i, &(place){NULL, {queue, 0, NULL, &done}}, "pixels is NULL");
        expect_refused(of, i, &(place){small, {queue, 0, NULL, &done}}, "pixels holds 6067 bytes, below 6068");
        expect_refused(of, i, &(place){fixed, {queue, 0, NULL, &done}},
                       "pixels is of CL_MEM_READ_ONLY, and kernels write it");
        expect_refused(of, i, &(place){pixels, {queue, 1, NULL, &done}}, "num_wait and wait disagree");
        if (image != NULL) {
            expect_refused(of, i, &(place){image, {queue, 0, NULL, &done}}, "pixels is no buffer");
        }
        assert_null(done);
        refuse_foreign_objects(of, i, pixels);
    }
    assert_int_equal(clFinish(queue), CL_SUCCESS);
    read_pixels(of, pixels, BYTES, found);
    assert_untouched("refused", found, BYTES);
    clReleaseMemObject(pixels);
    clReleaseMemObject(fixed);
    clReleaseMemObject(small);
    if (image != NULL) {
        clReleaseMemObject(image);
    }
    release_drawn(of);
}

/* Fields and views that others have, and what is missing. */
static void wrong_options_are_refused(void **state)
{
    static const char *const kinds[PICTURES] = {"tree", "tree", "compact tree", "scene", "light"};
    static const svo_scene_light lights[1] = {{.direction = {0, 0, 1}}};
    drawn *of = make_drawn(state);
    cl_mem pixels = make_pixels(of, CL_MEM_READ_WRITE, BYTES);
    const place to = {.pixels = pixels, .submit = {.queue = of->opened.queue}};
    for (size_t i = 0; i < PICTURES; ++i) {
        const svo_render_options good = of->asked[i];
        char words[160];
#define REFUSED(field, value)                                                                            \
    do {                                                                                                 \
        of->asked[i].field = value;                                                                      \
        (void)snprintf(words, sizeof words, "options." #field " is not 0, and a %s has none", kinds[i]); \
        expect_refused(of, i, &to, words);                                                               \
        of->asked[i] = good;                                                                             \
    } while (0)
        if (i != SCENE) {
            REFUSED(light_count, 1);
            REFUSED(lights, lights);
            REFUSED(occlusion_range, 1);
        }
        if (i != LIGHT) {
            REFUSED(gather, &of->gather);
            REFUSED(exposure, 1);
            REFUSED(first_row, SVO_LIGHT_BAND_ROWS);
            REFUSED(row_count, SVO_LIGHT_BAND_ROWS);
        }
#undef REFUSED
        of->asked[i].width = 0;
        expect_refused(of, i, &to, "0 x 41 pixels are not within 1 .. 16384");
        assert_int_equal(svo_render(of->targets[i], NULL, svo_in_buffer(pixels), NULL), SVO_INVALID_ARGUMENT);
        assert_string_equal(svo_device_message(of->opened.device), "svo_render: options is NULL");
        of->asked[i] = good;
        of->targets[i].of = NULL;
        assert_int_equal(enqueue(of, i, &to), SVO_INVALID_ARGUMENT);
    }
    assert_int_equal(svo_render((svo_target){NULL, NULL}, &of->asked[0], svo_in_buffer(pixels), NULL),
                     SVO_INVALID_ARGUMENT);
    clReleaseMemObject(pixels);
    release_drawn(of);
}

static void targets_have_their_own_views(void **state)
{
    static const struct {
        int picture, least, most; /* views that there are, besides SVO_VIEW_SHADED */
        const char *words;
    } kinds[] = {
        {SHADED, SVO_VIEW_NORMAL, SVO_VIEW_TRIANGLES,
         "tree, which has SVO_VIEW_SHADED, NORMAL, DEPTH, STEPS, LEVEL and TRIANGLES"},
        {COMPACT, SVO_VIEW_NORMAL, SVO_VIEW_LEVEL,
         "compact tree, which has SVO_VIEW_SHADED, NORMAL, DEPTH, STEPS and LEVEL"},
        {SCENE, SVO_VIEW_SHADED, SVO_VIEW_SHADED, "scene, which has SVO_VIEW_SHADED"},
        {LIGHT, SVO_VIEW_AO, SVO_VIEW_SPECULAR, "light, which has SVO_VIEW_SHADED, AO, DIRECT, INDIRECT and SPECULAR"}};
    static uint8_t rgba[PICTURE_BYTES];
    drawn *of = make_drawn(state);
    for (size_t k = 0; k < sizeof kinds / sizeof kinds[0]; ++k) {
        for (int view = 0; view <= (int)SVO_VIEW_SPECULAR + 1; ++view) {
            char expected[160];
            (void)snprintf(expected, sizeof expected, "svo_render: options.view %d is none of a %s", view,
                           kinds[k].words);
            of->asked[kinds[k].picture].view = (svo_render_view)view;
            const svo_status status = draw(of, (size_t)kinds[k].picture, rgba);
            if (view == 0 || (view >= kinds[k].least && view <= kinds[k].most)) {
                succeed(of, kinds[k].words, status);
            } else {
                assert_int_equal(status, SVO_INVALID_ARGUMENT);
                assert_string_equal(svo_device_message(of->opened.device), expected);
            }
        }
    }
    release_drawn(of);
}

/* What a room leaves out of its class. A light frames its tree. */
static void what_a_target_does_not_have_is_refused(void **state)
{
    drawn *of = make_drawn(state);
    svo_camera camera = {.vertical_fov = 0};
    assert_int_equal(svo_kernel_set_arguments(of->targets[SCENE], NULL, 0), SVO_UNSUPPORTED);
    assert_string_equal(svo_device_message(of->opened.device), "svo_kernel_set_arguments: not of a scene");
    assert_null(svo_kernel_source(of->targets[SCENE]));
    assert_null(svo_kernel_options(of->targets[SCENE]));
    assert_null(svo_kernel_options(svo_compact_target(NULL)));
    assert_ptr_equal(svo_kernel_source(svo_compact_target(NULL)), svo_kernel_source(of->targets[SHADED]));
    assert_int_equal(svo_camera_fit(svo_tree_target(NULL), 1, &camera), SVO_INVALID_ARGUMENT);
    assert_float_equal(camera.vertical_fov, 0, 0);
    assert_int_equal(svo_camera_fit(of->targets[LIGHT], (float)WIDTH / HEIGHT, &camera), SVO_OK);
    assert_memory_equal(&camera, &of->asked[SHADED].camera, sizeof camera);
    release_drawn(of);
}

TEST_GROUP(render_buffers)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(buffers_have_the_bytes_of_host_pictures),
        cmocka_unit_test(sub_buffers_put_pictures_elsewhere),
        cmocka_unit_test(bands_of_light_go_to_their_place),
        cmocka_unit_test(asking_for_the_default_changes_no_byte),
        cmocka_unit_test(backgrounds_are_behind_everything),
        cmocka_unit_test(floats_are_the_light_of_bytes),
        cmocka_unit_test(more_samples_come_closer),
        cmocka_unit_test(panes_take_their_share_of_samples),
        cmocka_unit_test(instances_take_their_own_share_of_samples),
        cmocka_unit_test(panes_of_scenes_shade_from_a_half_on),
        cmocka_unit_test(depths_are_distances),
        cmocka_unit_test(wrong_outputs_are_refused),
        cmocka_unit_test(pictures_wait_for_events_and_not_the_host),
        cmocka_unit_test(what_cannot_take_a_picture_is_refused),
        cmocka_unit_test(wrong_options_are_refused),
        cmocka_unit_test(targets_have_their_own_views),
        cmocka_unit_test(what_a_target_does_not_have_is_refused),
    };
    return cmocka_run_group_tests_name("render_buffers", tests, fixture_group_setup, fixture_group_teardown);
}
