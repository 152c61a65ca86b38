/* SPDX-License-Identifier: MIT */
/* Scenarios of test_faults: the device, plans, builds, rays; and the steps that all scenarios share. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "core/device.h"
#include "faults_scenario.h"
#include "support/info_of.h"

faults_world world;

/*
 * Small steps of scenarios.
 */

void digest(subject *of, const void *bytes, size_t byte_count)
{
    of->digest = XXH3_64bits_withSeed(bytes, byte_count, of->digest);
}

/* Takes the message of the device's handle. */
svo_status told(subject *of, const svo_device *device, svo_status status)
{
    if (status != SVO_OK) {
        (void)snprintf(of->message.text, sizeof of->message.text, "%s", svo_device_message(device));
    }
    return status;
}

const svo_plan_options everything = {.struct_size = sizeof everything, .need = SVO_NEED_ALL};

void prepare_plan_by(subject *of, const svo_plan_options *options)
{
    if (svo_plan_create(world.device, &world.mesh.mesh, DEPTH, options, &of->plan) != SVO_OK) {
        fail_msg("%s", svo_device_message(world.device));
    }
}

void prepare_plan(subject *of)
{
    prepare_plan_by(of, &everything);
}

void prepare_tree(subject *of)
{
    prepare_plan(of);
    if (svo_build(of->plan, world.cl, world.queue, &of->tree, NULL) != SVO_OK) {
        fail_msg("%s", svo_device_message(world.device));
    }
}

void prepare_nothing(subject *of)
{
    (void)of;
}

void destroy_all(subject *of)
{
    svo_tree_destroy(&of->tree);
    svo_workspace_destroy(&of->workspace);
    svo_plan_destroy(&of->plan);
    svo_gl_destroy(&of->gl);
    svo_device_destroy(&of->device);
}

cl_kernel make_kernel(svo_target target, const char *text)
{
    const char *sources[] = {svo_kernel_source(target), text};
    cl_program program = clCreateProgramWithSource(info_of_device(world.device).context, 2, sources, NULL, NULL);
    assert_int_equal(clBuildProgram(program, 0, NULL, svo_kernel_options(target), NULL, NULL), CL_SUCCESS);
    cl_kernel kernel = clCreateKernel(program, "empty", NULL);
    clReleaseProgram(program);
    assert_non_null(kernel);
    return kernel;
}

void release_event(cl_event *event)
{
    faults_spare(true);
    assert_int_equal(clReleaseEvent(*event), CL_SUCCESS);
    faults_spare(false);
    *event = NULL;
}

/* Downloads the tree and adds its hash to the digest. */
svo_status digest_tree(subject *of, svo_tree *tree)
{
    char hash[SVO_HASH_TEXT_BYTES] = "";
    svo_status status = svo_tree_download(tree, world.queue);
    if (status == SVO_OK) {
        status = svo_tree_hash(tree, SVO_HASH_ALL, hash);
    }
    digest(of, hash, sizeof hash);
    return status;
}

/*
 * Scenarios: device and plan.
 */

static svo_status run_device(subject *of)
{
    svo_device *device = NULL, *second = NULL;
    svo_frontend *frontend = NULL;
    svo_status status = svo_device_create_default(NULL, &device, &of->message);
    if (status == SVO_OK) {
        digest(of, info_of_device(device).name, strlen(info_of_device(device).name));
        status = told(of, device, svo_frontend_create_cl(device, &frontend));
    }
    if (status == SVO_OK) {
        status = svo_device_create(info_of_device(device).context, info_of_device(device).device, NULL, &second,
                                   &of->message);
    }
    svo_frontend_destroy(&frontend);
    svo_device_destroy(&second);
    svo_device_destroy(&device);
    return status;
}

/* A part of the device, by name; then a device with a budget that counts a tree's buffers. */
static svo_status run_limited_device(subject *of)
{
    const svo_device_options part = {.struct_size = sizeof part, .device_name = "o", .max_threads = 1};
    const svo_device_options budget = {.struct_size = sizeof budget, .max_device_bytes = 1 << 30};
    svo_device *device = NULL;
    svo_tree *tree = NULL;
    SVO_I_TRY(svo_device_create_default(&part, &device, &of->message));
    svo_device_destroy(&device);
    SVO_I_TRY(svo_device_create_default(&budget, &device, &of->message));
    svo_status status = svo_tree_load(svo_from_path(world.tree_path), NULL, &tree, &of->message);
    if (status == SVO_OK) {
        status = told(of, device, svo_tree_upload(tree, device, NULL));
    }
    svo_tree_destroy(&tree);
    svo_device_destroy(&device);
    return status;
}

/* A tree, rays and hits to and from a device that has memory of its own, in parts. */
static svo_status run_staging(subject *of)
{
    svo_device *device = NULL;
    svo_tree *tree = NULL;
    svo_voxel_hit hits[RAYS] = {{.t = 0}};
    char hash[SVO_HASH_TEXT_BYTES] = "";
    SVO_I_TRY(svo_device_create_default(NULL, &device, &of->message));
    device->staging_bytes = 512;
    device->staged_bytes_min = 256;
    svo_status status = svo_tree_load(svo_from_path(world.tree_path), NULL, &tree, &of->message);
    if (status == SVO_OK) {
        status = told(of, device, svo_tree_upload(tree, device, NULL));
    }
    if (status == SVO_OK) {
        status = told(
            of, device,
            svo_trace_voxels(svo_tree_target(tree), svo_in_host(world.rays), svo_in_host(hits), RAYS, 0.0F, 0, NULL));
    }
    digest(of, hits, sizeof hits);
    if (status == SVO_OK) {
        status = told(of, device, svo_tree_download(tree, NULL));
    }
    if (status == SVO_OK) {
        status = svo_tree_hash(tree, SVO_HASH_ALL, hash);
    }
    digest(of, hash, sizeof hash);
    svo_tree_destroy(&tree);
    svo_device_destroy(&device);
    return status;
}

static svo_status plan_at(subject *of, svo_place place)
{
    svo_plan *plan = NULL;
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    svo_plan_options options = everything;
    options.place = place;
    const svo_status status = svo_plan_create(world.device, &world.mesh.mesh, DEPTH, &options, &plan);
    if (status == SVO_OK) {
        svo_plan_get_info(plan, &info);
        info.grid_ms = 0.0;
        digest(of, &info, sizeof info);
        const uint64_t bytes = info_of_plan(plan).peak_bytes;
        digest(of, &bytes, sizeof bytes);
    }
    svo_plan_destroy(&plan);
    return told(of, world.device, status);
}

static svo_status run_plan(subject *of)
{
    return plan_at(of, SVO_PLACE_DEFAULT);
}

static svo_status run_plan_on_device(subject *of)
{
    return plan_at(of, SVO_PLACE_DEVICE);
}

static svo_status run_count(subject *of)
{
    TRY_TOLD(svo_plan_count(of->plan, world.cl, world.queue));
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    svo_plan_get_info(of->plan, &info);
    digest(of, &info.fragments, sizeof info.fragments);
    return SVO_OK;
}

/* Reads a mesh back from OpenCL buffers. */
static void prepare_buffers(subject *of)
{
    const svo_mesh *mesh = &world.mesh.mesh;
    const cl_context context = info_of_device(world.device).context;
    float *positions = calloc(mesh->vertex_count * 3, sizeof *positions);
    assert_non_null(positions);
    for (size_t i = 0; i < mesh->vertex_count * 3; ++i) {
        positions[i] = (float)i;
    }
    of->positions = clCreateBuffer(context, CL_MEM_COPY_HOST_PTR, mesh->vertex_count * 12, positions, NULL);
    of->indices =
        clCreateBuffer(context, CL_MEM_COPY_HOST_PTR, mesh->triangle_count * 12, world.mesh.base.indices, NULL);
    free(positions);
    assert_true(of->positions != NULL && of->indices != NULL);
}

static svo_status run_mesh_read(subject *of)
{
    svo_mesh_copy *copy = NULL;
    const svo_mesh_buffers buffers = {.struct_size = sizeof buffers,
                                      .vertex_count = world.mesh.mesh.vertex_count,
                                      .triangle_count = world.mesh.mesh.triangle_count,
                                      .positions = {.memory = of->positions},
                                      .indices = {.memory = of->indices}};
    const svo_status status = svo_mesh_read(&buffers, world.queue, 0, NULL, &copy, &of->message);
    if (status == SVO_OK) {
        const svo_mesh *read = svo_mesh_copy_get(copy);
        digest(of, read->positions, read->vertex_count * 12);
        digest(of, read->indices, read->triangle_count * 12);
    }
    svo_mesh_copy_destroy(&copy);
    return status;
}

static svo_status run_plan_from_buffers(subject *of)
{
    svo_plan *plan = NULL;
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    const svo_mesh_buffers buffers = {.struct_size = sizeof buffers,
                                      .vertex_count = world.mesh.mesh.vertex_count,
                                      .triangle_count = world.mesh.mesh.triangle_count,
                                      .positions = {.memory = of->positions},
                                      .indices = {.memory = of->indices}};
    const svo_status status =
        svo_plan_create_from_buffers(world.device, &buffers, DEPTH, NULL, world.queue, 0, NULL, &plan);
    if (status == SVO_OK) {
        svo_plan_get_info(plan, &info);
        info.grid_ms = 0.0;
        digest(of, &info, sizeof info);
    }
    svo_plan_destroy(&plan);
    return told(of, world.device, status);
}

static void cleanup_buffers(subject *of)
{
    clReleaseMemObject(of->positions);
    clReleaseMemObject(of->indices);
}

/*
 * Scenarios: builds.
 */

svo_status build_and_digest(subject *of, svo_frontend *frontend)
{
    svo_tree *tree = NULL;
    svo_status status = svo_build(of->plan, frontend, world.queue, &tree, NULL);
    if (status == SVO_OK) {
        status = digest_tree(of, tree);
    }
    svo_tree_destroy(&tree);
    return told(of, world.device, status);
}

static svo_status run_build(subject *of)
{
    return build_and_digest(of, world.cl);
}

/* On a new device: everything is compiled, with a queue and a front end of the device's own. */
static void prepare_device(subject *of)
{
    if (svo_device_create_default(NULL, &of->device, &of->message) != SVO_OK) {
        fail_msg("%s", of->message.text);
    }
    if (svo_plan_create(of->device, &world.mesh.mesh, DEPTH, &everything, &of->plan) != SVO_OK) {
        fail_msg("%s", svo_device_message(of->device));
    }
}

static svo_status run_first_build(subject *of)
{
    svo_tree *tree = NULL;
    svo_status status = svo_build(of->plan, NULL, NULL, &tree, NULL);
    if (status == SVO_OK) {
        status = svo_tree_download(tree, NULL);
    }
    char hash[SVO_HASH_TEXT_BYTES] = "";
    if (status == SVO_OK) {
        status = svo_tree_hash(tree, SVO_HASH_ALL, hash);
        digest(of, hash, sizeof hash);
    }
    (void)told(of, of->device, status);
    svo_tree_destroy(&tree);
    return status;
}

static void prepare_sorted(subject *of)
{
    svo_plan_options options = everything;
    options.builder = SVO_BUILDER_SORTED;
    prepare_plan_by(of, &options);
}

/* Capacities that are too small: the build makes a second plan and runs stages again. */
static void prepare_short(subject *of)
{
    svo_plan_options options = everything;
    options.fragment_capacity = 16;
    prepare_plan_by(of, &options);
}

/* A plan whose mesh moves. */
static void prepare_moving(subject *of)
{
    svo_plan_options options = everything;
    options.updatable = 1;
    options.edge = 2.0;
    prepare_plan_by(of, &options);
}

static svo_status run_update(subject *of)
{
    cl_event done = NULL;
    TRY_TOLD(svo_plan_update(of->plan, &world.mesh.mesh, NULL));
    TRY_TOLD(svo_plan_update(of->plan, &world.mesh.mesh, &(svo_submit){.queue = world.queue, .event = &done}));
    release_event(&done);
    return build_and_digest(of, world.cl);
}

/* The same of floats, with their vertices in buffers. */
static void prepare_moving_floats(subject *of)
{
    svo_plan_options options = everything;
    const cl_context context = info_of_device(world.device).context;
    const size_t bytes = sizeof world.float_positions;
    options.updatable = 1;
    options.edge = 2.0;
    if (svo_plan_create(world.device, &world.floats, DEPTH, &options, &of->plan) != SVO_OK) {
        fail_msg("%s", svo_device_message(world.device));
    }
    of->positions = clCreateBuffer(context, CL_MEM_COPY_HOST_PTR, bytes, world.float_positions, NULL);
    of->normals = clCreateBuffer(context, CL_MEM_COPY_HOST_PTR, bytes, world.mesh.normals, NULL);
    assert_true(of->positions != NULL && of->normals != NULL);
}

static void cleanup_moving_floats(subject *of)
{
    destroy_all(of);
    clReleaseMemObject(of->positions);
    clReleaseMemObject(of->normals);
}

static svo_status run_update_from_buffers(subject *of)
{
    const svo_mesh_buffers buffers = {.struct_size = sizeof buffers,
                                      .vertex_count = world.floats.vertex_count,
                                      .triangle_count = world.floats.triangle_count,
                                      .positions = {.memory = of->positions},
                                      .normals = {.memory = of->normals}};
    cl_event done = NULL;
    TRY_TOLD(svo_plan_update_from_buffers(of->plan, &buffers, NULL));
    TRY_TOLD(svo_plan_update_from_buffers(of->plan, &buffers, &(svo_submit){.queue = world.queue, .event = &done}));
    release_event(&done);
    return build_and_digest(of, world.cl);
}

static void prepare_chunks(subject *of)
{
    svo_plan_options options = everything;
    options.chunk_bytes = 16384;
    if (svo_plan_create(world.device, &world.mesh.mesh, DEPTH + 1, &options, &of->plan) != SVO_OK) {
        fail_msg("%s", svo_device_message(world.device));
    }
}

static svo_status enqueue_and_finish(subject *of, svo_workspace *workspace, svo_tree *tree, int trim)
{
    cl_event done = NULL;
    svo_build_report report = SVO_BUILD_REPORT_INIT;
    TRY_TOLD(svo_build_enqueue(workspace, tree, &(svo_submit){.queue = world.queue, .event = &done}));
    release_event(&done);
    TRY_TOLD(svo_tree_finish(tree, world.queue, trim, &report));
    return told(of, world.device, digest_tree(of, tree));
}

static svo_status run_workspace(subject *of)
{
    svo_workspace *workspace = NULL;
    svo_tree *tree = NULL;
    svo_status status = told(of, world.device, svo_workspace_create(of->plan, world.cl, world.queue, NULL, &workspace));
    if (status == SVO_OK) {
        status = told(of, world.device, svo_workspace_make_tree(workspace, &tree));
    }
    if (status == SVO_OK) {
        status = enqueue_and_finish(of, workspace, tree, 1);
    }
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    return status;
}

static void prepare_workspace(subject *of)
{
    prepare_plan(of);
    if (svo_workspace_create(of->plan, world.cl, world.queue, NULL, &of->workspace) != SVO_OK ||
        svo_workspace_make_tree(of->workspace, &of->tree) != SVO_OK) {
        fail_msg("%s", svo_device_message(world.device));
    }
}

/* One workspace and tree for all builds. */
static svo_status run_enqueue(subject *of)
{
    (void)svo_tree_finish(of->tree, world.queue, 0, NULL); /* of an earlier run, where that failed before it began */
    SVO_I_TRY(enqueue_and_finish(of, of->workspace, of->tree, 0));
    return enqueue_and_finish(of, of->workspace, of->tree, 0);
}

/* A finished tree of a plan whose mesh moves, with a BVH. */
static void prepare_refit(subject *of)
{
    prepare_moving_floats(of);
    if (svo_workspace_create(of->plan, world.cl, world.queue, NULL, &of->workspace) != SVO_OK ||
        svo_workspace_make_tree(of->workspace, &of->tree) != SVO_OK ||
        svo_build_enqueue(of->workspace, of->tree, &(svo_submit){.queue = world.queue}) != SVO_OK ||
        svo_tree_finish(of->tree, world.queue, 0, NULL) != SVO_OK ||
        svo_tree_make_bvh(of->tree, SVO_BVH_FAST, world.queue) != SVO_OK) {
        fail_msg("%s", svo_device_message(world.device));
    }
}

static svo_status run_refit(subject *of)
{
    svo_hit hits[RAYS];
    cl_event done = NULL;
    (void)svo_tree_finish(of->tree, world.queue, 0, NULL); /* of an earlier run, where that failed before it began */
    TRY_TOLD(svo_build_enqueue(of->workspace, of->tree, &(svo_submit){.queue = world.queue}));
    TRY_TOLD(svo_tree_refit_bvh(of->tree, &(svo_submit){.queue = world.queue, .event = &done}));
    release_event(&done);
    TRY_TOLD(svo_tree_refit_bvh(of->tree, NULL));
    TRY_TOLD(svo_tree_finish(of->tree, world.queue, 0, NULL));
    TRY_TOLD(svo_trace_triangles(svo_tree_target(of->tree), svo_in_host(world.rays), svo_in_host(hits), RAYS,
                                 SVO_TRACE_CLOSEST, &(svo_submit){.queue = world.queue}));
    for (size_t i = 0; i < RAYS; ++i) {
        hits[i].count = 0; /* leaves visited: a BVH that could not be refit is made anew */
    }
    digest(of, hits, sizeof hits);
    return SVO_OK;
}

/* By the BVHs of the objects. */
static svo_status trace_moving(subject *of, svo_moving *moving)
{
    svo_hit hits[RAYS];
    TRY_TOLD(svo_moving_make_bvh(moving, SVO_BVH_BEST, 0.0F, world.queue, NULL));
    TRY_TOLD(svo_trace_triangles(svo_tree_target(svo_moving_tree(moving)), svo_in_host(world.rays), svo_in_host(hits),
                                 RAYS, SVO_TRACE_COUNT, &(svo_submit){.queue = world.queue}));
    digest(of, hits, sizeof hits);
    return SVO_OK;
}

/* A scene with an object that comes, moves and goes. */
static svo_status move_object(subject *of, svo_moving *moving)
{
    const double transform[12] = {0.5, 0, 0, 0.1, 0, 0.5, 0, 0.2, 0, 0, 0.5, 0.3};
    svo_moving_report report = SVO_MOVING_REPORT_INIT;
    cl_event done = NULL;
    uint32_t object = 0;
    svo_mesh mesh;
    TRY_TOLD(svo_moving_add(moving, &world.mesh.mesh, NULL, &object));
    TRY_TOLD(svo_moving_update(moving, NULL, NULL));
    TRY_TOLD(svo_moving_make_bvh(moving, SVO_BVH_BEST, 0.0F, world.queue, NULL));
    TRY_TOLD(svo_moving_set_transform(moving, object, transform));
    TRY_TOLD(svo_moving_update(moving, &(svo_submit){.queue = world.queue}, NULL));
    TRY_TOLD(svo_moving_finish(moving, NULL));
    TRY_TOLD(svo_moving_get_mesh(moving, &mesh));
    TRY_TOLD(digest_tree(of, svo_moving_tree(moving)));
    TRY_TOLD(trace_moving(of, moving));
    TRY_TOLD(svo_moving_remove(moving, object));
    TRY_TOLD(svo_moving_update(moving, &(svo_submit){.queue = world.queue, .event = &done}, &report));
    release_event(&done);
    return told(of, world.device, digest_tree(of, svo_moving_tree(moving)));
}

static svo_status run_moving(subject *of)
{
    const svo_moving_options options = {.struct_size = sizeof options,
                                        .need = (uint32_t)SVO_NEED_RAYS | (uint32_t)SVO_NEED_MATERIAL |
                                                (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL |
                                                (uint32_t)SVO_NEED_PROJECTED_AREA,
                                        .edge = 2.0,
                                        .max_area = 100.0};
    svo_moving *moving = NULL;
    svo_status status = told(of, world.device,
                             svo_moving_create(world.device, &world.mesh.mesh, DEPTH, &options, world.queue, &moving));
    if (status == SVO_OK) {
        status = move_object(of, moving);
    }
    svo_moving_destroy(&moving);
    return status;
}

/*
 * Scenarios: rays and pictures.
 */

svo_status run_rays(subject *of)
{
    svo_hit hits[RAYS];
    svo_nearest nearest[RAYS];
    cl_event done = NULL;
    /* Hits say how many leaves of the BVH were visited. */
    TRY_TOLD(svo_tree_make_bvh(of->tree, SVO_BVH_BEST, world.queue));
    TRY_TOLD(svo_trace_triangles(svo_tree_target(of->tree), svo_in_host(world.rays), svo_in_host(hits), RAYS,
                                 SVO_TRACE_CLOSEST, &(svo_submit){.queue = world.queue}));
    digest(of, hits, sizeof hits);
    TRY_TOLD(svo_tree_make_bvh(of->tree, SVO_BVH_FAST, world.queue));
    TRY_TOLD(svo_trace_triangles(svo_tree_target(of->tree), svo_in_host(world.rays), svo_in_host(hits), RAYS,
                                 SVO_TRACE_COUNT, &(svo_submit){.queue = world.queue, .event = &done}));
    release_event(&done);
    digest(of, hits, sizeof hits);
    TRY_TOLD(svo_tree_nearest(of->tree, svo_in_host(world.points), svo_in_host(nearest), RAYS,
                              &(svo_submit){.queue = world.queue, .event = &done}));
    release_event(&done);
    digest(of, nearest, sizeof nearest);
    return SVO_OK;
}

static svo_status run_render(subject *of)
{
    uint8_t picture[PICTURE_SIDE * PICTURE_SIDE * 4];
    svo_render_options options = {
        .struct_size = sizeof options, .width = PICTURE_SIDE, .height = PICTURE_SIDE, .view = SVO_VIEW_SHADED};
    TRY_TOLD(svo_camera_fit(svo_tree_target(of->tree), 1.0F, &options.camera));
    for (unsigned i = 0; i < 2; ++i) {
        memset(picture, 0, sizeof picture);
        TRY_TOLD(
            svo_render(svo_tree_target(of->tree), &options, svo_in_host(picture), &(svo_submit){.queue = world.queue}));
        digest(of, picture, sizeof picture);
        options.view = SVO_VIEW_TRIANGLES;
    }
    return SVO_OK;
}

/* The caller's buffers. */
static void prepare_ray_buffers(subject *of)
{
    const cl_context context = info_of_device(world.device).context;
    prepare_tree(of);
    of->positions = clCreateBuffer(context, CL_MEM_COPY_HOST_PTR, sizeof world.rays, world.rays, NULL);
    of->indices = clCreateBuffer(context, CL_MEM_READ_WRITE, RAYS * sizeof(svo_hit), NULL, NULL);
    assert_true(of->positions != NULL && of->indices != NULL);
}

static void cleanup_ray_buffers(subject *of)
{
    clReleaseMemObject(of->positions);
    clReleaseMemObject(of->indices);
    destroy_all(of);
}

/* done: NULL after a call that waits. */
static void take_result(subject *of, cl_event done)
{
    svo_hit hits[RAYS];
    faults_spare(true);
    const cl_int error = clEnqueueReadBuffer(world.queue, of->indices, CL_TRUE, 0, sizeof hits, hits,
                                             done != NULL ? 1 : 0, done != NULL ? &done : NULL, NULL);
    faults_spare(false);
    assert_int_equal(error, CL_SUCCESS);
    digest(of, hits, sizeof hits);
    if (done != NULL) {
        release_event(&done);
    }
}

static svo_status run_rays_buffers(subject *of)
{
    const svo_target target = svo_tree_target(of->tree);
    const svo_array input = svo_in_buffer(of->positions);
    const svo_array output = svo_in_buffer(of->indices);
    cl_event done = NULL;
    const svo_submit submit = {.queue = world.queue, .event = &done};
    TRY_TOLD(svo_trace_triangles(target, input, output, RAYS, SVO_TRACE_CLOSEST, &submit));
    take_result(of, done);
    TRY_TOLD(svo_tree_nearest(of->tree, input, output, RAYS, &submit));
    take_result(of, done);
    TRY_TOLD(svo_trace_triangles(target, input, output, RAYS, SVO_TRACE_CLOSEST, NULL));
    take_result(of, NULL);
    TRY_TOLD(svo_tree_nearest(of->tree, input, output, RAYS, NULL));
    take_result(of, NULL);
    return SVO_OK;
}

static svo_status run_set_arguments(subject *of)
{
    return told(of, world.device, svo_kernel_set_arguments(svo_tree_target(of->tree), world.kernel, 0));
}

/* Two edits, steps of all kinds, and a list. */
static svo_status use_edit(subject *of, svo_edit *edit, svo_edit *stamp)
{
    svo_edit_step step = SVO_EDIT_STEP_INIT;
    const int32_t offset[3] = {5, -3, 1};
    svo_voxels *list = NULL;
    svo_voxels_info info = SVO_VOXELS_INFO_INIT;
    step.shape = SVO_EDIT_SPHERE;
    step.radius = 6.0;
    SVO_I_TRY(svo_edit_apply(stamp, &step, &of->message));
    step.end[0] = 20.0;
    step.shape = SVO_EDIT_CAPSULE;
    SVO_I_TRY(svo_edit_apply(edit, &step, &of->message));
    SVO_I_TRY(svo_edit_copy(edit, &step, offset, &of->message));
    step.shape = SVO_EDIT_VOXELS;
    step.verb = SVO_EDIT_CLEAR;
    step.other = stamp;
    SVO_I_TRY(svo_edit_apply(edit, &step, &of->message));
    svo_edit_collect(edit);
    SVO_I_TRY(svo_edit_undo(edit));
    SVO_I_TRY(svo_edit_redo(edit));
    SVO_I_TRY(svo_edit_get_voxels(edit, &list, &of->message));
    (void)svo_voxels_get_info(list, &info);
    digest(of, svo_voxels_get(list), info.voxel_count * sizeof(svo_voxel));
    svo_voxels_destroy(&list);
    return SVO_OK;
}

static svo_status run_edit(subject *of)
{
    svo_edit *edit = NULL, *stamp = NULL;
    svo_edit_mirror *mirror = NULL;
    svo_tree *tree = NULL;
    svo_status status = svo_edit_create(NULL, NULL, &edit, &of->message);
    if (status == SVO_OK) {
        status = svo_edit_create(NULL, NULL, &stamp, &of->message);
    }
    if (status == SVO_OK) {
        status = use_edit(of, edit, stamp);
    }
    if (status == SVO_OK) {
        status = told(of, world.device, svo_edit_commit(edit, world.device, 0, NULL, world.queue, &tree, NULL));
    }
    if (status == SVO_OK) {
        status = told(of, world.device, digest_tree(of, tree));
    }
    if (status == SVO_OK) {
        status = told(of, world.device, svo_edit_mirror_create(world.device, edit, world.queue, &mirror));
    }
    if (status == SVO_OK) {
        (void)svo_edit_undo(edit);
        status = told(of, world.device, svo_edit_mirror_update(mirror, world.queue));
    }
    svo_edit_mirror_destroy(&mirror);
    svo_tree_destroy(&tree);
    svo_edit_destroy(&stamp);
    svo_edit_destroy(&edit);
    return status;
}

static const scenario rows[] = {
    {"device", false, false, prepare_nothing, run_device, NULL, destroy_all},
    {"limited_device", false, false, prepare_nothing, run_limited_device, NULL, destroy_all},
    {"staging", false, false, prepare_nothing, run_staging, NULL, destroy_all},
    {"plan", false, false, prepare_nothing, run_plan, NULL, destroy_all},
    {"plan_on_device", false, false, prepare_nothing, run_plan_on_device, NULL, destroy_all},
    {"plan_count", false, false, prepare_plan, run_count, NULL, destroy_all},
    {"mesh_read", false, false, prepare_buffers, run_mesh_read, NULL, cleanup_buffers},
    {"plan_from_buffers", false, false, prepare_buffers, run_plan_from_buffers, NULL, cleanup_buffers},
    {"build", false, false, prepare_plan, run_build, NULL, destroy_all},
    {"build_sorted", false, false, prepare_sorted, run_build, NULL, destroy_all},
    {"build_short", false, false, prepare_short, run_build, NULL, destroy_all},
    {"build_chunks", false, false, prepare_chunks, run_build, NULL, destroy_all},
    {"plan_update", false, false, prepare_moving, run_update, NULL, destroy_all},
    {"plan_update_from_buffers", false, false, prepare_moving_floats, run_update_from_buffers, NULL,
     cleanup_moving_floats},
    {"moving", false, false, prepare_nothing, run_moving, NULL, destroy_all},
    {"first_build", false, false, prepare_device, run_first_build, NULL, destroy_all},
    {"workspace", false, false, prepare_plan, run_workspace, NULL, destroy_all},
    {"enqueue", false, false, prepare_workspace, run_enqueue, NULL, destroy_all},
    {"refit", false, false, prepare_refit, run_refit, NULL, cleanup_moving_floats},
    {"rays", false, false, prepare_tree, run_rays, NULL, destroy_all},
    {"rays_buffers", false, false, prepare_ray_buffers, run_rays_buffers, NULL, cleanup_ray_buffers},
    {"set_arguments", false, false, prepare_tree, run_set_arguments, NULL, destroy_all},
    {"render", false, false, prepare_tree, run_render, NULL, destroy_all},
    {"edit", false, false, prepare_nothing, run_edit, NULL, destroy_all},
};
const scenario_list library_scenarios = {rows, sizeof rows / sizeof rows[0]};
