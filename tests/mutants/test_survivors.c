/* SPDX-License-Identifier: MIT */
/*
 * Mistakes that no test of their rooms found when they were planted, and that the pins of tests/golden cannot find:
 * each has its test here, against a closed form.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "core/tree.h"
#include "core/work.h"
#include "io/file_format.h"
#include "light/light_fixture.h"
#include "support/info_of.h"
#include "support/suite.h"
#include "svocl/voxels.h"

/* ---- scratch ---- */

/* What is released early makes room for what comes later. */
static void peak_scratch_bytes_are_those_at_one_time(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_i_device_work work;
    cl_mem buffers[3] = {NULL};
    light_succeed(&opened, svo_i_work_begin(opened.device, "test", opened.queue, &work));
    light_succeed(&opened, svo_i_work_alloc(&work, "first", 1000, &buffers[0]));
    light_succeed(&opened, svo_i_work_alloc(&work, "second", 300, &buffers[1]));
    assert_int_equal(work.peak_bytes, 1300);
    svo_i_work_free(&work, &buffers[0]);
    assert_null(buffers[0]);
    assert_int_equal(work.live_bytes, 300);
    light_succeed(&opened, svo_i_work_alloc(&work, "third", 900, &buffers[2]));
    assert_int_equal(work.live_bytes, 1200);
    assert_int_equal(work.peak_bytes, 1300);
    svo_i_work_end(&work);
}

/* ---- files ---- */

/* A level has a node more than the masks above it say. */
static void levels_end_where_the_masks_above_say(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    uint8_t alphas[64];
    svo_message message = {""};
    memset(alphas, 255, sizeof alphas);
    svo_tree *tree = light_tree_of(&opened, 2, alphas);
    assert_int_equal(svo_i_file_check_structure(tree, "whole", &message), SVO_OK);
    uint8_t *masks = tree->host[SVO_TREE_CHILD_MASK];
    assert_int_equal(masks[8], 255); /* the last node above the leaves */
    masks[8] = 127;
    assert_int_equal(svo_i_file_check_structure(tree, "short", &message), SVO_FILE_DAMAGED);
    assert_string_equal(message.text, "short: level 2 ends at node 73, the masks above say 72");
    svo_tree_destroy(&tree);
}

/* ---- cones ---- */

#define DEPTH 5u
#define WIDTH ((size_t)1 << DEPTH)
#define CONES 4

static const char cone_kernel[] =
    "__kernel void probe(SVO_LIGHT_PARAMETERS, __global const float *starts, __global float *passes)\n"
    "{\n"
    "    SVO_LIGHT_MAKE(light);\n"
    "    const uint i = (uint)get_global_id(0);\n"
    "    svo_cone cone;\n"
    "    cone.origin = (float3)(4.0f, 4.0f, 0.0f);\n"
    "    cone.direction = (float3)(0.0f, 0.0f, 1.0f);\n"
    "    cone.normal = (float3)(0.0f);\n"
    "    cone.tangent = 0.02f;\n"
    "    cone.start = starts[i];\n"
    "    cone.range = 0.0f;\n"
    "    cone.step = 0.5f;\n"
    "    cone.falloff = 0.0f;\n"
    "    passes[i] = svo_trace_cone(&light, &cone).pass;\n"
    "}\n";

static cl_kernel compile(const fixture *opened, svo_light *light)
{
    const char *sources[2] = {svo_kernel_source(svo_light_target(NULL)), cone_kernel};
    const cl_device_id device = info_of_device(opened->device).device;
    cl_program program = clCreateProgramWithSource(info_of_device(opened->device).context, 2, sources, NULL, NULL);
    assert_int_equal(clBuildProgram(program, 1, &device, svo_kernel_options(svo_light_target(light)), NULL, NULL),
                     CL_SUCCESS);
    cl_kernel kernel = clCreateKernel(program, "probe", NULL);
    clReleaseProgram(program);
    assert_non_null(kernel);
    return kernel;
}

static void trace_cones(const fixture *opened, svo_light *light, const float starts[CONES], float passes[CONES])
{
    const cl_context context = info_of_device(opened->device).context;
    const size_t bytes = CONES * sizeof(float), count = CONES, local = 1;
    cl_kernel kernel = compile(opened, light);
    cl_mem from = clCreateBuffer(context, CL_MEM_READ_WRITE, bytes, NULL, NULL);
    cl_mem to = clCreateBuffer(context, CL_MEM_READ_WRITE, bytes, NULL, NULL);
    assert_true(from != NULL && to != NULL);
    assert_int_equal(clEnqueueWriteBuffer(opened->queue, from, CL_TRUE, 0, bytes, starts, 0, NULL, NULL), CL_SUCCESS);
    light_succeed(opened, svo_kernel_set_arguments(svo_light_target(light), kernel, 0));
    assert_int_equal(clSetKernelArg(kernel, SVO_LIGHT_ARGUMENTS, sizeof from, &from), CL_SUCCESS);
    assert_int_equal(clSetKernelArg(kernel, SVO_LIGHT_ARGUMENTS + 1, sizeof to, &to), CL_SUCCESS);
    assert_int_equal(clEnqueueNDRangeKernel(opened->queue, kernel, 1, NULL, &count, &local, 0, NULL, NULL), CL_SUCCESS);
    assert_int_equal(clEnqueueReadBuffer(opened->queue, to, CL_TRUE, 0, bytes, passes, 0, NULL, NULL), CL_SUCCESS);
    clReleaseMemObject(to);
    clReleaseMemObject(from);
    clReleaseKernel(kernel);
}

/* A wall of 4 voxels, 8 to 12 deep, in voxels a quarter wide: in the world, from 2 to 3. The cone begins 0 deep. */
static void cones_start_at_a_distance_in_the_world(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const float starts[CONES] = {0.0F, 1.0F, 4.0F, 6.0F};
    float passes[CONES];
    svo_voxel *voxels = calloc(WIDTH * WIDTH * 4 + 2, sizeof *voxels);
    svo_voxels_source source = SVO_VOXELS_SOURCE_INIT;
    svo_voxels *list = NULL;
    svo_tree *tree = NULL;
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    assert_non_null(voxels);
    for (size_t k = 0; k < WIDTH * WIDTH * 4; ++k) {
        voxels[source.voxel_count++] = (svo_voxel){.x = (int32_t)(k % WIDTH),
                                                   .y = (int32_t)(k / WIDTH % WIDTH),
                                                   .z = 8 + (int32_t)(k / WIDTH / WIDTH),
                                                   .rgba = {255, 255, 255, 255}};
    }
    voxels[source.voxel_count++] = (svo_voxel){.rgba = {255, 255, 255, 255}}; /* the grid begins with it */
    source.voxels = voxels;
    source.voxel_edge = 0.25;
    options.need = SVO_NEED_COLOR;
    assert_int_equal(svo_voxels_create(&source, &list, NULL), SVO_OK);
    light_succeed(&opened, svo_voxels_build(opened.device, list, DEPTH, &options, opened.queue, &tree, NULL));
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_VOXELS);
    trace_cones(&opened, light, starts, passes);
    assert_true(passes[0] < 0.01F && passes[1] < 0.01F); /* the wall is before it */
    assert_true(passes[2] > 0.99F && passes[3] > 0.99F); /* behind it */
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    svo_voxels_destroy(&list);
    free(voxels);
}

TEST_GROUP(survivors)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(peak_scratch_bytes_are_those_at_one_time),
        cmocka_unit_test(levels_end_where_the_masks_above_say),
        cmocka_unit_test(cones_start_at_a_distance_in_the_world),
    };
    return cmocka_run_group_tests_name("survivors", tests, fixture_group_setup, fixture_group_teardown);
}
