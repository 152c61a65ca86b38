/* SPDX-License-Identifier: MIT */
/*
 * Pictures in buffers of the caller's: of trees, compact trees, scenes and lights. Their bytes are those of the
 * functions for host arrays; they wait for the caller's events and nothing waits for them; what cannot take a picture
 * is refused and stays as it is. And what of each pixel is written: bytes or floats, samples, backgrounds.
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

typedef struct drawn {
    fixture opened;
    built made;
    svo_compact *compact;
    svo_scene *scene;
    svo_light *light;
    svo_render_options shaded, normals;
    svo_scene_render_options placed;
    svo_light_picture lit;
} drawn;

/* Where a picture goes, and when. */
typedef struct target {
    cl_mem pixels;
    cl_command_queue queue;
    cl_uint num_wait;
    const cl_event *wait;
    cl_event *event;
} target;

static svo_status enqueue_shaded(const drawn *of, const target *to)
{
    return svo_tree_render_enqueue(of->opened.device, of->made.tree, &of->shaded, to->pixels, to->queue, to->num_wait,
                                   to->wait, to->event);
}

static svo_status enqueue_normals(const drawn *of, const target *to)
{
    return svo_tree_render_enqueue(of->opened.device, of->made.tree, &of->normals, to->pixels, to->queue, to->num_wait,
                                   to->wait, to->event);
}

static svo_status enqueue_compact(const drawn *of, const target *to)
{
    return svo_compact_render_enqueue(of->compact, &of->shaded, to->pixels, to->queue, to->num_wait, to->wait,
                                      to->event);
}

static svo_status enqueue_scene(const drawn *of, const target *to)
{
    return svo_scene_render_enqueue(of->scene, &of->placed, to->pixels, to->queue, to->num_wait, to->wait, to->event);
}

static svo_status enqueue_light(const drawn *of, const target *to)
{
    return svo_light_render_enqueue(of->light, &of->lit, to->pixels, to->queue, to->num_wait, to->wait, to->event);
}

static svo_status draw_shaded(const drawn *of, uint8_t *rgba)
{
    return svo_tree_render(of->opened.device, of->made.tree, &of->shaded, NULL, rgba);
}

static svo_status draw_normals(const drawn *of, uint8_t *rgba)
{
    return svo_tree_render(of->opened.device, of->made.tree, &of->normals, NULL, rgba);
}

static svo_status draw_compact(const drawn *of, uint8_t *rgba)
{
    return svo_compact_render(of->compact, &of->shaded, NULL, rgba);
}

static svo_status draw_scene(const drawn *of, uint8_t *rgba)
{
    return svo_scene_render(of->scene, &of->placed, NULL, rgba);
}

static svo_status draw_light(const drawn *of, uint8_t *rgba)
{
    return svo_light_render(of->light, &of->lit, NULL, rgba);
}

static const struct picture {
    const char *function; /* as messages begin */
    svo_status (*enqueue)(const drawn *of, const target *to);
    svo_status (*draw)(const drawn *of, uint8_t *rgba); /* for the host */
} pictures[] = {
    {"svo_tree_render_enqueue", enqueue_shaded, draw_shaded},
    {"svo_tree_render_enqueue", enqueue_normals, draw_normals},
    {"svo_compact_render_enqueue", enqueue_compact, draw_compact},
    {"svo_scene_render_enqueue", enqueue_scene, draw_scene},
    {"svo_light_render_enqueue", enqueue_light, draw_light},
};

#define PICTURES (sizeof pictures / sizeof pictures[0])

static void make_light(drawn *of)
{
    const svo_light_source lamp = {.kind = SVO_SOURCE_POINT, .position = {0.5F, 0.5F, 2.0F}, .value = {9, 9, 9}};
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    setup.sources = &lamp;
    setup.source_count = 1;
    setup.sky[0] = setup.sky[1] = setup.sky[2] = 0.5F;
    of->light = light_of(&of->opened, of->made.tree, SVO_LIGHT_VOXELS);
    light_succeed(&of->opened, svo_light_set_sources(of->light, &setup, of->opened.queue));
    of->lit = (svo_light_picture)SVO_LIGHT_PICTURE_INIT;
    of->lit.width = WIDTH;
    of->lit.height = HEIGHT;
    of->lit.camera = of->shaded.camera;
    of->lit.gather.cones = 5;
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
    of->shaded = (svo_render_options){.struct_size = sizeof of->shaded, .width = WIDTH, .height = HEIGHT};
    svo_camera_frame(of->made.tree, (float)WIDTH / HEIGHT, &of->shaded.camera);
    of->normals = of->shaded;
    of->normals.view = SVO_VIEW_NORMAL;
    of->placed = (svo_scene_render_options){.struct_size = sizeof of->placed, .width = WIDTH, .height = HEIGHT};
    of->placed.camera = of->shaded.camera;
    make_light(of);
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

static void compare_with_host(const drawn *of, const struct picture *shown, cl_command_queue queue)
{
    static uint8_t expected[PICTURE_BYTES];
    static uint8_t found[BYTES];
    cl_event done = NULL;
    cl_mem pixels = make_pixels(of, CL_MEM_WRITE_ONLY, BYTES);
    const target to = {.pixels = pixels, .queue = queue, .event = &done};
    memset(expected, UNTOUCHED, sizeof expected);
    succeed(of, shown->function, shown->draw(of, expected));
    succeed(of, shown->function, shown->enqueue(of, &to));
    assert_non_null(done);
    assert_int_equal(clWaitForEvents(1, &done), CL_SUCCESS);
    clReleaseEvent(done);
    read_pixels(of, pixels, BYTES, found);
    assert_memory_equal(found, expected, PICTURE_BYTES);
    assert_untouched(shown->function, found + PICTURE_BYTES, GUARD_BYTES);
    clReleaseMemObject(pixels);
}

static void buffers_have_the_bytes_of_host_pictures(void **state)
{
    drawn *of = make_drawn(state);
    cl_command_queue any_order =
        clCreateCommandQueue(info_of_device(of->opened.device).context, info_of_device(of->opened.device).device,
                             CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, NULL);
    for (size_t i = 0; i < PICTURES; ++i) {
        compare_with_host(of, &pictures[i], of->opened.queue);
        if (any_order != NULL) {
            compare_with_host(of, &pictures[i], any_order);
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
        const target to = {.pixels = part, .queue = of->opened.queue};
        succeed(of, pictures[i].function, pictures[i].draw(of, expected));
        succeed(of, pictures[i].function, pictures[i].enqueue(of, &to));
        assert_int_equal(clFinish(of->opened.queue), CL_SUCCESS);
        clReleaseMemObject(part);
        read_pixels(of, pixels, BYTES, found);
        assert_memory_equal(found + GUARD_BYTES, expected, PICTURE_BYTES);
        assert_untouched(pictures[i].function, found, GUARD_BYTES);
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
    const target to = {.pixels = pixels, .queue = of->opened.queue};
    succeed(of, "svo_light_render", draw_light(of, expected));
    of->lit.first_row = of->lit.row_count = SVO_LIGHT_BAND_ROWS;
    succeed(of, "svo_light_render_enqueue", enqueue_light(of, &to));
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
    of->shaded.output = of->normals.output = of->placed.output = of->lit.output = *output;
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
        succeed(of, pictures[i].function, pictures[i].draw(of, expected));
        ask(of, &same);
        succeed(of, pictures[i].function, pictures[i].draw(of, found));
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
            succeed(of, pictures[i].function, pictures[i].draw(of, shown[k]));
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
        succeed(of, pictures[i].function, pictures[i].draw(of, bytes));
        ask(of, &asked[1]);
        succeed(of, pictures[i].function, pictures[i].draw(of, (uint8_t *)floats));
        for (size_t at = 0; at < PICTURE_BYTES; ++at) {
            const double low = light_of_byte(i, (uint8_t)(bytes[at] > 0 ? bytes[at] - 1 : 0));
            const double high = light_of_byte(i, (uint8_t)(bytes[at] < 254 ? bytes[at] + 1 : 254));
            const double value = (double)floats[at];
            if (at % 4 == 3 || bytes[at | 3] == 0) {
                assert_true(fabs(value - bytes[at] * SHARE) <= 1e-6);
            } else if (bytes[at] < 254 && !(value >= low - 1e-6 && value <= high + 1e-6)) {
                fail_msg("%s: channel %zu is %g, not within %g .. %g of byte %u", pictures[i].function, at, value, low,
                         high, bytes[at]);
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
        succeed(of, pictures[i].function, pictures[i].draw(of, (uint8_t *)truth));
        for (uint32_t samples = 1; samples <= 49; samples *= 7) {
            double sum = 0;
            asked.samples = samples;
            ask(of, &asked);
            succeed(of, pictures[i].function, pictures[i].draw(of, (uint8_t *)found));
            for (size_t at = 3; at < PICTURE_BYTES; at += 4) {
                sum += fabs((double)found[at] - (double)truth[at]);
            }
            if (!(sum < 0.6 * before)) {
                fail_msg("%s: %u samples are %g off, fewer %g", pictures[i].function, samples, sum, before);
            }
            before = sum;
        }
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
    const svo_camera *camera = &of->normals.camera;
    double nearest = HUGE_VAL;
    double away = 0;
    ask(of, &linear);
    succeed(of, "svo_tree_render", draw_normals(of, (uint8_t *)normals));
    of->normals.view = SVO_VIEW_DEPTH;
    succeed(of, "svo_tree_render", draw_normals(of, (uint8_t *)depths));
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
    const target to = {.pixels = small, .queue = of->opened.queue};
    for (size_t i = 0; i < PICTURES; ++i) {
        for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; ++k) {
            ask(of, &wrong[k].output);
            assert_int_equal(pictures[i].draw(of, rgba), SVO_INVALID_ARGUMENT);
            assert_non_null(strstr(svo_device_message(of->opened.device), wrong[k].words));
        }
        ask(of, &floats);
        assert_int_equal(pictures[i].enqueue(of, &to), SVO_INVALID_ARGUMENT);
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
        const target first = {pixels[0], of->opened.queue, 1, &gate, &done[0]};
        const target second = {pixels[1], of->opened.queue, 1, &done[0], &done[1]};
        succeed(of, pictures[i].function, pictures[i].draw(of, expected));
        succeed(of, pictures[i].function, pictures[i].enqueue(of, &first));
        succeed(of, pictures[i].function, pictures[i].enqueue(of, &second));
        read_pixels(of, pixels[0], BYTES, found);
        assert_untouched(pictures[i].function, found, BYTES);
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

static void expect_refused(const drawn *of, const struct picture *shown, const target *to, const char *words)
{
    char expected[256];
    (void)snprintf(expected, sizeof expected, "%s: %s", shown->function, words);
    assert_int_equal(shown->enqueue(of, to), SVO_INVALID_ARGUMENT);
    assert_string_equal(svo_device_message(of->opened.device), expected);
}

/* The same device in another context. */
static void refuse_foreign_objects(const drawn *of, const struct picture *shown, cl_mem pixels)
{
    const cl_device_id device = info_of_device(of->opened.device).device;
    cl_context context = clCreateContext(NULL, 1, &device, NULL, NULL, NULL);
    cl_command_queue queue = clCreateCommandQueue(context, device, 0, NULL);
    cl_mem memory = clCreateBuffer(context, CL_MEM_READ_WRITE, BYTES, NULL, NULL);
    cl_event event = clCreateUserEvent(context, NULL);
    cl_event done = NULL;
    assert_true(context != NULL && queue != NULL && memory != NULL && event != NULL);
    expect_refused(of, shown, &(target){memory, of->opened.queue, 0, NULL, &done}, "pixels is of another context");
    expect_refused(of, shown, &(target){pixels, queue, 0, NULL, &done}, "queue is of another context than the device");
    expect_refused(of, shown, &(target){pixels, of->opened.queue, 1, &event, &done},
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
        const struct picture *shown = &pictures[i];
        cl_event done = NULL;
        expect_refused(of, shown, &(target){NULL, queue, 0, NULL, &done}, "pixels is NULL");
        expect_refused(of, shown, &(target){small, queue, 0, NULL, &done}, "pixels holds 6067 bytes, below 6068");
        expect_refused(of, shown, &(target){fixed, queue, 0, NULL, &done},
                       "pixels is of CL_MEM_READ_ONLY, and kernels write it");
        expect_refused(of, shown, &(target){pixels, queue, 1, NULL, &done}, "num_wait and wait disagree");
        if (image != NULL) {
            expect_refused(of, shown, &(target){image, queue, 0, NULL, &done}, "pixels is no buffer");
        }
        assert_null(done);
        refuse_foreign_objects(of, shown, pixels);
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

/* What the functions for host arrays refuse, under the name of the function that was called. */
static void wrong_options_are_refused_by_name(void **state)
{
    drawn *of = make_drawn(state);
    cl_mem pixels = make_pixels(of, CL_MEM_READ_WRITE, BYTES);
    const target to = {.pixels = pixels, .queue = of->opened.queue};
    of->shaded.width = of->normals.width = of->placed.width = of->lit.width = 0;
    for (size_t i = 0; i < PICTURES; ++i) {
        expect_refused(of, &pictures[i], &to, "0 x 41 pixels are not within 1 .. 16384");
    }
    assert_int_equal(svo_tree_render_enqueue(of->opened.device, NULL, &of->shaded, pixels, to.queue, 0, NULL, NULL),
                     SVO_INVALID_ARGUMENT);
    assert_string_equal(svo_device_message(of->opened.device), "svo_tree_render_enqueue: tree is NULL");
    assert_int_equal(svo_compact_render_enqueue(of->compact, NULL, pixels, to.queue, 0, NULL, NULL),
                     SVO_INVALID_ARGUMENT);
    assert_string_equal(svo_device_message(of->opened.device), "svo_compact_render_enqueue: options is NULL");
    assert_int_equal(svo_tree_render_enqueue(NULL, of->made.tree, &of->shaded, pixels, to.queue, 0, NULL, NULL),
                     SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_compact_render_enqueue(NULL, &of->shaded, pixels, to.queue, 0, NULL, NULL),
                     SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_scene_render_enqueue(NULL, &of->placed, pixels, to.queue, 0, NULL, NULL),
                     SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_light_render_enqueue(NULL, &of->lit, pixels, to.queue, 0, NULL, NULL), SVO_INVALID_ARGUMENT);
    clReleaseMemObject(pixels);
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
        cmocka_unit_test(depths_are_distances),
        cmocka_unit_test(wrong_outputs_are_refused),
        cmocka_unit_test(pictures_wait_for_events_and_not_the_host),
        cmocka_unit_test(what_cannot_take_a_picture_is_refused),
        cmocka_unit_test(wrong_options_are_refused_by_name),
    };
    return cmocka_run_group_tests_name("render_buffers", tests, fixture_group_setup, fixture_group_teardown);
}
