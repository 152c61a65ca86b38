/* SPDX-License-Identifier: MIT */
/*
 * What calls with an svo_submit have in common: NULL for the queue is the device's own; without an svo_submit, and with
 * arrays in host memory, they wait, and else for nothing; such arrays lie anywhere; commands wait for the caller's
 * events; memory that kernels write must not be CL_MEM_READ_ONLY; a call of OpenCL that fails is named; targets refuse
 * what they have not, and trees that are on no device refuse everything.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <string.h>

#include "core/compact.h"
#include "core/device.h"
#include "core/tree.h"
#include "scenes.h"
#include "support/counting.h"
#include "support/fixture.h"
#include "support/info_of.h"
#include "support/suite.h"
#include "svocl/light.h"
#include "svocl/moving.h"
#include "svocl/probes.h"
#include "svocl/scene.h"
#include "svocl/solid.h"

#define DEPTH        3
#define COUNT        8 /* records of a batch */
#define RECORD_BYTES 64 /* at least as many as any record has */
#define WIDTH        8
#define PIXELS_BYTES ((size_t)WIDTH * WIDTH * 4)
#define NEEDS        ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_RAYS)

/* Everything that batches and pictures can be asked of. */
typedef struct subjects {
    fixture opened;
    svo_tree *tree;
    svo_compact *compact;
    svo_scene *scene;
    svo_light *light;
    svo_probes *probes; /* with diffuse light */
} subjects;

static void succeed(const subjects *of, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), svo_device_message(of->opened.device));
    }
}

static subjects make_subjects(void **state)
{
    subjects of = {.opened = fixture_cl_of_group(state)};
    svo_device *device = of.opened.device;
    const cl_command_queue queue = of.opened.queue;
    struct scene *cube = fixture_scene("cube");
    const svo_plan_options options = {.struct_size = sizeof options, .need = NEEDS};
    const svo_compact_options descriptor = {.struct_size = sizeof descriptor};
    const svo_instance instance = {.transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    svo_probe_options probes = SVO_PROBE_OPTIONS_INIT;
    built made;
    fixture_build(&of.opened, scene_mesh(cube), DEPTH, &options, &made);
    scene_destroy(&cube);
    of.tree = made.tree;
    succeed(&of, svo_compact_create(device, of.tree, &descriptor, queue, &of.compact));
    const svo_scene_options placed = {.struct_size = sizeof placed,
                                      .trees = &of.tree,
                                      .instances = &instance,
                                      .tree_count = 1,
                                      .instance_count = 1,
                                      .need = NEEDS};
    succeed(&of, svo_scene_create(device, &placed, queue, &of.scene));
    succeed(&of, svo_light_create(of.tree, NULL, queue, &of.light));
    probes.counts[0] = probes.counts[1] = probes.counts[2] = 1;
    probes.resolution = SVO_PROBES_RESOLUTION_MIN;
    probes.field_size = 4;
    probes.keep_places = 1;
    probes.cones = 1;
    probes.diffuse = 1;
    probes.light = of.light;
    probes.tree = of.tree;
    succeed(&of, svo_probes_create(&probes, queue, &of.probes));
    return of;
}

static void release_subjects(subjects *of)
{
    svo_probes_destroy(&of->probes);
    svo_light_destroy(&of->light);
    svo_scene_destroy(&of->scene);
    svo_compact_destroy(&of->compact);
    svo_tree_destroy(&of->tree);
}

/* ---- batches ---- */

typedef svo_status submit_batch(subjects *of, svo_array input, svo_array output, size_t count,
                                const svo_submit *submit);

static svo_status trace(subjects *of, svo_array input, svo_array output, size_t count, const svo_submit *submit)
{
    return svo_trace_triangles(svo_tree_target(of->tree), input, output, count, SVO_TRACE_CLOSEST, submit);
}

static svo_status nearest(subjects *of, svo_array input, svo_array output, size_t count, const svo_submit *submit)
{
    return svo_tree_nearest(of->tree, input, output, count, submit);
}

static svo_status trace_voxels(subjects *of, svo_array input, svo_array output, size_t count, const svo_submit *submit)
{
    return svo_trace_voxels(svo_tree_target(of->tree), input, output, count, 0, 0, submit);
}

static svo_status trace_compact(subjects *of, svo_array input, svo_array output, size_t count, const svo_submit *submit)
{
    return svo_trace_voxels(svo_compact_target(of->compact), input, output, count, 0, 0, submit);
}

static svo_status trace_scene(subjects *of, svo_array input, svo_array output, size_t count, const svo_submit *submit)
{
    return svo_trace_voxels(svo_scene_target(of->scene), input, output, count, 0, SVO_SCENE_CLOSEST, submit);
}

static svo_status trace_triangles(subjects *of, svo_array input, svo_array output, size_t count,
                                  const svo_submit *submit)
{
    return svo_trace_triangles(svo_scene_target(of->scene), input, output, count, SVO_SCENE_CLOSEST, submit);
}

static svo_status gather(subjects *of, svo_array input, svo_array output, size_t count, const svo_submit *submit)
{
    return svo_gather(of->light, input, output, count, NULL, submit);
}

static svo_status trace_probes(subjects *of, svo_array input, svo_array output, size_t count, const svo_submit *submit)
{
    return svo_probes_trace(of->probes, input, output, count, NULL, submit);
}

static svo_status irradiance(subjects *of, svo_array input, svo_array output, size_t count, const svo_submit *submit)
{
    return svo_probes_irradiance(of->probes, input, output, count, submit);
}

static const struct {
    const char *function, *output;
    submit_batch *call;
} batches[] = {
    {"svo_trace_triangles", "hits", trace},
    {"svo_tree_nearest", "results", nearest},
    {"svo_trace_voxels", "hits", trace_voxels},
    {"svo_trace_voxels", "hits", trace_compact},
    {"svo_trace_voxels", "hits", trace_scene},
    {"svo_trace_triangles", "hits", trace_triangles},
    {"svo_gather", "results", gather},
    {"svo_probes_trace", "hits", trace_probes},
    {"svo_probes_irradiance", "results", irradiance},
};
#define BATCH_COUNT (sizeof batches / sizeof batches[0])

static cl_mem make_memory(const subjects *of, cl_mem_flags flags, int byte)
{
    unsigned char bytes[COUNT * RECORD_BYTES];
    memset(bytes, byte, sizeof bytes);
    cl_mem made = clCreateBuffer(info_of_device(of->opened.device).context, flags | CL_MEM_COPY_HOST_PTR, sizeof bytes,
                                 bytes, NULL);
    assert_non_null(made);
    return made;
}

/* Runs a batch of records of zeros and reads what it wrote. */
static void run_batch(subjects *of, size_t batch, cl_command_queue queue, unsigned char bytes[COUNT * RECORD_BYTES])
{
    cl_mem input = make_memory(of, CL_MEM_READ_ONLY, 0);
    cl_mem output = make_memory(of, CL_MEM_WRITE_ONLY, 0x5a);
    cl_event event = NULL;
    succeed(of, batches[batch].call(of, svo_in_buffer(input), svo_in_buffer(output), COUNT,
                                    &(svo_submit){.queue = queue, .event = &event}));
    assert_non_null(event);
    assert_int_equal(
        clEnqueueReadBuffer(of->opened.queue, output, CL_TRUE, 0, COUNT * RECORD_BYTES, bytes, 1, &event, NULL),
        CL_SUCCESS);
    clReleaseEvent(event);
    clReleaseMemObject(output);
    clReleaseMemObject(input);
}

static void batches_without_a_queue_take_the_devices_own(void **state)
{
    subjects of = make_subjects(state);
    for (size_t i = 0; i < BATCH_COUNT; ++i) {
        unsigned char expected[COUNT * RECORD_BYTES], actual[COUNT * RECORD_BYTES];
        run_batch(&of, i, of.opened.queue, expected);
        run_batch(&of, i, NULL, actual);
        if (memcmp(expected, actual, sizeof expected) != 0) {
            fail_msg("%s: other results on the device's own queue", batches[i].function);
        }
    }
    release_subjects(&of);
}

static cl_int state_of(cl_event event)
{
    cl_int state = CL_QUEUED;
    assert_non_null(event);
    assert_int_equal(clGetEventInfo(event, CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof state, &state, NULL), CL_SUCCESS);
    return state;
}

static void expect_complete(cl_event event)
{
    assert_int_equal(state_of(event), CL_COMPLETE);
    clReleaseEvent(event);
}

/* How often a call that succeeds waits. */
#define WAITS_OF(of, call) (counting_begin(), succeed(of, call), counting_read().waits)

/* Without an svo_submit, and with arrays in host memory, the commands are complete when the call returns. */
static void batches_wait_where_they_say_so(void **state)
{
    subjects of = make_subjects(state);
    const unsigned char zeros[COUNT * RECORD_BYTES] = {0};
    for (size_t i = 0; i < BATCH_COUNT; ++i) {
        unsigned char expected[COUNT * RECORD_BYTES], actual[COUNT * RECORD_BYTES];
        cl_mem input = make_memory(&of, CL_MEM_READ_ONLY, 0);
        cl_mem output = make_memory(&of, CL_MEM_WRITE_ONLY, 0x5a);
        cl_event events[2] = {NULL, NULL};
        const svo_array from = svo_in_buffer(input);
        const svo_array to = svo_in_buffer(output);
        const svo_submit on_queue = {.queue = of.opened.queue, .event = &events[0]};
        run_batch(&of, i, of.opened.queue, expected); /* this makes a BVH and compiles */
        assert_int_equal(WAITS_OF(&of, batches[i].call(&of, from, to, COUNT, &(svo_submit){.queue = NULL})), 0);
        assert_true(WAITS_OF(&of, batches[i].call(&of, from, to, COUNT, NULL)) > 0);
        assert_int_equal(clEnqueueReadBuffer(of.opened.queue, output, CL_TRUE, 0, sizeof actual, actual, 0, NULL, NULL),
                         CL_SUCCESS);
        assert_memory_equal(actual, expected, sizeof expected);
        memset(actual, 0x5a, sizeof actual);
        assert_true(WAITS_OF(&of, batches[i].call(&of, svo_in_host(zeros), svo_in_host(actual), COUNT, &on_queue)) > 0);
        expect_complete(events[0]);
        assert_memory_equal(actual, expected, sizeof expected);
        memset(actual, 0x5a, sizeof actual);
        succeed(&of, batches[i].call(&of, from, svo_in_host(actual), COUNT, &(svo_submit){.event = &events[1]}));
        expect_complete(events[1]);
        assert_memory_equal(actual, expected, sizeof expected);
        clReleaseMemObject(output);
        clReleaseMemObject(input);
    }
    release_subjects(&of);
}

static svo_render_options tree_view(const subjects *of)
{
    svo_render_options options = {.struct_size = sizeof options, .width = WIDTH, .height = WIDTH};
    (void)svo_camera_fit(svo_tree_target(of->tree), 1, &options.camera);
    return options;
}

static void expect_unsupported(const subjects *of, svo_status status, const char *function, const char *name)
{
    char expected[160];
    (void)snprintf(expected, sizeof expected, "%s: not of a %s", function, name);
    assert_int_equal(status, SVO_UNSUPPORTED);
    assert_string_equal(svo_device_message(of->opened.device), expected);
}

/* What a handle cannot do is refused with words, and so is what is no target. */
static void targets_refuse_what_they_have_not(void **state)
{
    subjects of = make_subjects(state);
    const svo_target none = {.of = of.tree};
    const svo_ray ray = {.direction = {0, 0, 1}, .t_max = 1};
    const svo_array rays = svo_in_host(&ray);
    svo_voxel_hit hit = {.node = 5};
    const svo_array hits = svo_in_host(&hit);
    assert_int_equal(svo_trace_triangles(none, rays, hits, 1, 0, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_trace_voxels(svo_scene_target(NULL), rays, hits, 1, 0, 0, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_trace_triangles(svo_compact_target(of.compact), rays, hits, 1, 0, NULL), SVO_UNSUPPORTED);
    assert_string_equal(svo_device_message(of.opened.device), "svo_trace_triangles: not of a compact tree");
    const struct {
        svo_target target;
        const char *name;
    } without_rays[] = {{svo_light_target(of.light), "light"}, {svo_probes_target(of.probes), "light field"}};
    for (size_t i = 0; i < 2; ++i) {
        const svo_target target = without_rays[i].target;
        expect_unsupported(&of, svo_trace_triangles(target, rays, hits, 1, 0, NULL), "svo_trace_triangles",
                           without_rays[i].name);
        expect_unsupported(&of, svo_trace_voxels(target, rays, hits, 1, 0, 0, NULL), "svo_trace_voxels",
                           without_rays[i].name);
    }
    const svo_render_options view = tree_view(&of);
    uint8_t rgba[PIXELS_BYTES];
    svo_camera camera = {.vertical_fov = 0};
    expect_unsupported(&of, svo_render(svo_probes_target(of.probes), &view, svo_in_host(rgba), NULL), "svo_render",
                       "light field");
    expect_unsupported(&of, svo_camera_fit(svo_probes_target(of.probes), 1, &camera), "svo_camera_fit", "light field");
    const svo_target nothing = {NULL, NULL};
    assert_int_equal(svo_camera_fit(nothing, 1, &camera), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_kernel_set_arguments(nothing, NULL, 0), SVO_INVALID_ARGUMENT);
    assert_null(svo_kernel_source(nothing));
    assert_null(svo_kernel_options(nothing));
    assert_float_equal(camera.vertical_fov, 0, 0);
    const svo_target without_flags[] = {svo_tree_target(of.tree), svo_compact_target(of.compact)};
    for (size_t i = 0; i < 2; ++i) {
        assert_int_equal(svo_trace_voxels(without_flags[i], rays, hits, 1, 0, SVO_SCENE_ANY, NULL),
                         SVO_INVALID_ARGUMENT);
        assert_string_equal(svo_device_message(of.opened.device),
                            "svo_trace_voxels: flags 1 is not 0, and not of a scene");
    }
    assert_int_equal(hit.node, 5);
    release_subjects(&of);
}

static void batches_refuse_memory_that_kernels_must_not_write(void **state)
{
    subjects of = make_subjects(state);
    cl_mem input = make_memory(&of, CL_MEM_READ_ONLY, 0);
    cl_mem output = make_memory(&of, CL_MEM_READ_ONLY, 0);
    for (size_t i = 0; i < BATCH_COUNT; ++i) {
        char expected[160];
        cl_event event = NULL;
        (void)snprintf(expected, sizeof expected, "%s: %s is of CL_MEM_READ_ONLY, and kernels write it",
                       batches[i].function, batches[i].output);
        const svo_submit submit = {.queue = of.opened.queue, .event = &event};
        assert_int_equal(batches[i].call(&of, svo_in_buffer(input), svo_in_buffer(output), COUNT, &submit),
                         SVO_INVALID_ARGUMENT);
        assert_string_equal(svo_device_message(of.opened.device), expected);
        assert_null(event);
    }
    clReleaseMemObject(output);
    clReleaseMemObject(input);
    release_subjects(&of);
}

/* ---- a marker that fails ---- */

static bool marker_fails;

/* NOLINTBEGIN(readability-identifier-naming) */
cl_int __real_clEnqueueMarkerWithWaitList(cl_command_queue queue, cl_uint num_wait, const cl_event *wait,
                                          cl_event *event);
cl_int __wrap_clEnqueueMarkerWithWaitList(cl_command_queue queue, cl_uint num_wait, const cl_event *wait,
                                          cl_event *event);
cl_int __wrap_clEnqueueMarkerWithWaitList(cl_command_queue queue, cl_uint num_wait, const cl_event *wait,
                                          cl_event *event)
{
    return marker_fails ? CL_INVALID_OPERATION : __real_clEnqueueMarkerWithWaitList(queue, num_wait, wait, event);
}
/* NOLINTEND(readability-identifier-naming) */

static void a_marker_that_fails_is_named(void **state)
{
    subjects of = make_subjects(state);
    for (size_t i = 0; i < BATCH_COUNT; ++i) {
        char expected[160];
        cl_event event = NULL;
        (void)snprintf(expected, sizeof expected, "%s: clEnqueueMarkerWithWaitList", batches[i].function);
        marker_fails = true;
        const svo_submit submit = {.queue = of.opened.queue, .event = &event};
        const svo_status status = batches[i].call(&of, svo_in_buffer(NULL), svo_in_buffer(NULL), 0, &submit);
        marker_fails = false;
        assert_int_equal(status, SVO_CL_ERROR);
        if (strncmp(svo_device_message(of.opened.device), expected, strlen(expected)) != 0) {
            fail_msg("'%s' does not begin with '%s'", svo_device_message(of.opened.device), expected);
        }
    }
    release_subjects(&of);
}

/* ---- pictures ---- */

typedef svo_status submit_picture(subjects *of, svo_array pixels, const svo_submit *submit);

static svo_status draw_tree(subjects *of, svo_array pixels, const svo_submit *submit)
{
    const svo_render_options options = tree_view(of);
    return svo_render(svo_tree_target(of->tree), &options, pixels, submit);
}

static svo_status draw_compact(subjects *of, svo_array pixels, const svo_submit *submit)
{
    const svo_render_options options = tree_view(of);
    return svo_render(svo_compact_target(of->compact), &options, pixels, submit);
}

static svo_status draw_scene(subjects *of, svo_array pixels, const svo_submit *submit)
{
    svo_render_options options = {.struct_size = sizeof options, .width = WIDTH, .height = WIDTH};
    (void)svo_camera_fit(svo_scene_target(of->scene), 1, &options.camera);
    return svo_render(svo_scene_target(of->scene), &options, pixels, submit);
}

static svo_status draw_light(subjects *of, svo_array pixels, const svo_submit *submit)
{
    const svo_gather_options gather = {.struct_size = sizeof gather, .cones = 1};
    svo_render_options picture = SVO_RENDER_OPTIONS_INIT;
    picture.width = picture.height = WIDTH;
    picture.gather = &gather;
    (void)svo_camera_fit(svo_tree_target(of->tree), 1, &picture.camera);
    return svo_render(svo_light_target(of->light), &picture, pixels, submit);
}

static submit_picture *const pictures[] = {draw_tree, draw_compact, draw_scene, draw_light};
#define PICTURE_COUNT (sizeof pictures / sizeof pictures[0])

static void draw(subjects *of, submit_picture *call, cl_command_queue queue, uint8_t rgba[PIXELS_BYTES])
{
    cl_mem pixels =
        clCreateBuffer(info_of_device(of->opened.device).context, CL_MEM_READ_WRITE, PIXELS_BYTES, NULL, NULL);
    cl_event event = NULL;
    assert_non_null(pixels);
    succeed(of, call(of, svo_in_buffer(pixels), &(svo_submit){.queue = queue, .event = &event}));
    assert_int_equal(clEnqueueReadBuffer(of->opened.queue, pixels, CL_TRUE, 0, PIXELS_BYTES, rgba, 1, &event, NULL),
                     CL_SUCCESS);
    clReleaseEvent(event);
    clReleaseMemObject(pixels);
}

static void pictures_without_a_queue_take_the_devices_own(void **state)
{
    subjects of = make_subjects(state);
    for (size_t i = 0; i < PICTURE_COUNT; ++i) {
        uint8_t expected[PIXELS_BYTES], actual[PIXELS_BYTES];
        draw(&of, pictures[i], of.opened.queue, expected);
        draw(&of, pictures[i], NULL, actual);
        assert_memory_equal(expected, actual, sizeof expected);
    }
    release_subjects(&of);
}

/* ---- events of the caller's ---- */

/* Behind so much work that a call which does not wait for it begins earlier. */
#define LARGE_BYTES ((size_t)64 << 20)

typedef struct late_input {
    cl_command_queue queue; /* of any order */
    cl_mem large, memory;
    unsigned char zeros[COUNT * RECORD_BYTES];
    cl_event written; /* of the zeros to the memory */
} late_input;

/* Writes records of zeros, at some time. */
static void write_late(late_input *to)
{
    const cl_uchar byte = 1;
    const cl_uchar other = 0x7f;
    cl_event filled[2] = {NULL, NULL};
    assert_int_equal(clEnqueueFillBuffer(to->queue, to->memory, &other, 1, 0, sizeof to->zeros, 0, NULL, &filled[0]),
                     CL_SUCCESS);
    assert_int_equal(clEnqueueFillBuffer(to->queue, to->large, &byte, 1, 0, LARGE_BYTES, 0, NULL, &filled[1]),
                     CL_SUCCESS);
    assert_int_equal(
        clEnqueueWriteBuffer(to->queue, to->memory, CL_FALSE, 0, sizeof to->zeros, to->zeros, 2, filled, &to->written),
        CL_SUCCESS);
    clReleaseEvent(filled[0]);
    clReleaseEvent(filled[1]);
}

static void arrays_in_host_memory_wait_for_events(void **state)
{
    subjects of = make_subjects(state);
    const svo_device_info info = info_of_device(of.opened.device);
    late_input input = {.memory = make_memory(&of, CL_MEM_READ_ONLY, 0)};
    input.queue = clCreateCommandQueue(info.context, info.device, CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, NULL);
    input.large = clCreateBuffer(info.context, CL_MEM_READ_WRITE, LARGE_BYTES, NULL, NULL);
    assert_non_null(input.large);
    if (input.queue == NULL) {
        print_message("on a queue in order: this device has no other\n");
        input.queue = clCreateCommandQueue(info.context, info.device, 0, NULL);
    }
    const svo_submit submit = {.queue = input.queue, .num_wait = 1, .wait = &input.written};
    for (size_t i = 0; i < BATCH_COUNT; ++i) {
        unsigned char expected[COUNT * RECORD_BYTES], actual[COUNT * RECORD_BYTES];
        run_batch(&of, i, of.opened.queue, expected);
        memset(actual, 0x5a, sizeof actual);
        write_late(&input);
        succeed(&of, batches[i].call(&of, svo_in_buffer(input.memory), svo_in_host(actual), COUNT, &submit));
        expect_complete(input.written);
        assert_memory_equal(actual, expected, sizeof expected);
    }
    for (size_t i = 0; i < PICTURE_COUNT; ++i) {
        uint8_t expected[PIXELS_BYTES], actual[PIXELS_BYTES];
        draw(&of, pictures[i], of.opened.queue, expected);
        write_late(&input);
        succeed(&of, pictures[i](&of, svo_in_host(actual), &submit));
        expect_complete(input.written);
        assert_memory_equal(actual, expected, sizeof expected);
    }
    clReleaseMemObject(input.large);
    clReleaseMemObject(input.memory);
    clReleaseCommandQueue(input.queue);
    release_subjects(&of);
}

/* Arrays in host memory lie anywhere, also on each other. On CPUs kernels use those that are aligned where they are:
   nothing is copied. */
static void arrays_in_host_memory_lie_anywhere(void **state)
{
    enum { BYTES = COUNT * RECORD_BYTES };
    static const struct {
        size_t input, output; /* from a place that is aligned */
        bool is_copied;
    } places[] = {{0, BYTES, false},     {16, BYTES + 48, false}, {4, BYTES + 16, true},  {0, BYTES + 4, false},
                  {8, BYTES + 12, true}, {0, 0, false},           {BYTES / 2, 16, false}, {16, BYTES / 2, false}};
    subjects of = make_subjects(state);
    _Alignas(64) unsigned char memory[3 * BYTES];
    for (size_t i = 0; i < BATCH_COUNT; ++i) {
        unsigned char expected[BYTES] = {0};
        const unsigned char zeros[BYTES] = {0};
        succeed(&of, batches[i].call(&of, svo_in_host(zeros), svo_in_host(expected), COUNT, NULL));
        for (size_t k = 0; k < sizeof places / sizeof places[0]; ++k) {
            memset(memory, 0, sizeof memory);
            counting_begin();
            succeed(&of, batches[i].call(&of, svo_in_host(memory + places[k].input),
                                         svo_in_host(memory + places[k].output), COUNT, NULL));
            const counted did = counting_read();
            assert_memory_equal(memory + places[k].output, expected, BYTES);
            if (of.opened.device->cpu_path) {
                assert_int_equal(did.writes, places[k].is_copied ? 1 : 0);
            }
        }
    }
    release_subjects(&of);
}

static void batches_of_nothing_wait_for_events(void **state)
{
    subjects of = make_subjects(state);
    for (size_t i = 0; i < BATCH_COUNT; ++i) {
        cl_event gate = clCreateUserEvent(info_of_device(of.opened.device).context, NULL);
        cl_event event = NULL;
        const svo_submit submit = {.queue = of.opened.queue, .num_wait = 1, .wait = &gate, .event = &event};
        succeed(&of, batches[i].call(&of, svo_in_buffer(NULL), svo_in_buffer(NULL), 0, &submit));
        assert_int_equal(clFlush(of.opened.queue), CL_SUCCESS);
        assert_true(state_of(event) > CL_COMPLETE);
        assert_int_equal(clSetUserEventStatus(gate, CL_COMPLETE), CL_SUCCESS);
        assert_int_equal(clWaitForEvents(1, &event), CL_SUCCESS);
        expect_complete(event);
        clReleaseEvent(gate);
    }
    release_subjects(&of);
}

/* ---- builds and updates ---- */

static void wait_for(cl_event *event)
{
    assert_non_null(*event);
    assert_int_equal(clWaitForEvents(1, event), CL_SUCCESS);
    clReleaseEvent(*event);
    *event = NULL;
}

/* A workspace of an updatable plan: built, updated, refit, without a queue anywhere. */
static void builds_without_a_queue_take_the_devices_own(void **state)
{
    subjects of = {.opened = fixture_cl_of_group(state)};
    struct scene *cube = fixture_scene("cube");
    const svo_plan_options options = {
        .struct_size = sizeof options, .need = NEEDS, .origin = {-4, -4, -4}, .edge = 8, .updatable = 1};
    svo_plan *plan = NULL;
    svo_workspace *workspace = NULL;
    svo_tree *tree = NULL;
    cl_event event = NULL;
    char expected[SVO_HASH_TEXT_BYTES], actual[SVO_HASH_TEXT_BYTES];
    succeed(&of, svo_plan_create(of.opened.device, scene_mesh(cube), DEPTH, &options, &plan));
    succeed(&of, svo_build(plan, NULL, NULL, &tree, NULL));
    succeed(&of, svo_tree_download(tree, NULL));
    succeed(&of, svo_tree_hash(tree, SVO_HASH_ALL, expected));
    svo_tree_destroy(&tree);
    succeed(&of, svo_workspace_create(plan, of.opened.cl, NULL, NULL, &workspace));
    succeed(&of, svo_workspace_make_tree(workspace, &tree));
    succeed(&of, svo_build_enqueue(workspace, tree, &(svo_submit){.event = &event}));
    wait_for(&event);
    succeed(&of, svo_tree_finish(tree, NULL, 0, NULL));
    succeed(&of, svo_tree_make_bvh(tree, SVO_BVH_FAST, NULL));
    assert_int_equal(WAITS_OF(&of, svo_plan_update(plan, scene_mesh(cube), &(svo_submit){.event = &event})), 0);
    wait_for(&event);
    assert_int_equal(WAITS_OF(&of, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = NULL})), 0);
    assert_int_equal(WAITS_OF(&of, svo_tree_refit_bvh(tree, &(svo_submit){.event = &event})), 0);
    wait_for(&event);
    succeed(&of, svo_tree_finish(tree, NULL, 0, NULL));
    /* The same, and each call waits. */
    assert_true(WAITS_OF(&of, svo_plan_update(plan, scene_mesh(cube), NULL)) > 0);
    assert_true(WAITS_OF(&of, svo_build_enqueue(workspace, tree, NULL)) > 0);
    assert_true(WAITS_OF(&of, svo_tree_refit_bvh(tree, NULL)) > 0);
    succeed(&of, svo_tree_finish(tree, NULL, 1, NULL));
    succeed(&of, svo_tree_download(tree, NULL));
    succeed(&of, svo_tree_hash(tree, SVO_HASH_ALL, actual));
    assert_string_equal(actual, expected);
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
    scene_destroy(&cube);
}

static void updates_without_a_queue_take_the_devices_own(void **state)
{
    subjects of = {.opened = fixture_cl_of_group(state)};
    struct scene *cube = fixture_scene("cube");
    const svo_moving_options options = {
        .struct_size = sizeof options, .need = NEEDS, .origin = {-4, -4, -4}, .edge = 8, .max_area = 100};
    const double aside[12] = {1, 0, 0, 2, 0, 1, 0, 0, 0, 0, 1, 0};
    svo_moving *moving = NULL;
    svo_moving_report report = SVO_MOVING_REPORT_INIT;
    cl_event event = NULL;
    uint32_t object = 0;
    succeed(&of, svo_moving_create(of.opened.device, scene_mesh(cube), DEPTH, &options, NULL, &moving));
    succeed(&of, svo_moving_add(moving, scene_mesh(cube), aside, &object));
    succeed(&of, svo_moving_update(moving, &(svo_submit){.event = &event}, NULL));
    wait_for(&event);
    succeed(&of, svo_moving_finish(moving, &report));
    assert_true(report.changed_objects == 1 && report.changed_fragments > 0);
    svo_moving_destroy(&moving);
    scene_destroy(&cube);
}

/* ---- trees on no device ---- */

static void what_is_on_no_device_is_refused_with_words(void **state)
{
    subjects of = make_subjects(state);
    const svo_render_options view = tree_view(&of);
    const svo_ray ray = {.direction = {0, 0, 1}, .t_max = 1};
    const svo_query_point point = {.max_distance = 1};
    svo_hit hit;
    svo_voxel_hit voxel;
    svo_nearest near_point;
    uint8_t rgba[PIXELS_BYTES];
    cl_mem pixels =
        clCreateBuffer(info_of_device(of.opened.device).context, CL_MEM_READ_WRITE, PIXELS_BYTES, NULL, NULL);
    svo_light *light = NULL;
    svo_probes *probes = NULL;
    svo_compact *solid = NULL;
    svo_tree *expanded = NULL;
    svo_device *const device = of.tree->device;
    of.tree->device = NULL; /* as a tree from a file has it */
    of.compact->device = NULL;
    assert_int_equal(
        svo_trace_triangles(svo_tree_target(of.tree), svo_in_host(&ray), svo_in_host(&hit), 1, SVO_TRACE_CLOSEST, NULL),
        SVO_NOT_ON_DEVICE);
    assert_int_equal(svo_trace_voxels(svo_tree_target(of.tree), svo_in_host(&ray), svo_in_host(&voxel), 1, 0, 0, NULL),
                     SVO_NOT_ON_DEVICE);
    assert_int_equal(svo_tree_nearest(of.tree, svo_in_host(&point), svo_in_host(&near_point), 1, NULL),
                     SVO_NOT_ON_DEVICE);
    assert_int_equal(svo_light_create(of.tree, NULL, NULL, &light), SVO_NOT_ON_DEVICE);
    assert_int_equal(svo_probes_create(&(svo_probe_options){.struct_size = sizeof(svo_probe_options), .tree = of.tree},
                                       NULL, &probes),
                     SVO_NOT_ON_DEVICE);
    assert_int_equal(svo_solid_create(of.tree, NULL, NULL, &solid, NULL), SVO_NOT_ON_DEVICE);
    assert_int_equal(svo_tree_refit_bvh(of.tree, &(svo_submit){.queue = NULL}), SVO_NOT_ON_DEVICE);
    assert_int_equal(
        svo_trace_voxels(svo_compact_target(of.compact), svo_in_host(&ray), svo_in_host(&voxel), 1, 0, 0, NULL),
        SVO_NOT_ON_DEVICE);
    assert_int_equal(svo_render(svo_compact_target(of.compact), &view, svo_in_host(rgba), NULL), SVO_NOT_ON_DEVICE);
    assert_int_equal(
        svo_render(svo_compact_target(of.compact), &view, svo_in_buffer(pixels), &(svo_submit){.queue = NULL}),
        SVO_NOT_ON_DEVICE);
    assert_int_equal(svo_compact_expand(of.compact, NULL, &expanded), SVO_NOT_ON_DEVICE);
    assert_string_equal(svo_name(SVO_NAME_STATUS_TEXT, SVO_NOT_ON_DEVICE),
                        "the tree is not on a device; upload it first");
    of.tree->device = of.compact->device = device;
    clReleaseMemObject(pixels);
    release_subjects(&of);
}

TEST_GROUP(enqueue)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(batches_without_a_queue_take_the_devices_own),
        cmocka_unit_test(batches_wait_where_they_say_so),
        cmocka_unit_test(targets_refuse_what_they_have_not),
        cmocka_unit_test(batches_refuse_memory_that_kernels_must_not_write),
        cmocka_unit_test(a_marker_that_fails_is_named),
        cmocka_unit_test(pictures_without_a_queue_take_the_devices_own),
        cmocka_unit_test(arrays_in_host_memory_wait_for_events),
        cmocka_unit_test(arrays_in_host_memory_lie_anywhere),
        cmocka_unit_test(batches_of_nothing_wait_for_events),
        cmocka_unit_test(builds_without_a_queue_take_the_devices_own),
        cmocka_unit_test(updates_without_a_queue_take_the_devices_own),
        cmocka_unit_test(what_is_on_no_device_is_refused_with_words),
    };
    return cmocka_run_group_tests_name("enqueue", tests, fixture_group_setup, fixture_group_teardown);
}
