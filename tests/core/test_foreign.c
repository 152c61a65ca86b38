/* SPDX-License-Identifier: MIT */
/*
 * Callers' objects of another OpenCL context: every entry that takes a queue, a buffer, a kernel or an event refuses
 * them with words, whatever the driver would make of them. Some drivers run such a command and compute nonsense.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "core/tree.h"
#include "scenes.h"
#include "support/fixture.h"
#include "support/info_of.h"
#include "support/suite.h"

#define DEPTH 4

/* The same device in a second context. */
typedef struct foreigner {
    cl_context context;
    cl_command_queue queue;
    cl_mem memory;
    cl_event event; /* complete */
    cl_kernel kernel;
} foreigner;

/* What is right: everything of the device handle's context. */
typedef struct native {
    const fixture *opened;
    cl_mem memory, image;
    svo_tree *tree; /* with rays */
    svo_plan *plan;
} native;

#define MEMORY_BYTES 4096

static foreigner make_foreigner(const fixture *opened)
{
    const cl_device_id device = info_of_device(opened->device).device;
    foreigner made = {.context = clCreateContext(NULL, 1, &device, NULL, NULL, NULL)};
    assert_non_null(made.context);
    made.queue = clCreateCommandQueue(made.context, device, 0, NULL);
    made.memory = clCreateBuffer(made.context, CL_MEM_READ_WRITE, MEMORY_BYTES, NULL, NULL);
    made.event = clCreateUserEvent(made.context, NULL);
    made.kernel = fixture_tree_kernel(made.context, device);
    assert_non_null(made.queue);
    assert_non_null(made.memory);
    assert_non_null(made.event);
    clSetUserEventStatus(made.event, CL_COMPLETE);
    return made;
}

static void release_foreigner(foreigner *made)
{
    clReleaseKernel(made->kernel);
    clReleaseEvent(made->event);
    clReleaseMemObject(made->memory);
    clReleaseCommandQueue(made->queue);
    clReleaseContext(made->context);
}

static void succeed(const native *own, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), svo_device_message(own->opened->device));
    }
}

static native make_native(const fixture *opened)
{
    native made = {.opened = opened};
    const svo_plan_options options = {.struct_size = sizeof options, .need = SVO_NEED_ALL};
    struct scene *cube = fixture_scene("cube");
    const cl_context context = info_of_device(opened->device).context;
    made.memory = clCreateBuffer(context, CL_MEM_READ_WRITE, MEMORY_BYTES, NULL, NULL);
    assert_non_null(made.memory);
    const cl_image_format format = {CL_RGBA, CL_UNSIGNED_INT8};
    const cl_image_desc shape = {.image_type = CL_MEM_OBJECT_IMAGE2D, .image_width = 64, .image_height = 64};
    made.image = clCreateImage(context, CL_MEM_READ_WRITE, &format, &shape, NULL, NULL); /* NULL without images */
    succeed(&made, svo_plan_create(opened->device, scene_mesh(cube), DEPTH, &options, &made.plan));
    succeed(&made, svo_build(made.plan, opened->frontend, opened->queue, &made.tree, NULL));
    succeed(&made, svo_tree_make_bvh(made.tree, SVO_BVH_BEST, opened->queue));
    scene_destroy(&cube);
    return made;
}

static void release_native(native *made)
{
    svo_tree_destroy(&made->tree);
    svo_plan_destroy(&made->plan);
    clReleaseMemObject(made->memory);
    if (made->image != NULL) {
        clReleaseMemObject(made->image);
    }
}

/* argument: what the message names first: "queue", "rays", "wait". */
static void expect_words(svo_status status, const char *message, const char *function, const char *argument,
                         const char *words)
{
    char begin[128];
    (void)snprintf(begin, sizeof begin, "%s: %s", function, argument);
    if (status != SVO_INVALID_ARGUMENT || strncmp(message, begin, strlen(begin)) != 0 ||
        strstr(message, words) == NULL) {
        fail_msg("%s, %s: %s, '%s'", function, argument, svo_name(SVO_NAME_STATUS, status), message);
    }
}

static void refused(const native *own, svo_status status, const char *function, const char *argument)
{
    expect_words(status, svo_device_message(own->opened->device), function, argument, "of another context");
}

#define REFUSED(function, ...) refused(&own, function(__VA_ARGS__), #function, "queue")

static void queues_of_another_context_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    native own = make_native(&opened);
    foreigner other = make_foreigner(&opened);
    const cl_command_queue queue = other.queue;
    const svo_submit submit = {.queue = queue};
    const svo_target target = svo_tree_target(own.tree);
    const svo_array memory = svo_in_buffer(own.memory);
    const svo_ray ray = {.direction = {0, 0, 1}, .t_max = 1};
    const svo_query_point point = {.max_distance = 1};
    svo_hit hit = {.t = 0};
    svo_nearest nearest = {.triangle = 0};
    uint8_t picture[8 * 8 * 4] = {0};
    svo_render_options options = {.struct_size = sizeof options, .width = 8, .height = 8};
    svo_tree *unmade = NULL;
    svo_workspace *workspace = NULL;
    (void)svo_camera_fit(svo_tree_target(own.tree), 1.0F, &options.camera);
    REFUSED(svo_tree_download, own.tree, queue);
    REFUSED(svo_render, target, &options, svo_in_host(picture), &submit);
    REFUSED(svo_trace_triangles, target, svo_in_host(&ray), svo_in_host(&hit), 1, SVO_TRACE_CLOSEST, &submit);
    REFUSED(svo_trace_triangles, target, memory, memory, 1, SVO_TRACE_CLOSEST, &submit);
    REFUSED(svo_trace_triangles, target, svo_in_buffer(NULL), svo_in_buffer(NULL), 0, SVO_TRACE_CLOSEST, &submit);
    REFUSED(svo_tree_nearest, own.tree, svo_in_host(&point), svo_in_host(&nearest), 1, &submit);
    REFUSED(svo_tree_nearest, own.tree, memory, memory, 1, &submit);
    REFUSED(svo_build, own.plan, opened.frontend, queue, &unmade, NULL);
    REFUSED(svo_plan_count, own.plan, opened.frontend, queue);
    REFUSED(svo_workspace_create, own.plan, opened.frontend, queue, NULL, &workspace);
    assert_null(unmade);
    assert_null(workspace);
    succeed(&own, svo_build(own.plan, opened.frontend, opened.queue, &unmade, NULL));
    REFUSED(svo_tree_make_bvh, unmade, SVO_BVH_FAST, queue);
    svo_tree_destroy(&unmade);
    unmade = svo_i_tree_new(NULL); /* like one from a file: on no device yet */
    assert_non_null(unmade);
    REFUSED(svo_tree_upload, unmade, opened.device, queue);
    svo_tree_destroy(&unmade);
    succeed(&own, svo_workspace_create(own.plan, opened.frontend, opened.queue, NULL, &workspace));
    succeed(&own, svo_workspace_make_tree(workspace, &unmade));
    REFUSED(svo_build_enqueue, workspace, unmade, &submit);
    succeed(&own, svo_build_enqueue(workspace, unmade, &(svo_submit){.queue = opened.queue}));
    REFUSED(svo_tree_finish, unmade, queue, 1, NULL);
    succeed(&own, svo_tree_finish(unmade, opened.queue, 1, NULL)); /* the refusal has changed nothing */
    svo_tree_destroy(&unmade);
    svo_workspace_destroy(&workspace);
    release_foreigner(&other);
    release_native(&own);
}

static void scenes_refuse_what_is_of_another_context(void **state)
{
    static const svo_instance instance = {0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    const fixture opened = fixture_cl_of_group(state);
    native own = make_native(&opened);
    foreigner other = make_foreigner(&opened);
    const svo_ray ray = {.direction = {0, 0, 1}, .t_max = 1};
    const svo_scene_options options = {.struct_size = sizeof options,
                                       .trees = &own.tree,
                                       .instances = &instance,
                                       .tree_count = 1,
                                       .instance_count = 1};
    svo_render_options shown = {.struct_size = sizeof shown, .width = 8, .height = 8};
    svo_scene_hit hit = {.t = 0};
    uint8_t picture[8 * 8 * 4];
    svo_scene *placed = NULL;
    const svo_submit submit = {.queue = other.queue};
    REFUSED(svo_scene_create, opened.device, &options, other.queue, &placed);
    assert_null(placed);
    succeed(&own, svo_scene_create(opened.device, &options, opened.queue, &placed));
    (void)svo_camera_fit(svo_scene_target(placed), 1.0F, &shown.camera);
    REFUSED(svo_scene_set_transforms, placed, 0, 1, instance.transform, other.queue);
    REFUSED(svo_scene_rebuild, placed, other.queue);
    REFUSED(svo_render, svo_scene_target(placed), &shown, svo_in_host(picture), &submit);
    REFUSED(svo_trace_voxels, svo_scene_target(placed), svo_in_host(&ray), svo_in_host(&hit), 1, 0.0F, 0, &submit);
    REFUSED(svo_trace_voxels, svo_scene_target(placed), svo_in_buffer(own.memory), svo_in_buffer(own.memory), 1, 0.0F,
            0, &submit);
    refused(&own,
            svo_trace_voxels(svo_scene_target(placed), svo_in_buffer(other.memory), svo_in_buffer(own.memory), 1, 0, 0,
                             &(svo_submit){.queue = opened.queue}),
            "svo_trace_voxels", "rays");
    refused(&own,
            svo_trace_voxels(svo_scene_target(placed), svo_in_buffer(own.memory), svo_in_buffer(other.memory), 1, 0, 0,
                             &(svo_submit){.queue = opened.queue}),
            "svo_trace_voxels", "hits");
    /* Nothing was lost. */
    succeed(&own, svo_trace_voxels(svo_scene_target(placed), svo_in_host(&ray), svo_in_host(&hit), 1, 0.0F, 0,
                                   &(svo_submit){.queue = opened.queue}));
    svo_scene_destroy(&placed);
    release_native(&own);
    release_foreigner(&other);
}

static void buffers_and_kernels_of_another_context_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    native own = make_native(&opened);
    foreigner other = make_foreigner(&opened);
    const cl_mem mine = own.memory;
    const cl_mem theirs = other.memory;
    const cl_command_queue queue = opened.queue;
#define TRACE(rays, hits)                                                                                          \
    svo_trace_triangles(svo_tree_target(own.tree), svo_in_buffer(rays), svo_in_buffer(hits), 1, SVO_TRACE_CLOSEST, \
                        &(svo_submit){.queue = queue})
#define NEAREST(points, into) \
    svo_tree_nearest(own.tree, svo_in_buffer(points), svo_in_buffer(into), 1, &(svo_submit){.queue = queue})
    refused(&own, TRACE(theirs, mine), "svo_trace_triangles", "rays");
    refused(&own, TRACE(mine, theirs), "svo_trace_triangles", "hits");
    refused(&own, NEAREST(theirs, mine), "svo_tree_nearest", "points");
    refused(&own, NEAREST(mine, theirs), "svo_tree_nearest", "results");
    refused(&own, svo_kernel_set_arguments(svo_tree_target(own.tree), other.kernel, 0), "svo_kernel_set_arguments",
            "kernel");
    if (own.image != NULL) {
        expect_words(TRACE(own.image, mine), svo_device_message(opened.device), "svo_trace_triangles", "rays",
                     "is no buffer");
    }
    succeed(&own, TRACE(mine, mine));
    assert_int_equal(clFinish(queue), CL_SUCCESS);
#undef TRACE
#undef NEAREST
    svo_workspace *workspace = NULL;
    const svo_workspace_options options = {.struct_size = sizeof options, .scratch = theirs};
    refused(&own, svo_workspace_create(own.plan, opened.frontend, queue, &options, &workspace), "svo_workspace_create",
            "options.scratch");
    assert_null(workspace);
    release_foreigner(&other);
    release_native(&own);
}

static void events_of_another_context_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    native own = make_native(&opened);
    foreigner other = make_foreigner(&opened);
    const cl_command_queue queue = opened.queue;
    const cl_mem mine = own.memory;
    cl_event right = clCreateUserEvent(info_of_device(opened.device).context, NULL);
    clSetUserEventStatus(right, CL_COMPLETE);
    const cl_event waits[2] = {right, other.event};
    cl_event done = NULL;
    refused(&own,
            svo_trace_triangles(svo_tree_target(own.tree), svo_in_buffer(mine), svo_in_buffer(mine), 1, 0,
                                &(svo_submit){.queue = queue, .num_wait = 2, .wait = waits, .event = &done}),
            "svo_trace_triangles", "wait");
    refused(&own,
            svo_trace_triangles(svo_tree_target(own.tree), svo_in_buffer(NULL), svo_in_buffer(NULL), 0, 0,
                                &(svo_submit){.queue = queue, .num_wait = 2, .wait = waits, .event = &done}),
            "svo_trace_triangles", "wait");
    refused(&own,
            svo_tree_nearest(own.tree, svo_in_buffer(mine), svo_in_buffer(mine), 1,
                             &(svo_submit){.queue = queue, .num_wait = 2, .wait = waits, .event = &done}),
            "svo_tree_nearest", "wait");
    svo_workspace *workspace = NULL;
    svo_tree *tree = NULL;
    succeed(&own, svo_workspace_create(own.plan, opened.frontend, queue, NULL, &workspace));
    succeed(&own, svo_workspace_make_tree(workspace, &tree));
    refused(
        &own,
        svo_build_enqueue(workspace, tree, &(svo_submit){.queue = queue, .num_wait = 2, .wait = waits, .event = &done}),
        "svo_build_enqueue", "wait");
    assert_null(done);
    expect_words(svo_trace_triangles(svo_tree_target(own.tree), svo_in_buffer(mine), svo_in_buffer(mine), 1, 0,
                                     &(svo_submit){.queue = queue, .num_wait = 1, .wait = NULL}),
                 svo_device_message(opened.device), "svo_trace_triangles", "num_wait", "disagree");
    succeed(&own, svo_trace_triangles(svo_tree_target(own.tree), svo_in_buffer(mine), svo_in_buffer(mine), 1, 0,
                                      &(svo_submit){.queue = queue, .num_wait = 1, .wait = waits}));
    succeed(&own, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = queue, .num_wait = 1, .wait = waits}));
    succeed(&own, svo_tree_finish(tree, queue, 0, NULL));
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    clReleaseEvent(right);
    release_foreigner(&other);
    release_native(&own);
}

/* A mesh is read without a device handle: the queue's context decides. */
static void meshes_of_another_context_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    native own = make_native(&opened);
    foreigner other = make_foreigner(&opened);
    svo_message message = {""};
    svo_mesh_copy *copy = NULL;
    const svo_mesh_buffers right = {.struct_size = sizeof right,
                                    .vertex_count = 3,
                                    .triangle_count = 1,
                                    .positions.memory = own.memory,
                                    .indices.memory = own.memory};
    svo_mesh_buffers wrong = right;
    wrong.positions.memory = other.memory;
    expect_words(svo_mesh_read(&wrong, opened.queue, 0, NULL, &copy, &message), message.text, "svo_mesh_read",
                 "positions", "of another context");
    wrong = right;
    wrong.indices.memory = other.memory;
    expect_words(svo_mesh_read(&wrong, opened.queue, 0, NULL, &copy, &message), message.text, "svo_mesh_read",
                 "indices", "of another context");
    expect_words(svo_mesh_read(&right, other.queue, 0, NULL, &copy, &message), message.text, "svo_mesh_read",
                 "positions", "of another context");
    expect_words(svo_mesh_read(&right, opened.queue, 1, &other.event, &copy, &message), message.text, "svo_mesh_read",
                 "wait", "of another context");
    assert_null(copy);
    succeed(&own, svo_mesh_read(&right, opened.queue, 0, NULL, &copy, &message));
    svo_mesh_copy_destroy(&copy);
    release_foreigner(&other);
    release_native(&own);
}

/* Two devices of one context: kernels are compiled for the handle's, so a queue of the other one cannot run them. Here
   the two are parts of one device. */
static void queues_of_another_device_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const cl_device_id whole = info_of_device(opened.device).device;
    const cl_device_partition_property halves[] = {CL_DEVICE_PARTITION_BY_COUNTS, 1, 1,
                                                   CL_DEVICE_PARTITION_BY_COUNTS_LIST_END, 0};
    cl_device_id parts[2] = {NULL, NULL};
    cl_uint part_count = 0;
    if (clCreateSubDevices(whole, halves, 2, parts, &part_count) != CL_SUCCESS || part_count != 2) {
        print_message("skipped: the device cannot be divided\n");
        skip();
    }
    cl_context context = clCreateContext(NULL, 2, parts, NULL, NULL, NULL);
    assert_non_null(context);
    cl_command_queue queues[2];
    for (int i = 0; i < 2; ++i) {
        queues[i] = clCreateCommandQueue(context, parts[i], 0, NULL);
        assert_non_null(queues[i]);
    }
    svo_device *device = NULL;
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    struct scene *cube = fixture_scene("cube");
    assert_int_equal(svo_device_create(context, parts[0], NULL, &device, NULL), SVO_OK);
    assert_int_equal(svo_plan_create(device, scene_mesh(cube), DEPTH, NULL, &plan), SVO_OK);
    expect_words(svo_build(plan, NULL, queues[1], &tree, NULL), svo_device_message(device), "svo_build", "queue",
                 "of another device");
    assert_null(tree);
    assert_int_equal(svo_build(plan, NULL, queues[0], &tree, NULL), SVO_OK);
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    svo_device_destroy(&device);
    scene_destroy(&cube);
    for (int i = 0; i < 2; ++i) {
        clReleaseCommandQueue(queues[i]);
        clReleaseDevice(parts[i]);
    }
    clReleaseContext(context);
}

TEST_GROUP(foreign)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(queues_of_another_context_are_refused),
        cmocka_unit_test(scenes_refuse_what_is_of_another_context),
        cmocka_unit_test(buffers_and_kernels_of_another_context_are_refused),
        cmocka_unit_test(events_of_another_context_are_refused),
        cmocka_unit_test(meshes_of_another_context_are_refused),
        cmocka_unit_test(queues_of_another_device_are_refused),
    };
    return cmocka_run_group_tests_name("foreign", tests, fixture_group_setup, fixture_group_teardown);
}
