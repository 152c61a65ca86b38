/* SPDX-License-Identifier: MIT */
/*
 * Gathering as callers use it: sets of cones, single cones in a kernel of the caller's own, sealed boxes, points that
 * have no light, options, refusals; and the march as published, of tools/lab.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cone_scene.h"
#include "errors/published_march.h"
#include "support/info_of.h"
#include "support/meshes.h"
#include "support/suite.h"

#define DEPTH 7u
#define WIDTH ((size_t)1 << DEPTH)
#define CELLS (WIDTH * WIDTH * WIDTH)

/* ---- kernels of the caller's own ---- */

static cl_kernel compile(const fixture *opened, svo_light *light, const char *source)
{
    const char *sources[2] = {svo_kernel_source(svo_light_target(NULL)), source};
    const cl_device_id device = info_of_device(opened->device).device;
    cl_program program = clCreateProgramWithSource(info_of_device(opened->device).context, 2, sources, NULL, NULL);
    if (clBuildProgram(program, 1, &device, svo_kernel_options(svo_light_target(light)), NULL, NULL) != CL_SUCCESS) {
        static char log[4096];
        clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, sizeof log, log, NULL);
        fail_msg("%s", log);
        return NULL;
    }
    cl_kernel kernel = clCreateKernel(program, "probe", NULL);
    clReleaseProgram(program);
    assert_non_null(kernel);
    return kernel;
}

/* Runs a kernel whose arguments after the light's are input and output, once per record. */
static void launch(const fixture *opened, svo_light *light, const char *source, const void *input, size_t input_bytes,
                   void *output, size_t output_bytes, size_t count)
{
    const cl_context context = info_of_device(opened->device).context;
    cl_kernel kernel = compile(opened, light, source);
    cl_mem from = clCreateBuffer(context, CL_MEM_READ_ONLY, count * input_bytes, NULL, NULL);
    cl_mem to = clCreateBuffer(context, CL_MEM_WRITE_ONLY, count * output_bytes, NULL, NULL);
    assert_int_equal(clEnqueueWriteBuffer(opened->queue, from, CL_TRUE, 0, count * input_bytes, input, 0, NULL, NULL),
                     CL_SUCCESS);
    light_succeed(opened, svo_kernel_set_arguments(svo_light_target(light), kernel, 0));
    assert_int_equal(clSetKernelArg(kernel, SVO_LIGHT_ARGUMENTS, sizeof from, &from), CL_SUCCESS);
    assert_int_equal(clSetKernelArg(kernel, SVO_LIGHT_ARGUMENTS + 1, sizeof to, &to), CL_SUCCESS);
    const size_t local = 1;
    assert_int_equal(clEnqueueNDRangeKernel(opened->queue, kernel, 1, NULL, &count, &local, 0, NULL, NULL), CL_SUCCESS);
    assert_int_equal(clEnqueueReadBuffer(opened->queue, to, CL_TRUE, 0, count * output_bytes, output, 0, NULL, NULL),
                     CL_SUCCESS);
    clReleaseMemObject(from);
    clReleaseMemObject(to);
    clReleaseKernel(kernel);
}

/* ---- sets ---- */

#define SETS 5
static const uint32_t sets[SETS] = {1, 5, 6, 16, 64};

static void check_near(const char *what, uint32_t cones, double value, double expected, double bound)
{
    if (!(fabs(value - expected) <= bound)) {
        fail_msg("%s of %u cones is %g instead of %g", what, cones, value, expected);
    }
}

/* For each set and cone: direction along the normal and across it, weight, tangent. */
static void weights_hold_the_cosine(void **state)
{
    static const char source[] =
        "__kernel void probe(SVO_LIGHT_PARAMETERS, __global const uint2 *members, __global float4 *found)\n"
        "{\n"
        "    const size_t i = get_global_id(0);\n"
        "    const svo_set_cone cone = svo_cone_of_set(members[i].x, members[i].y, SVO_SET_FIXED);\n"
        "    const svo_frame frame = svo_make_frame(normalize((float3)(1.0f, -2.0f, 3.0f)));\n"
        "    const float3 turned = svo_from_frame(&frame, cone.direction);\n"
        "    found[i] = (float4)(dot(turned, frame.normal), length(turned), cone.weight, cone.tangent);\n"
        "}\n";
    const fixture opened = fixture_cl_of_group(state);
    static const double middle[3] = {0, 0, 0};
    cone_scene *scene = cone_scene_new(DEPTH, 1);
    cone_scene_add_disk(scene, middle, 8);
    svo_tree *tree = cone_scene_build(&opened, scene, SVO_NEED_NORMAL);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
    for (int set = 0; set < SETS; ++set) {
        const uint32_t cones = sets[set];
        uint32_t members[128];
        float found[256];
        double weight = 0;
        double cosine = 0;
        for (uint32_t k = 0; k < cones; ++k) {
            members[2 * k] = k;
            members[2 * k + 1] = cones;
        }
        launch(&opened, light, source, members, 8, found, 16, cones);
        for (uint32_t k = 0; k < cones; ++k) {
            check_near("a direction", cones, found[4 * k + 1], 1, 1e-5);
            weight += found[4 * k + 2];
            cosine += (double)found[4 * k + 2] * found[4 * k];
        }
        check_near("the weight", cones, weight, 1, 1e-5);
        /* Of an even spread by cosine: 2 / 3. */
        if (cones >= 16) {
            check_near("the mean cosine", cones, cosine, 2.0 / 3, 2e-3);
            check_near("sin q", cones, sin(atan((double)found[3])), 1 / sqrt(cones), 1e-5);
        }
    }
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

/* ---- single cones ---- */

typedef struct probe_cone {
    float origin[3], tangent;
    float direction[3], range;
    float falloff, start, reserved[2];
} probe_cone;

typedef struct probe_result {
    float occlusion, pass, red;
    uint32_t steps;
} probe_result;

static const char cone_source[] =
    "typedef struct probe_cone {\n"
    "    float origin[3], tangent, direction[3], range, falloff, start, reserved[2];\n"
    "} probe_cone;\n"
    "__kernel void probe(SVO_LIGHT_PARAMETERS, __global const probe_cone *cones, __global float4 *found)\n"
    "{\n"
    "    SVO_LIGHT_MAKE(light);\n"
    "    const size_t i = get_global_id(0);\n"
    "    svo_cone cone;\n"
    "    cone.origin = vload3(0, cones[i].origin);\n"
    "    cone.direction = vload3(0, cones[i].direction);\n"
    "    cone.normal = (float3)(0.0f);\n"
    "    cone.tangent = cones[i].tangent;\n"
    "    cone.start = cones[i].start;\n"
    "    cone.range = cones[i].range;\n"
    "    cone.step = 0.5f;\n"
    "    cone.falloff = cones[i].falloff;\n"
    "    const svo_cone_result met = svo_trace_cone(&light, &cone);\n"
    "    found[i] = (float4)(met.occlusion, met.pass, met.radiance.x, as_float(met.steps));\n"
    "}\n";

/* A box of the voxels low .. high along each axis, closed, one voxel thick. Its grid's edge is what voxel lists have:
   voxels are a unit wide. */
static svo_tree *make_box(const fixture *opened, size_t low, size_t high)
{
    uint8_t *alphas = calloc(CELLS, 1);
    assert_non_null(alphas);
    for (size_t k = 0; k < CELLS; ++k) {
        const size_t at[3] = {k % WIDTH, k / WIDTH % WIDTH, k / WIDTH / WIDTH};
        bool inside = true;
        bool on_wall = false;
        for (int axis = 0; axis < 3; ++axis) {
            inside = inside && at[axis] >= low && at[axis] <= high;
            on_wall = on_wall || at[axis] == low || at[axis] == high;
        }
        alphas[k] = inside && on_wall ? 255 : 0;
    }
    svo_tree *tree = light_tree_of(opened, DEPTH, alphas);
    free(alphas);
    return tree;
}

/* What passes the walls of sealed boxes, from the middle in all directions. */
static double leak_of_boxes(const fixture *opened, svo_light_form form, double degrees)
{
    enum { CONES = 400 };
    static const size_t boxes[][2] = {{32, 95}, {41, 88}, {37, 100}, {50, 83}};
    static probe_cone cones[CONES];
    static probe_result found[CONES];
    const size_t box_count = sizeof boxes / sizeof boxes[0];
    double sum = 0;
    for (size_t box = 0; box < box_count; ++box) {
        svo_tree *tree = make_box(opened, boxes[box][0], boxes[box][1]);
        svo_light *light = light_of(opened, tree, form);
        const float middle = 0.5F * (float)(boxes[box][0] + boxes[box][1] + 1);
        for (int i = 0; i < CONES; ++i) {
            const double z = 2 * (i + 0.5) / CONES - 1;
            const double turn = 2.39996 * i;
            cones[i] = (probe_cone){
                .origin = {middle, middle, middle},
                .tangent = (float)tan(degrees * 3.14159265358979 / 180),
                .direction = {(float)(sqrt(1 - z * z) * cos(turn)), (float)(sqrt(1 - z * z) * sin(turn)), (float)z}};
        }
        launch(opened, light, cone_source, cones, sizeof cones[0], found, sizeof found[0], CONES);
        for (int i = 0; i < CONES; ++i) {
            sum += (double)found[i].pass / (CONES * (double)box_count);
        }
        svo_light_destroy(&light);
        svo_tree_destroy(&tree);
    }
    print_message("sealed boxes, %s, half-angle %g degrees: %.4f\n", svo_name(SVO_NAME_LIGHT_FORM, form), degrees, sum);
    return sum;
}

static void sealed_boxes_are_tight(void **state)
{
    static const struct {
        double degrees, limit;
    } rows[] = {{2, 0.01}, {8, 0.01}, {15, 0.01}, {30, 0.05}};
    const fixture opened = fixture_cl_of_group(state);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        const double leak = leak_of_boxes(&opened, SVO_LIGHT_FACES, rows[i].degrees);
        if (!(leak <= rows[i].limit)) {
            fail_msg("sealed boxes let %.4f through at %g degrees", leak, rows[i].degrees);
        }
    }
    /* Without direction a wall of one voxel is thin to wide cones: that is what faces are for. */
    assert_true(leak_of_boxes(&opened, SVO_LIGHT_VOXELS, 15) > 0.3);
}

/* A level L without direction lets 1 - 2^-L through a wall of one voxel. */
static void a_mean_over_cubes_is_not_tight(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_tree *tree = make_box(&opened, 0, WIDTH - 1);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_VOXELS);
    for (uint32_t up = 0; up < DEPTH - 1; ++up) {
        light_probe probe = {.position = {64.5F, 64.5F, 0.5F}, .level = DEPTH - up, .direction = {0, 0, 1}};
        light_sample sample;
        light_probe_field(&opened, light, &probe, &sample, 1);
        check_near("1 - opacity", up, 1 - (double)sample.opacity, 1 - ldexp(1, -(int)up), 1e-4);
    }
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
}

/* A wall in front of narrow cones: where it counts with falloff, and beyond a range not at all. */
static void falloff_and_range_are_distances(void **state)
{
    enum { CONES = 4 };
    const fixture opened = fixture_cl_of_group(state);
    cone_scene *scene = cone_scene_new(DEPTH, 2);
    const double o[3] = {20.5, -40, -40};
    const double u[3] = {0, 80, 0};
    const double v[3] = {0, 0, 80};
    cone_scene_add_quad(scene, o, u, v); /* at x = 84.5 */
    svo_tree *tree = cone_scene_build(&opened, scene, SVO_NEED_NORMAL | SVO_NEED_PROJECTED_AREA);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
    probe_cone cones[CONES];
    probe_result found[CONES];
    for (int i = 0; i < CONES; ++i) {
        cones[i] = (probe_cone){.origin = {44, 64, 64}, .tangent = 0.02F, .direction = {1, 0, 0}};
    }
    cones[1].falloff = 0.1F;
    cones[2].range = 30;
    cones[3].direction[0] = -1;
    launch(&opened, light, cone_source, cones, sizeof cones[0], found, sizeof found[0], CONES);
    check_near("occlusion", 1, found[0].occlusion, 1, 1e-6);
    check_near("occlusion with falloff", 1, found[1].occlusion, 1 / (1 + 0.1 * 40.5), 5e-3);
    check_near("occlusion within a range", 1, found[2].occlusion, 0, 1e-6);
    check_near("occlusion backwards", 1, found[3].occlusion, 0, 1e-6);
    print_message("%u steps through 44 empty voxels\n", found[3].steps);
    assert_true(found[3].steps < 22); /* empty space is skipped */
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

/* ---- points ---- */

/* A room with points on its floor and in its middle, and its tree. */
static svo_tree *open_room(const fixture *opened, cone_scene **scene)
{
    static const double half[3] = {40, 40, 40};
    static const double up[3] = {0, 0, 1};
    *scene = cone_scene_new(DEPTH, 3);
    cone_scene_pose(*scene, true, 2);
    cone_scene_add_room(*scene, half);
    for (int k = 0; k < 130; ++k) {
        const double at[3] = {60 * random_unit(&(*scene)->seed) - 30, 60 * random_unit(&(*scene)->seed) - 30, -40};
        cone_scene_add_point(*scene, at, up, 0);
        (*scene)->points[k].reflected[k % 3] = 2;
        (*scene)->points[k].exponent = (float)(k % 40);
    }
    return cone_scene_build(opened, *scene, SVO_NEED_NORMAL | SVO_NEED_PROJECTED_AREA);
}

static void points_without_light(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    cone_scene *scene;
    svo_tree *tree = open_room(&opened, &scene);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
    scene->points[0].position[1] = -1;
    scene->points[1].position[2] = NAN;
    memset(scene->points[2].normal, 0, sizeof scene->points[2].normal);
    scene->points[3].normal[0] = INFINITY;
    cone_scene_gather(&opened, scene, light, NULL);
    for (int i = 0; i < 4; ++i) {
        static const svo_gather_result open = {.openness = 1};
        assert_memory_equal(&scene->results[i], &open, sizeof open);
    }
    assert_true(scene->results[4].openness < 0.2F);
    /* On a face of the grid, but for rounding. */
    scene->points[5].position[1] = -0.001F;
    cone_scene_gather(&opened, scene, light, NULL);
    assert_true(scene->results[5].steps > 0);
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

/* The same by a batch of buffers and in a kernel of the caller's own. */
static void batches_and_own_kernels_agree(void **state)
{
    static const char source[] =
        "__kernel void probe(SVO_LIGHT_PARAMETERS, __global const svo_gather_point *points,\n"
        "                    __global svo_gather_result *results)\n"
        "{\n"
        "    SVO_LIGHT_MAKE(light);\n"
        "    const svo_gather_point point = points[get_global_id(0)];\n"
        "    results[get_global_id(0)] = svo_gather(&light, &point, 6u, 0.75f, 50.0f, 0.01f);\n"
        "}\n";
    const fixture opened = fixture_cl_of_group(state);
    cone_scene *scene;
    svo_tree *tree = open_room(&opened, &scene);
    for (int form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
        svo_light *light = light_of(&opened, tree, (svo_light_form)form);
        svo_gather_result own[130];
        svo_gather_options options = SVO_GATHER_OPTIONS_INIT;
        options.cones = 6;
        options.step = 0.75F;
        options.range = 50;
        options.falloff = 0.01F;
        cone_scene_gather(&opened, scene, light, &options);
        launch(&opened, light, source, scene->points, sizeof scene->points[0], own, sizeof own[0], 130);
        for (int i = 0; i < 130; ++i) {
            check_near("openness", (uint32_t)i, own[i].openness, scene->results[i].openness, 1e-5);
            assert_int_equal(own[i].steps, scene->results[i].steps);
        }
        svo_light_destroy(&light);
    }
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

/* Nothing in the way of the sky. */
static void the_sky_is_seen(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    cone_scene *scene = cone_scene_new(DEPTH, 4);
    static const double far_off[3] = {0, 0, -50};
    static const double here[3] = {3, 4, 20};
    static const double up[3] = {0, 0, 1};
    cone_scene_add_disk(scene, far_off, 5);
    cone_scene_add_point(scene, here, up, 1);
    scene->points[0].reflected[0] = 1;
    svo_tree *tree = cone_scene_build(&opened, scene, SVO_NEED_NORMAL | SVO_NEED_PROJECTED_AREA);
    for (int form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
        svo_light *light = light_of(&opened, tree, (svo_light_form)form);
        svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
        svo_gather_options options = SVO_GATHER_OPTIONS_INIT;
        options.method = SVO_GATHER_CONES;
        setup.sky[0] = 3;
        setup.sky[2] = 0.5F;
        light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
        cone_scene_gather(&opened, scene, light, &options);
        check_near("red", 16, scene->results[0].irradiance[0], 3 * 3.14159265358979, 1e-4);
        check_near("green", 16, scene->results[0].irradiance[1], 0, 0);
        check_near("blue", 16, scene->results[0].irradiance[2], 0.5 * 3.14159265358979, 1e-5);
        check_near("specular red", 1, scene->results[0].specular[0], 3, 1e-5);
        options.range = 10; /* not as far as the sky */
        cone_scene_gather(&opened, scene, light, &options);
        check_near("red within a range", 16, scene->results[0].irradiance[0], 0, 0);
        options.range = 0;
        options.no_light = 1;
        cone_scene_gather(&opened, scene, light, &options);
        check_near("red without light", 16, scene->results[0].irradiance[0], 0, 0);
        check_near("specular without light", 1, scene->results[0].specular[0], 0, 0);
        svo_light_destroy(&light);
    }
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

/* The march as published: light leaks from a closed room, which is why it is not the default. */
static void the_published_march_leaks(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    cone_scene *scene;
    svo_tree *tree = open_room(&opened, &scene);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_BRICKS);
    published_march made;
    assert_true(published_march_make(opened.device, light, scene->point_count, opened.queue, &made));
    assert_true(published_march_gather(&made, scene->points, scene->results, 0, true));
    double mean = 0;
    for (int i = 0; i < 130; ++i) {
        assert_true(scene->results[i].openness >= 0 && scene->results[i].openness <= 1);
        assert_true(scene->results[i].steps > 0 && scene->results[i].steps < 6 * 3 * WIDTH);
        mean += (double)scene->results[i].openness / 130;
    }
    print_message("published march in a closed room: openness %.3f\n", mean);
    assert_true(mean > 0.1);
    published_march_free(&made);
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

/* ---- refusals ---- */

static void expect_refusal(const fixture *opened, svo_light *light, const svo_gather_options *options, const char *text)
{
    svo_gather_point point = {.normal = {0, 0, 1}};
    svo_gather_result result;
    assert_int_equal(
        svo_gather(light, svo_in_host(&point), svo_in_host(&result), 1, options, &(svo_submit){.queue = opened->queue}),
        SVO_INVALID_ARGUMENT);
    assert_string_equal(svo_device_message(opened->device), text);
}

static void wrong_options_are_refused(void **state)
{
    static const struct {
        svo_gather_options options;
        const char *text;
    } rows[] = {
        {{.cones = 7}, "svo_gather: options.cones 7 is not 1, 5, 6, 16 or 64"},
        {{.step = 0.125F}, "svo_gather: options.step 0.125 is not in 0.25 .. 1"},
        {{.step = 2}, "svo_gather: options.step 2 is not in 0.25 .. 1"},
        {{.range = -1}, "svo_gather: options.range -1 is negative or not finite"},
        {{.range = INFINITY}, "svo_gather: options.range inf is negative or not finite"},
        {{.falloff = -0.5F}, "svo_gather: options.falloff -0.5 is negative or not finite"},
        {{.paths = 48}, "svo_gather: options.paths 48 is no power of two in 16 .. 65536"},
        {{.paths = 8}, "svo_gather: options.paths 8 is no power of two in 16 .. 65536"},
        {{.paths = 131072}, "svo_gather: options.paths 131072 is no power of two in 16 .. 65536"},
        {{.bounces = 65}, "svo_gather: options.bounces 65 is above 64"},
        {{.error = -1}, "svo_gather: options.error -1 is negative or not finite"},
        {{.method = SVO_GATHER_METHOD_COUNT}, "svo_gather: options.method 3 is not in 0 .. 2"},
        {{.method = SVO_GATHER_CONES, .paths = 64},
         "svo_gather: options names both cones (cones 0, step 0) and rays (paths 64, bounces 0, error 0)"},
        {{.method = SVO_GATHER_RAYS, .cones = 16},
         "svo_gather: options names both cones (cones 16, step 0) and rays (paths 0, bounces 0, error 0)"},
        {{.step = 0.5F, .bounces = 2},
         "svo_gather: options names both cones (cones 0, step 0.5) and rays (paths 0, bounces 2, error 0)"},
    };
    const fixture opened = fixture_cl_of_group(state);
    cone_scene *scene;
    svo_tree *tree = open_room(&opened, &scene);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        svo_gather_options options = rows[i].options;
        options.struct_size = sizeof options;
        expect_refusal(&opened, light, &options, rows[i].text);
    }
    assert_int_equal(svo_gather(NULL, svo_in_host(NULL), svo_in_host(NULL), 0, NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(
        svo_gather(light, svo_in_host(NULL), svo_in_host(NULL), 1, NULL, &(svo_submit){.queue = opened.queue}),
        SVO_INVALID_ARGUMENT);
    assert_string_equal(svo_device_message(opened.device), "svo_gather: points is NULL");
    light_succeed(&opened, svo_gather(light, svo_in_host(NULL), svo_in_host(NULL), 0, NULL,
                                      &(svo_submit){.queue = opened.queue}));
    cl_event event = NULL;
    light_succeed(&opened, svo_gather(light, svo_in_buffer(NULL), svo_in_buffer(NULL), 0, NULL,
                                      &(svo_submit){.queue = opened.queue, .event = &event}));
    assert_int_equal(clWaitForEvents(1, &event), CL_SUCCESS);
    clReleaseEvent(event);
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

TEST_GROUP(gather)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(weights_hold_the_cosine),
        cmocka_unit_test(sealed_boxes_are_tight),
        cmocka_unit_test(a_mean_over_cubes_is_not_tight),
        cmocka_unit_test(falloff_and_range_are_distances),
        cmocka_unit_test(points_without_light),
        cmocka_unit_test(batches_and_own_kernels_agree),
        cmocka_unit_test(the_sky_is_seen),
        cmocka_unit_test(the_published_march_leaks),
        cmocka_unit_test(wrong_options_are_refused),
    };
    return cmocka_run_group_tests_name("gather", tests, fixture_group_setup, fixture_group_teardown);
}
