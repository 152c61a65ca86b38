/* SPDX-License-Identifier: MIT */
/*
 * Arguments that functions refuse, each with a status and one line that names the function and the value; names of
 * enumerators and of none; the rules that choose a front end; and results at the edge: a grid without triangles, a
 * camera that looks straight up.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "core/device.h"
#include "core/message.h"
#include "core/opencl.h"
#include "plan/configuration.h"
#include "scenes.h"
#include "support/fixture.h"
#include "support/info_of.h"
#ifdef HAVE_IO
#include "support/suite.h"
#include "svocl/io.h"
#endif

#define DEPTH 4

static void expect(const fixture *opened, svo_status got, svo_status expected, const char *text)
{
    const char *message = svo_device_message(opened->device);
    if (got != expected || strstr(message, text) == NULL) {
        fail_msg("%s \"%s\", expected %s \"%s\"", svo_name(SVO_NAME_STATUS, got), message,
                 svo_name(SVO_NAME_STATUS, expected), text);
    }
}

static void succeed(const fixture *opened, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), svo_device_message(opened->device));
    }
}

static svo_plan *plan_cube(const fixture *opened, const svo_plan_options *options)
{
    svo_plan *plan = NULL;
    struct scene *cube = fixture_scene("cube");
    succeed(opened, svo_plan_create(opened->device, scene_mesh(cube), DEPTH, options, &plan));
    scene_destroy(&cube);
    return plan;
}

static svo_tree *build_cube(const fixture *opened, const svo_plan_options *options)
{
    svo_tree *tree = NULL;
    svo_plan *plan = plan_cube(opened, options);
    succeed(opened, svo_build(plan, opened->cl, opened->queue, &tree, NULL));
    svo_plan_destroy(&plan);
    return tree;
}

/* A second handle for the same device. */
static svo_device *open_other(const fixture *opened)
{
    svo_device *other = NULL;
    svo_message message = {""};
    if (svo_device_create(info_of_device(opened->device).context, info_of_device(opened->device).device, NULL, &other,
                          &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return other;
}

/* ---- words ---- */

static void names_of_enumerators_and_of_none(void **state)
{
    (void)state;
    assert_string_equal(svo_name(SVO_NAME_STATUS, SVO_CANCELED), "SVO_CANCELED");
    assert_string_equal(svo_name(SVO_NAME_STATUS_TEXT, SVO_NO_DEVICE), "no OpenCL platform or device fits");
    assert_string_equal(svo_name(SVO_NAME_STATUS, (svo_status)99), "unknown status");
    assert_string_equal(svo_name(SVO_NAME_STATUS_TEXT, (svo_status)99), "unknown status");
    assert_string_equal(svo_name(SVO_NAME_NEED, SVO_NEED_FILL), "fill");
    assert_string_equal(svo_name(SVO_NAME_NEED, SVO_NEED_PROJECTED_AREA), "projected-area");
    assert_string_equal(svo_name(SVO_NAME_NEED, SVO_NEED_NONE), "none");
    assert_string_equal(svo_i_cl_error_name(CL_INVALID_VALUE), "CL_INVALID_VALUE");
    assert_string_equal(svo_i_cl_error_name(-9999), "error");
}

static void messages_are_one_line(void **state)
{
    (void)state;
    svo_message message = {""};
    assert_int_equal(svo_i_fail(&message, SVO_INTERNAL, "a\nb\r%d", 7), SVO_INTERNAL);
    assert_string_equal(message.text, "a b 7");
    assert_int_equal(svo_i_fail(NULL, SVO_INTERNAL, "nobody reads"), SVO_INTERNAL);
    svo_i_message_set(NULL, "nobody reads");
    size_t sum = 0;
    assert_false(svo_i_add_size(SIZE_MAX, 1, &sum));
    assert_true(svo_i_add_size(SIZE_MAX - 1, 1, &sum) && sum == SIZE_MAX);
}

/* ---- devices and plans ---- */

static void devices_by_name_and_index(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_device *device = NULL;
    svo_message message = {""};
    svo_device_options options = {.struct_size = sizeof options, .device_name = "0.0"};
    assert_int_equal(svo_device_create_default(&options, &device, &message), SVO_OK);
    char *name = svo_i_copy_text(NULL, info_of_device(device).name);
    assert_non_null(name);
    assert_true(info_of_device(device).compile_ms == 0);
    svo_device_destroy(&device);
    options.device_name = name + strlen(name) / 2; /* from within the name on */
    assert_int_equal(svo_device_create_default(&options, &device, &message), SVO_OK);
    assert_string_equal(info_of_device(device).name, name);
    svo_device_destroy(&device);
    svo_i_free(name);
    assert_int_equal(svo_device_create(NULL, info_of_device(opened.device).device, NULL, &device, &message),
                     SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_device_create: context, device or out is NULL");
    assert_null(device);
}

static void a_buffer_above_the_limit_of_the_device(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    cl_mem buffer = NULL;
    const size_t bytes = (size_t)opened.device->max_allocation_bytes + 1;
    expect(&opened, svo_i_device_buffer(opened.device, "svo_build", "list", CL_MEM_READ_WRITE, bytes, &buffer),
           SVO_OUT_OF_DEVICE_MEMORY, "svo_build: buffer list needs ");
    assert_null(buffer);
}

static void indices_of_plans(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_plan *plan = plan_cube(&opened, NULL);
    svo_kernels_info kernels = {.struct_size = sizeof kernels};
    svo_left_out left_out = {.struct_size = sizeof left_out};
    svo_buffer_info buffer = {.struct_size = sizeof buffer};
    expect(&opened, svo_plan_get_kernels(plan, 1000, &kernels), SVO_INVALID_ARGUMENT,
           "svo_plan_get_kernels: index 1000 is not below ");
    expect(&opened, svo_plan_get_left_out(plan, 1001, &left_out), SVO_INVALID_ARGUMENT,
           "svo_plan_get_left_out: index 1001 is not below ");
    expect(&opened, svo_plan_get_buffer(plan, 1002, &buffer), SVO_INVALID_ARGUMENT,
           "svo_plan_get_buffer: index 1002 is not below ");
    svo_plan_destroy(&plan);
    const svo_plan_options options = {.struct_size = sizeof options, .payload_level = DEPTH + 1};
    struct scene *cube = fixture_scene("cube");
    expect(&opened, svo_plan_create(opened.device, scene_mesh(cube), DEPTH, &options, &plan), SVO_INVALID_ARGUMENT,
           "svo_plan_create: options.payload_level 5");
    scene_destroy(&cube);
    assert_null(plan);
}

static void counting_needs_the_device_of_the_front_end(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_plan *plan = plan_cube(&opened, NULL);
    svo_device *other = open_other(&opened);
    svo_frontend *frontend = NULL;
    succeed(&opened, svo_frontend_create_cl(other, &frontend));
    assert_int_equal(svo_plan_count(NULL, frontend, NULL), SVO_INVALID_ARGUMENT);
    expect(&opened, svo_plan_count(plan, frontend, opened.queue), SVO_INVALID_ARGUMENT, "svo_plan_count: ");
    svo_frontend_destroy(&frontend);
    svo_device_destroy(&other);
    svo_plan_destroy(&plan);
}

static void workspaces(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_plan *plan = plan_cube(&opened, NULL);
    svo_workspace *workspace = NULL;
    svo_tree *tree = NULL;
    expect(&opened, svo_workspace_measure(plan, opened.cl, NULL), SVO_INVALID_ARGUMENT, "info is NULL");
    expect(&opened, svo_workspace_create(plan, opened.cl, opened.queue, NULL, NULL), SVO_INVALID_ARGUMENT,
           "out is NULL");
    assert_int_equal(svo_workspace_make_tree(NULL, &tree), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_tree_finish(NULL, opened.queue, 0, NULL), SVO_INVALID_ARGUMENT);
    svo_plan_destroy(&plan);
    const svo_plan_options chunks = {.struct_size = sizeof chunks, .chunk_bytes = 16384};
    struct scene *knot = fixture_scene("knot:2000");
    succeed(&opened, svo_plan_create(opened.device, scene_mesh(knot), 6, &chunks, &plan));
    expect(&opened, svo_workspace_create(plan, opened.cl, opened.queue, NULL, &workspace), SVO_UNSUPPORTED,
           "chunks, and builds that are enqueued have one");
    scene_destroy(&knot);
    svo_plan_destroy(&plan);
    assert_null(workspace);
}

/* What no machine without a GPU decides: a renderer in hardware. */
static void rules_that_choose_a_front_end(void **state)
{
    (void)state;
    svo_device cpu = {.name = "cpu", .cpu_path = true}, gpu = {.name = "gpu"};
    const struct {
        svo_i_renderer renderer;
        const svo_device *device;
        bool prefers_cl;
        const char *reason;
    } rows[] = {
        {{"soft", true, true}, &cpu, true, "soft draws in software, OpenCL on cpu is faster"},
        {{"hard", false, false}, &gpu, true, "hard and gpu share no memory, and the list would go through the host"},
        {{"hard", false, true}, &gpu, false, "hard draws in hardware, and gpu has the list in place"},
        {{"hard", false, false}, &cpu, false, "hard draws in hardware, faster than cpu computes"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        svo_message reason = {""};
        assert_int_equal(svo_i_frontend_prefers_cl(rows[i].device, &rows[i].renderer, &reason), rows[i].prefers_cl);
        assert_string_equal(reason.text, rows[i].reason);
    }
}

/* ---- trees ---- */

static void trees_that_are_not_where_they_are_needed(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    char hash[SVO_HASH_TEXT_BYTES];
    svo_tree *tree = build_cube(&opened, NULL);
    svo_device *other = open_other(&opened);
    expect(&opened, svo_tree_hash(tree, SVO_HASH_ALL, NULL), SVO_INVALID_ARGUMENT, "svo_tree_hash: text is NULL");
    expect(&opened, svo_tree_hash(tree, SVO_HASH_ALL, hash), SVO_INVALID_ARGUMENT,
           "svo_tree_hash: the tree has no host arrays; call svo_tree_download first");
    expect(&opened, svo_tree_upload(NULL, opened.device, NULL), SVO_INVALID_ARGUMENT, "svo_tree_upload: tree is NULL");
    assert_int_equal(svo_tree_upload(tree, other, NULL), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(other), "svo_tree_upload: the tree is on "));
    succeed(&opened, svo_tree_upload(tree, opened.device, NULL)); /* where it is */
    succeed(&opened, svo_tree_download(tree, opened.queue));
    svo_tree_arrays first = {.struct_size = sizeof first}, second = {.struct_size = sizeof second};
    succeed(&opened, svo_tree_get_arrays(tree, &first));
    succeed(&opened, svo_tree_download(tree, opened.queue)); /* the second does nothing */
    succeed(&opened, svo_tree_get_arrays(tree, &second));
    assert_ptr_equal(first.child_mask, second.child_mask);
    svo_tree_destroy(&tree);
    svo_device_destroy(&other);
}

static void pictures(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    uint8_t rgba[16 * 16 * 4];
    svo_tree *tree = build_cube(&opened, NULL);
    svo_render_options options = {.struct_size = sizeof options, .width = 16, .height = 16};
    (void)svo_camera_fit(svo_tree_target(tree), 1.0F, &options.camera);
    options.view = (svo_render_view)10;
    expect(&opened,
           svo_render(svo_tree_target(tree), &options, svo_in_host(rgba), &(svo_submit){.queue = opened.queue}),
           SVO_INVALID_ARGUMENT,
           "svo_render: options.view 10 is none of a tree, which has SVO_VIEW_SHADED, NORMAL, DEPTH, STEPS, LEVEL and "
           "TRIANGLES");
    svo_tree_destroy(&tree);
    const svo_plan_options coarse = {.struct_size = sizeof coarse, .need = SVO_NEED_COLOR, .payload_level = 2};
    tree = build_cube(&opened, &coarse);
    options.view = SVO_VIEW_SHADED;
    expect(&opened,
           svo_render(svo_tree_target(tree), &options, svo_in_host(rgba), &(svo_submit){.queue = opened.queue}),
           SVO_INVALID_ARGUMENT, "svo_render: the tree has payload from level 2 on only, and pictures need all levels");
    svo_tree_destroy(&tree);
}

static void rays_that_cannot_be_traced(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_plan_options options = {.struct_size = sizeof options, .need = SVO_NEED_RAYS};
    svo_tree *tree = build_cube(&opened, &options);
    svo_ray ray = {.t_max = 1};
    svo_hit hit;
    cl_event done = NULL;
    expect(&opened,
           svo_trace_triangles(svo_tree_target(tree), svo_in_host(&ray), svo_in_host(&hit), (size_t)UINT32_MAX + 1,
                               SVO_TRACE_CLOSEST, &(svo_submit){.queue = opened.queue}),
           SVO_INVALID_ARGUMENT, "svo_trace_triangles: 4294967296 rays are above ");
    assert_int_equal(svo_trace_triangles(svo_tree_target(NULL), svo_in_buffer(NULL), svo_in_buffer(NULL), 0,
                                         SVO_TRACE_CLOSEST, &(svo_submit){.queue = opened.queue, .event = &done}),
                     SVO_INVALID_ARGUMENT);
    succeed(&opened,
            svo_trace_triangles(svo_tree_target(tree), svo_in_buffer(NULL), svo_in_buffer(NULL), 0, SVO_TRACE_CLOSEST,
                                &(svo_submit){.queue = opened.queue, .event = &done})); /* no rays */
    assert_int_equal(clWaitForEvents(1, &done), CL_SUCCESS);
    clReleaseEvent(done);
    expect(&opened, svo_kernel_set_arguments(svo_tree_target(tree), NULL, 0), SVO_INVALID_ARGUMENT,
           "svo_kernel_set_arguments: kernel is NULL");
    svo_tree_destroy(&tree);
}

/* Rays are floats; a grid this wide or far away is built and saved, but not traced. */
static void grids_beyond_the_range_of_rays(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const double edges[] = {1e-33, 1e37};
    for (size_t i = 0; i < 2; ++i) {
        const double e = edges[i];
        const double positions[9] = {0, 0, 0, e, 0, 0, 0, e, e};
        const svo_mesh mesh = {
            .struct_size = sizeof mesh, .positions_double = positions, .vertex_count = 3, .triangle_count = 1};
        const svo_plan_options options = {.struct_size = sizeof options, .need = SVO_NEED_RAYS};
        svo_plan *plan = NULL;
        svo_tree *tree = NULL;
        svo_ray ray = {.direction = {1, 0, 0}, .t_max = 1};
        svo_hit hit;
        succeed(&opened, svo_plan_create(opened.device, &mesh, DEPTH, &options, &plan));
        succeed(&opened, svo_build(plan, opened.cl, opened.queue, &tree, NULL));
        expect(&opened,
               svo_trace_triangles(svo_tree_target(tree), svo_in_host(&ray), svo_in_host(&hit), 1, SVO_TRACE_CLOSEST,
                                   &(svo_submit){.queue = opened.queue}),
               SVO_UNSUPPORTED, "is beyond the range of rays in floats");
        svo_tree_destroy(&tree);
        svo_plan_destroy(&plan);
    }
}

/* No triangle touches the caller's grid: a root without children, by both builders. */
static void grids_without_triangles(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    char hashes[2][SVO_HASH_TEXT_BYTES];
    for (int sorted = 0; sorted < 2; ++sorted) {
        const svo_plan_options options = {.struct_size = sizeof options,
                                          .need = SVO_NEED_ALL,
                                          .builder = sorted != 0 ? SVO_BUILDER_SORTED : SVO_BUILDER_CL,
                                          .origin = {5, 5, 5},
                                          .edge = 1};
        svo_tree *tree = build_cube(&opened, &options);
        svo_tree_info info = {.struct_size = sizeof info};
        succeed(&opened, svo_tree_get_info(tree, &info));
        assert_int_equal(info.leaf_count, 0);
        succeed(&opened, svo_tree_download(tree, opened.queue));
        succeed(&opened, svo_tree_hash(tree, SVO_HASH_ALL, hashes[sorted]));
        svo_tree_destroy(&tree);
    }
    assert_string_equal(hashes[0], hashes[1]);
}

#ifdef HAVE_IO
static int refuse_bytes(void *user, const void *bytes, size_t byte_count)
{
    (void)user;
    (void)bytes;
    return byte_count > 0 ? 1 : 0;
}

static void files(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_message message = {""};
    svo_tree *tree = build_cube(&opened, NULL), *loaded = NULL;
    assert_int_equal(svo_tree_save(NULL, svo_to_path("/tmp/x.svo"), NULL, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_tree_save: tree is NULL");
    assert_int_equal(svo_tree_save(tree, svo_to_callback(refuse_bytes, NULL), NULL, &message), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(message.text, "call svo_tree_download first"));
    succeed(&opened, svo_tree_download(tree, opened.queue));
    assert_int_equal(svo_tree_save(tree, svo_to_path(NULL), NULL, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_tree_save: sink.path and sink.write are NULL");
    assert_int_equal(svo_tree_save(tree, svo_to_callback(refuse_bytes, NULL), NULL, &message), SVO_FILE_ERROR);
    assert_int_equal(svo_tree_load(svo_from_memory(NULL, 4, "bytes"), NULL, &loaded, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_tree_load: source.path and source.bytes are NULL");
    assert_int_equal(svo_tree_load(svo_from_memory("x", 1, NULL), NULL, &loaded, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_tree_load: source.name is NULL");
    assert_null(loaded);
    svo_tree_destroy(&tree);
}
#endif

/* ---- OpenGL ---- */

#ifdef HAVE_GL
static void names_of_opengl(void **state)
{
    (void)state;
    assert_string_equal(svo_name(SVO_NAME_GL_CONTEXT_KIND, SVO_GL_WRAPPED), "wrapped");
    assert_string_equal(svo_name(SVO_NAME_GL_CONTEXT_KIND, SVO_GL_CONTEXT_KINDS), "unknown context kind");
    assert_string_equal(svo_name(SVO_NAME_GL_CONTEXT_KIND, (svo_gl_context_kind)77), "unknown context kind");
}

static void opengl_front_ends(void **state)
{
    const fixture *opened = fixture_of_group(state);
    svo_gl *gl = NULL;
    svo_message message = {""};
    svo_gl_options options = {.struct_size = sizeof options, .raster = (svo_gl_raster)9};
    expect(opened, svo_gl_create(opened->device, NULL, NULL, &gl), SVO_INVALID_ARGUMENT,
           "svo_gl_create: context is NULL");
    expect(opened, svo_gl_create(opened->device, opened->context, &options, &gl), SVO_INVALID_ARGUMENT,
           "svo_gl_create: options.raster 9 is not in 0 .. ");
    options = (svo_gl_options){.struct_size = sizeof options, .share = (svo_gl_share)9};
    expect(opened, svo_gl_create(opened->device, opened->context, &options, &gl), SVO_INVALID_ARGUMENT,
           "options.share 9 not in 0 .. ");
    options = (svo_gl_options){.struct_size = sizeof options, .raster = SVO_GL_RASTER_EXPAND, .hybrid_columns = 64};
    expect(opened, svo_gl_create(opened->device, opened->context, &options, &gl), SVO_INVALID_ARGUMENT,
           "svo_gl_create: options.hybrid_columns 64 is of SVO_GL_RASTER_HYBRID, and options.raster is gl-expand");
    assert_null(gl);
    svo_mesh_copy *copy = NULL;
    const svo_mesh_buffers buffers = {.struct_size = sizeof buffers};
    assert_int_equal(svo_gl_mesh_read(NULL, opened->context, 0, NULL, &copy, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_gl_mesh_read: buffers is NULL");
    assert_int_equal(svo_gl_mesh_read(&buffers, opened->context, 1, NULL, &copy, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_gl_mesh_read: num_wait and wait disagree");
    assert_null(copy);
    const svo_plan_options sorted = {.struct_size = sizeof sorted, .builder = SVO_BUILDER_SORTED};
    svo_plan *plan = plan_cube(opened, &sorted);
    svo_tree *tree = NULL;
    expect(opened, svo_gl_build(opened->gl, plan, opened->queue, &tree, NULL), SVO_INVALID_ARGUMENT,
           "svo_gl_build: the plan asks for builder sorted");
    svo_plan_destroy(&plan);
    assert_null(tree);
}
#endif

TEST_GROUP(arguments)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_of_enumerators_and_of_none),
        cmocka_unit_test(messages_are_one_line),
        cmocka_unit_test(devices_by_name_and_index),
        cmocka_unit_test(a_buffer_above_the_limit_of_the_device),
        cmocka_unit_test(indices_of_plans),
        cmocka_unit_test(counting_needs_the_device_of_the_front_end),
        cmocka_unit_test(workspaces),
        cmocka_unit_test(rules_that_choose_a_front_end),
        cmocka_unit_test(trees_that_are_not_where_they_are_needed),
        cmocka_unit_test(pictures),
        cmocka_unit_test(rays_that_cannot_be_traced),
        cmocka_unit_test(grids_beyond_the_range_of_rays),
        cmocka_unit_test(grids_without_triangles),
#ifdef HAVE_IO
        cmocka_unit_test(files),
#endif
#ifdef HAVE_GL
        cmocka_unit_test(names_of_opengl),
        cmocka_unit_test(opengl_front_ends),
#endif
    };
    return cmocka_run_group_tests_name("arguments", tests, fixture_group_setup, fixture_group_teardown);
}
