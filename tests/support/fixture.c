/* SPDX-License-Identifier: MIT */
/* Opens a device and front ends, and builds with them. */
#define _POSIX_C_SOURCE 200809L
#include "fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "plan/plan_data.h"
#include "scenes.h"
#include "support/info_of.h"

void fixture_skip(fixture *opened, const char *reason)
{
    print_message("skipped: %s\n", reason);
    fixture_close(opened);
    skip();
}

/* Tests of stages with two paths run a second time for the other one. */
svo_path fixture_path(void)
{
    const char *name = getenv("SVOCL_TEST_PATH");
    if (name == NULL) {
        return SVO_PATH_AUTO;
    }
    const bool for_gpu = strcmp(name, svo_name(SVO_NAME_PATH, SVO_PATH_GPU)) == 0;
    if (!for_gpu && strcmp(name, svo_name(SVO_NAME_PATH, SVO_PATH_CPU)) != 0) {
        fail_msg("SVOCL_TEST_PATH is '%s', neither cpu nor gpu", name);
    }
    return for_gpu ? SVO_PATH_GPU : SVO_PATH_CPU;
}

/* Keeps the first context until the process ends. PoCL 3.1 forgets its library of built-in functions with the last
   context of a process, and takes .6 s to read it for the next one that compiles. */
static void keep_context(cl_context context)
{
    static cl_context kept;
    if (kept == NULL && clRetainContext(context) == CL_SUCCESS) {
        kept = context;
    }
}

static void open_device(const fixture_options *options, fixture *out)
{
    svo_message message = {""};
    const svo_device_options device_options = {.struct_size = sizeof device_options,
                                               .path = options->path != SVO_PATH_AUTO ? options->path : fixture_path()};
    const svo_status status = svo_device_create_default(&device_options, &out->device, &message);
    if (status == SVO_NO_DEVICE) {
        fixture_skip(out, message.text);
    }
    if (status != SVO_OK) {
        fail_msg("%s", message.text);
    }
    keep_context(info_of_device(out->device).context);
    cl_int error = CL_SUCCESS;
    out->queue = clCreateCommandQueue(info_of_device(out->device).context, info_of_device(out->device).device,
                                      options->queue_properties, &error);
    if (error == CL_INVALID_QUEUE_PROPERTIES) {
        fixture_skip(out, "the device has no queues with these properties");
    }
    assert_int_equal(error, CL_SUCCESS);
}

void fixture_open_cl(const fixture_options *options, fixture *out)
{
    *out = (fixture){0};
    open_device(options, out);
    if (svo_frontend_create_cl(out->device, &out->cl) != SVO_OK) {
        fail_msg("%s", svo_device_message(out->device));
    }
    out->frontend = out->cl;
}

void fixture_close(fixture *opened)
{
    fixture_close_gl(opened);
    svo_frontend_destroy(&opened->cl);
    if (opened->queue != NULL) {
        clReleaseCommandQueue(opened->queue);
    }
    svo_device_destroy(&opened->device);
    *opened = (fixture){0};
}

int fixture_group_setup(void **state)
{
    *state = calloc(1, sizeof(fixture));
    return *state != NULL ? 0 : -1;
}

int fixture_group_teardown(void **state)
{
    fixture_close(*state);
    free(*state);
    return 0;
}

int fixture_group_setup_unoptimized(void **state)
{
    const int failed = setenv("POCL_EXTRA_BUILD_FLAGS", "-cl-opt-disable", 1);
    return failed != 0 ? failed : fixture_group_setup(state);
}

int fixture_group_teardown_unoptimized(void **state)
{
    const int failed = fixture_group_teardown(state);
    return unsetenv("POCL_EXTRA_BUILD_FLAGS") != 0 ? -1 : failed;
}

fixture *fixture_of_group(void **state)
{
    fixture *opened = *state;
    if (opened->gl == NULL) {
        fixture_close(opened);
        fixture_open(&(fixture_options){.queue_properties = CL_QUEUE_PROFILING_ENABLE}, opened);
    }
    return opened;
}

bool fixture_has_pair_lanes(const fixture *opened)
{
    const svo_plan_options options = {.struct_size = sizeof options, .need = SVO_NEED_NORMAL};
    svo_plan *plan = NULL;
    scene *cube = fixture_scene("cube");
    assert_int_equal(svo_plan_create(opened->device, scene_mesh(cube), 1, &options, &plan), SVO_OK);
    const bool lanes = plan->work.pair_lanes;
    svo_plan_destroy(&plan);
    scene_destroy(&cube);
    return lanes;
}

scene *fixture_scene(const char *spec)
{
    svo_message message = {""};
    scene *made = NULL;
    if (scene_create(spec, &made, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return made;
}

fixture fixture_cl_of_group(void **state)
{
    fixture *opened = *state;
    if (opened->device == NULL) {
        fixture_open_cl(&(fixture_options){.queue_properties = CL_QUEUE_PROFILING_ENABLE}, opened);
    }
    fixture by_cl = *opened;
    by_cl.frontend = opened->cl;
    return by_cl;
}

/* The plan's buffers in their current state. */
static void list_buffers(const svo_plan *plan, built *out)
{
    out->buffer_count = info_of_plan(plan).buffer_count;
    assert_in_range(out->buffer_count, 1, FIXTURE_BUFFERS_MAX);
    for (size_t i = 0; i < out->buffer_count; ++i) {
        out->buffers[i] = (svo_buffer_info)SVO_BUFFER_INFO_INIT;
        svo_plan_get_buffer(plan, i, &out->buffers[i]);
    }
}

void fixture_build_by(const fixture *opened, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options,
                      fixture_builder *by, built *out)
{
    svo_plan_options sized = options != NULL ? *options : (svo_plan_options){0};
    sized.struct_size = sizeof sized;
    *out = (built){.report = {.struct_size = sizeof out->report}};
    svo_plan *plan = NULL;
    svo_status status = svo_plan_create(opened->device, mesh, depth, &sized, &plan);
    if (status == SVO_OK) {
        status = by(opened, plan, &out->tree, &out->report);
    }
    if (status == SVO_OK) {
        status = svo_tree_download(out->tree, opened->queue);
    }
    if (status == SVO_OK) {
        status = svo_tree_hash(out->tree, SVO_HASH_ALL, out->hash);
    }
    if (status == SVO_OK) {
        status = svo_tree_hash(out->tree, SVO_HASH_NODES, out->nodes_hash);
    }
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), svo_device_message(opened->device));
    }
    out->plan = (svo_plan_info)SVO_PLAN_INFO_INIT;
    svo_plan_get_info(plan, &out->plan);
    out->weight_log2 = plan->weight_log2;
    list_buffers(plan, out);
    svo_plan_destroy(&plan);
    out->info = (svo_tree_info)SVO_TREE_INFO_INIT;
    svo_tree_get_info(out->tree, &out->info);
    out->arrays = (svo_tree_arrays)SVO_TREE_ARRAYS_INIT;
    svo_tree_get_arrays(out->tree, &out->arrays);
}

static svo_status by_frontend(const fixture *opened, svo_plan *plan, svo_tree **out, svo_build_report *report)
{
    return svo_build(plan, opened->frontend, opened->queue, out, report);
}

void fixture_build(const fixture *opened, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options,
                   built *out)
{
    fixture_build_by(opened, mesh, depth, options, by_frontend, out);
}

void built_destroy(built *finished)
{
    svo_tree_destroy(&finished->tree);
    *finished = (built){0};
}

cl_kernel fixture_tree_kernel(cl_context context, cl_device_id device)
{
    char source[512];
    const char *text = source;
    (void)snprintf(source, sizeof source,
                   "typedef struct { float words[%zu]; } params;\n"
                   "__kernel void plain(__global uchar *a, __global uint *b, __global uint *c, __global int4 *d,\n"
                   "                    params e)\n"
                   "{\n"
                   "    b[0] = a[0] + c[0] + d[0].x + (uint)e.words[0];\n"
                   "}\n",
                   sizeof(svo_ray_params) / sizeof(float));
    cl_program program = clCreateProgramWithSource(context, 1, &text, NULL, NULL);
    assert_int_equal(clBuildProgram(program, 1, &device, "-cl-std=CL1.2", NULL, NULL), CL_SUCCESS);
    cl_kernel kernel = clCreateKernel(program, "plain", NULL);
    clReleaseProgram(program);
    assert_non_null(kernel);
    return kernel;
}
