/* SPDX-License-Identifier: MIT */
/*
 * Every call that the library makes fails once: each allocation, each call of OpenCL, OpenGL and EGL, of the file
 * system, of the import child and of the loader. Each failure ends in a status with words that name the call, or in the
 * right result where the library does without. Nothing is lost, handles can be destroyed, and the same handles work in
 * the next call.
 *
 *     test_faults [STRIDE [SCENARIO]]
 *
 * STRIDE: every how-manieth call fails; 1: all; default 20, for a quick run. SCENARIO: one row of the table at the end.
 * The environment variable SVOCL_FAULTS_TRACE prints each failed call beforehand. A build with
 * -fsanitize=address,undefined finds more: memory used after its release, and what is lost in the import child.
 */
#define _POSIX_C_SOURCE 200809L
#include <inttypes.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "attributed_mesh.h"
#include "context/context.h"
#include "core/device.h"
#include "faults.h"
#include "nondefault_state.h"
#include "own_context.h"
#include "svocl/gl.h"
#include "svocl/io.h"
#include "svocl/svocl.h"

enum { TRIANGLES = 40, DEPTH = 4, RAYS = 64, PICTURE_SIDE = 32, CALLS_MAX = 100000, HANG_SECONDS = 120 };

#define CHILD_INDEX_VARIABLE  "SVOCL_FAULTS_CHILD_INDEX"
#define CHILD_REPORT_VARIABLE "SVOCL_FAULTS_CHILD_REPORT"

/* What scenarios share. Opened once; no call fails meanwhile. */
static struct {
    svo_device *device;
    cl_command_queue queue;
    svo_frontend *cl;
    svo_gl_context *context; /* NULL: no OpenGL here */
    svo_gl *host, *copy;
    own_context own; /* the caller's */
    uint32_t gl_buffer;
    cl_program program;
    cl_kernel kernel; /* the caller's */
    attributed_mesh mesh;
    svo_ray rays[RAYS];
    svo_query_point points[RAYS];
    char folder[64];
    char obj_path[128], ply_path[128], stl_path[128], off_path[128];
    char tree_path[128], packed_path[128], report_path[128], vox_path[128];
    uint64_t stride;
    uint64_t failed_calls[FAULT_KINDS], recovered;
    unsigned violations;
    char current[128]; /* for words after a crash or a hang */
} world;

/* What one run works on. */
typedef struct subject {
    svo_device *device;
    svo_plan *plan;
    svo_tree *tree;
    svo_workspace *workspace;
    svo_gl *gl;
    cl_mem positions, indices;
    const char *mesh_path;
    nondefault_state *state; /* of the caller's context */
    char warning[256]; /* of an import that leaves something out */
    svo_message message;
    XXH64_hash_t digest; /* of the results */
} subject;

/*
 * Small steps of scenarios.
 */

static void digest(subject *of, const void *bytes, size_t byte_count)
{
    of->digest = XXH3_64bits_withSeed(bytes, byte_count, of->digest);
}

/* Takes the message of the device's handle. */
static svo_status told(subject *of, const svo_device *device, svo_status status)
{
    if (status != SVO_OK) {
        (void)snprintf(of->message.text, sizeof of->message.text, "%s", svo_device_message(device));
    }
    return status;
}

#define TRY_TOLD(call) SVO_I_TRY(told(of, world.device, (call)))

static const svo_plan_options everything = {.struct_size = sizeof everything, .need = SVO_NEED_ALL};

static void prepare_plan_by(subject *of, const svo_plan_options *options)
{
    if (svo_plan_create(world.device, &world.mesh.mesh, DEPTH, options, &of->plan) != SVO_OK) {
        fail_msg("%s", svo_device_message(world.device));
    }
}

static void prepare_plan(subject *of)
{
    prepare_plan_by(of, &everything);
}

static void prepare_tree(subject *of)
{
    prepare_plan(of);
    if (svo_build(of->plan, world.cl, world.queue, &of->tree, NULL) != SVO_OK) {
        fail_msg("%s", svo_device_message(world.device));
    }
}

static void prepare_nothing(subject *of)
{
    (void)of;
}

static void destroy_all(subject *of)
{
    svo_tree_destroy(&of->tree);
    svo_workspace_destroy(&of->workspace);
    svo_plan_destroy(&of->plan);
    svo_gl_destroy(&of->gl);
    svo_device_destroy(&of->device);
}

/* Downloads the tree and adds its hash to the digest. */
static svo_status digest_tree(subject *of, svo_tree *tree)
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
        digest(of, svo_device_name(device), strlen(svo_device_name(device)));
        status = told(of, device, svo_frontend_create_cl(device, &frontend));
    }
    if (status == SVO_OK) {
        status =
            svo_device_create(svo_device_cl_context(device), svo_device_cl_device(device), NULL, &second, &of->message);
    }
    svo_frontend_destroy(&frontend);
    svo_device_destroy(&second);
    svo_device_destroy(&device);
    return status;
}

static svo_status run_plan(subject *of)
{
    svo_plan *plan = NULL;
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    const svo_status status = svo_plan_create(world.device, &world.mesh.mesh, DEPTH, &everything, &plan);
    if (status == SVO_OK) {
        svo_plan_get_info(plan, &info);
        info.grid_ms = 0.0;
        digest(of, &info, sizeof info);
        const uint64_t bytes = svo_plan_peak_bytes(plan);
        digest(of, &bytes, sizeof bytes);
    }
    svo_plan_destroy(&plan);
    return told(of, world.device, status);
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
    const cl_context context = svo_device_cl_context(world.device);
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

static void cleanup_buffers(subject *of)
{
    clReleaseMemObject(of->positions);
    clReleaseMemObject(of->indices);
}

/*
 * Scenarios: builds.
 */

static svo_status build_and_digest(subject *of, svo_frontend *frontend)
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
    TRY_TOLD(svo_build_enqueue(workspace, tree, world.queue, 0, NULL, &done));
    faults_spare(true);
    clReleaseEvent(done);
    faults_spare(false);
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

/*
 * Scenarios: rays and pictures.
 */

static svo_status run_rays(subject *of)
{
    svo_hit hits[RAYS];
    svo_nearest nearest[RAYS];
    TRY_TOLD(svo_tree_trace(of->tree, world.rays, hits, RAYS, SVO_TRACE_CLOSEST, world.queue));
    digest(of, hits, sizeof hits);
    TRY_TOLD(svo_tree_trace(of->tree, world.rays, hits, RAYS, SVO_TRACE_COUNT, world.queue));
    digest(of, hits, sizeof hits);
    TRY_TOLD(svo_tree_nearest(of->tree, world.points, nearest, RAYS, world.queue));
    digest(of, nearest, sizeof nearest);
    return SVO_OK;
}

static svo_status run_render(subject *of)
{
    uint8_t picture[PICTURE_SIDE * PICTURE_SIDE * 4];
    svo_render_options options = {
        .struct_size = sizeof options, .width = PICTURE_SIDE, .height = PICTURE_SIDE, .view = SVO_VIEW_SHADED};
    svo_camera_frame(of->tree, 1.0F, &options.camera);
    for (unsigned i = 0; i < 2; ++i) {
        memset(picture, 0, sizeof picture);
        TRY_TOLD(svo_tree_render(world.device, of->tree, &options, world.queue, picture));
        digest(of, picture, sizeof picture);
        options.view = SVO_VIEW_TRIANGLES;
    }
    return SVO_OK;
}

/* The caller's buffers and event. */
static void prepare_ray_buffers(subject *of)
{
    const cl_context context = svo_device_cl_context(world.device);
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

static svo_status take_result(subject *of, cl_event *done)
{
    svo_hit hits[RAYS];
    faults_spare(true);
    const cl_int error = clEnqueueReadBuffer(world.queue, of->indices, CL_TRUE, 0, sizeof hits, hits, 1, done, NULL);
    clReleaseEvent(*done);
    faults_spare(false);
    *done = NULL;
    assert_int_equal(error, CL_SUCCESS);
    digest(of, hits, sizeof hits);
    return SVO_OK;
}

static svo_status run_rays_enqueue(subject *of)
{
    cl_event done = NULL;
    TRY_TOLD(svo_tree_trace_enqueue(of->tree, of->positions, of->indices, RAYS, SVO_TRACE_CLOSEST, world.queue, 0, NULL,
                                    &done));
    SVO_I_TRY(take_result(of, &done));
    TRY_TOLD(svo_tree_nearest_enqueue(of->tree, of->positions, of->indices, RAYS, world.queue, 0, NULL, &done));
    return take_result(of, &done);
}

static svo_status run_set_args(subject *of)
{
    return told(of, world.device, svo_tree_set_args(of->tree, world.kernel, 0));
}

/*
 * Scenarios: files.
 */

static void prepare_host_tree(subject *of)
{
    prepare_tree(of);
    if (svo_tree_download(of->tree, world.queue) != SVO_OK) {
        fail_msg("%s", svo_device_message(world.device));
    }
}

static void digest_file(subject *of, const char *path)
{
    static char bytes[1 << 20];
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    const size_t count = fread(bytes, 1, sizeof bytes, file);
    assert_int_equal(fclose(file), 0);
    digest(of, bytes, count);
}

static svo_status run_save(subject *of)
{
    const svo_save_options packed = {.struct_size = sizeof packed, .compress = 1};
    SVO_I_TRY(svo_tree_save(of->tree, world.tree_path, NULL, &of->message));
    return svo_tree_save(of->tree, world.packed_path, &packed, &of->message);
}

/* After the run, when no call fails. */
static void digest_saved(subject *of)
{
    digest_file(of, world.tree_path);
    digest_file(of, world.packed_path);
}

static svo_status run_load(subject *of)
{
    const char *const paths[] = {world.tree_path, world.packed_path};
    for (size_t i = 0; i < 2; ++i) {
        svo_tree *tree = NULL;
        char hash[SVO_HASH_TEXT_BYTES] = "";
        svo_status status = svo_tree_load(paths[i], &tree, &of->message);
        if (status == SVO_OK) {
            status = svo_tree_hash(tree, SVO_HASH_ALL, hash);
        }
        digest(of, hash, sizeof hash);
        svo_tree_destroy(&tree);
        SVO_I_TRY(status);
    }
    return SVO_OK;
}

/* A file in memory. */
typedef struct voxel_bytes {
    uint8_t bytes[1 << 16];
    size_t count;
} voxel_bytes;

static int put_voxel_bytes(void *user, const void *bytes, size_t byte_count)
{
    voxel_bytes *to = user;
    if (byte_count > sizeof to->bytes - to->count) {
        return 1;
    }
    memcpy(to->bytes + to->count, bytes, byte_count);
    to->count += byte_count;
    return 0;
}

/* Writes a list in one format, and reads it again. */
static svo_status write_and_read(subject *of, const svo_voxels *voxels, svo_voxel_format format)
{
    static voxel_bytes file;
    svo_voxels *again = NULL;
    svo_voxels_info info = SVO_VOXELS_INFO_INIT;
    file.count = 0;
    SVO_I_TRY(svo_voxels_write(voxels, format, put_voxel_bytes, &file, NULL, &of->message));
    digest(of, file.bytes, file.count);
    SVO_I_TRY(svo_voxels_load_memory(file.bytes, file.count, world.vox_path, NULL, &again, NULL, &of->message));
    (void)svo_voxels_get_info(again, &info);
    digest(of, svo_voxels_get(again), info.voxel_count * sizeof(svo_voxel));
    svo_voxels_destroy(&again);
    return SVO_OK;
}

static svo_status use_voxels(subject *of, const svo_voxels *voxels)
{
    svo_voxels *again = NULL;
    SVO_I_TRY(write_and_read(of, voxels, SVO_VOXEL_FORMAT_VOX));
    SVO_I_TRY(write_and_read(of, voxels, SVO_VOXEL_FORMAT_BINVOX));
    const svo_status status = write_and_read(of, voxels, SVO_VOXEL_FORMAT_SVX);
    if (status != SVO_OK && status != SVO_UNSUPPORTED) {
        return status;
    }
    SVO_I_TRY(svo_voxels_save(voxels, world.vox_path, SVO_VOXEL_FORMAT_AUTO, NULL, &of->message));
    SVO_I_TRY(svo_voxels_load(world.vox_path, NULL, &again, NULL, &of->message));
    svo_voxels_destroy(&again);
    return SVO_OK;
}

/* A list, its tree and files. */
static svo_status run_voxels(subject *of)
{
    static const svo_voxel_property property = {9, "_type", "_glass"};
    svo_voxel given[TRIANGLES];
    svo_voxels *voxels = NULL, *again = NULL;
    svo_tree *tree = NULL;
    for (int i = 0; i < TRIANGLES; ++i) {
        given[i] = (svo_voxel){.x = i % 4, .y = i * 7 % 5, .z = i % 3, .rgba = {(uint8_t)i, 1, 2, 255}, .material = 9};
    }
    const svo_voxels_source source = {.struct_size = sizeof source,
                                      .voxels = given,
                                      .voxel_count = TRIANGLES,
                                      .properties = &property,
                                      .property_count = 1};
    svo_status status = svo_voxels_create(&source, &voxels, &of->message);
    if (status == SVO_OK) {
        status = use_voxels(of, voxels);
    }
    if (status == SVO_OK) {
        status = told(of, world.device, svo_voxels_build(world.device, voxels, 0, NULL, world.queue, &tree, NULL));
    }
    if (status == SVO_OK) {
        status = told(of, world.device, digest_tree(of, tree));
    }
    if (status == SVO_OK) {
        status = svo_tree_get_voxels(tree, &again, &of->message);
    }
    svo_tree_destroy(&tree);
    svo_voxels_destroy(&again);
    svo_voxels_destroy(&voxels);
    return status;
}

static void prepare_loaded(subject *of)
{
    if (svo_tree_load(world.tree_path, &of->tree, &of->message) != SVO_OK) {
        fail_msg("%s", of->message.text);
    }
}

static svo_status run_upload(subject *of)
{
    TRY_TOLD(svo_tree_upload(of->tree, world.device, world.queue));
    return run_rays(of);
}

static void prepare_obj(subject *of)
{
    of->mesh_path = world.obj_path;
}

static void prepare_ply(subject *of)
{
    of->mesh_path = world.ply_path;
}

static void prepare_stl(subject *of)
{
    of->mesh_path = world.stl_path;
}

static void prepare_off(subject *of)
{
    of->mesh_path = world.off_path;
}

/* A texture that cannot be read is left out, with a warning. */
static void keep_warning(void *user, svo_log_level level, const char *text)
{
    subject *of = user;
    (void)level;
    (void)snprintf(of->warning, sizeof of->warning, "%s", text);
}

static svo_status run_import(subject *of)
{
    svo_import *import = NULL;
    const svo_import_options options = {.struct_size = sizeof options, .child_program = "/proc/self/exe"};
    const svo_status status = svo_import_file(of->mesh_path, &options, keep_warning, of, &import, &of->message);
    if (status == SVO_OK) {
        const svo_mesh *mesh = svo_import_mesh(import);
        digest(of, mesh->positions, mesh->vertex_count * 3 * sizeof(float));
        digest(of, mesh->indices, mesh->triangle_count * 3 * sizeof(uint32_t));
        digest(of, &mesh->material_count, sizeof mesh->material_count);
    }
    svo_import_destroy(&import);
    return status;
}

/*
 * Scenarios: OpenGL.
 */

static svo_status run_context(subject *of)
{
    svo_gl_context *context = NULL;
    svo_device *device = NULL;
    svo_status status = svo_gl_context_create(SVO_GL_SURFACELESS, 0, &context, &of->message);
    if (status == SVO_OK) {
        svo_gl_context_info info = SVO_GL_CONTEXT_INFO_INIT;
        svo_gl_context_get_info(context, &info);
        digest(of, info.renderer, strlen(info.renderer));
        status = svo_gl_device_create(context, svo_device_cl_device(world.device), NULL, &device, &of->message);
    }
    svo_device_destroy(&device);
    svo_gl_context_destroy(&context);
    return status;
}

static svo_status run_gl(subject *of)
{
    svo_gl *gl = NULL;
    const svo_status status = svo_gl_create(world.device, world.context, NULL, &gl);
    svo_gl_destroy(&gl);
    return told(of, world.device, status);
}

static svo_status run_gl_build_host(subject *of)
{
    return build_and_digest(of, svo_gl_frontend(world.host));
}

static svo_status run_gl_build_copy(subject *of)
{
    return build_and_digest(of, svo_gl_frontend(world.copy));
}

static void prepare_wrapped(subject *of)
{
    prepare_plan(of);
    own_context_bind(&world.own, true);
    of->state = nondefault_state_set(false);
}

static void cleanup_wrapped(subject *of)
{
    destroy_all(of);
    nondefault_state_destroy(&of->state);
    own_context_bind(&world.own, false);
}

static svo_gl_function find_function(void *user, const char *name)
{
    const svo_gl_function real = own_context_function(user, name);
    void *found = NULL;
    memcpy(&found, &real, sizeof found);
    found = faults_hook(name, found);
    svo_gl_function hooked = NULL;
    memcpy(&hooked, &found, sizeof hooked);
    return hooked;
}

/* A query that failed must not change the caller's state. What sets state cannot restore it where it fails. */
static void check_state(const subject *of)
{
    const char *name = faults_failed().name;
    if (name != NULL && (strncmp(name, "glGet", 5) == 0 || strncmp(name, "glIs", 4) == 0)) {
        faults_spare(true);
        nondefault_state_assert(of->state, name);
        faults_spare(false);
    }
}

/* In the caller's context: its state is saved and restored. */
static svo_status run_wrapped(subject *of)
{
    svo_gl *gl = NULL;
    svo_gl_context *context = NULL;
    const svo_gl_options options = {.struct_size = sizeof options, .share = SVO_GL_SHARE_COPY};
    svo_status status = svo_gl_context_wrap(find_function, NULL, &context, &of->message);
    if (status == SVO_OK) {
        status = told(of, world.device, svo_gl_create(world.device, context, &options, &gl));
    }
    if (status == SVO_OK) {
        status = build_and_digest(of, svo_gl_frontend(gl));
    }
    svo_gl_destroy(&gl);
    svo_gl_context_destroy(&context);
    check_state(of);
    return status;
}

static svo_status run_gl_mesh_read(subject *of)
{
    svo_mesh_copy *copy = NULL;
    const svo_mesh_buffers buffers = {.struct_size = sizeof buffers,
                                      .vertex_count = RAYS,
                                      .triangle_count = RAYS / 3,
                                      .positions = {.gl_buffer = world.gl_buffer},
                                      .indices = {.gl_buffer = world.gl_buffer}};
    const svo_status status = svo_gl_mesh_read(&buffers, world.context, 0, NULL, &copy, &of->message);
    if (status == SVO_OK) {
        const svo_mesh *read = svo_mesh_copy_get(copy);
        digest(of, read->positions, read->vertex_count * 12);
        digest(of, read->indices, read->triangle_count * 12);
    }
    svo_mesh_copy_destroy(&copy);
    return status;
}

static svo_status build_in_gl(subject *of, svo_gl *gl)
{
    svo_tree *tree = NULL;
    svo_status status = svo_gl_build(gl, of->plan, world.queue, &tree, NULL);
    if (status == SVO_OK) {
        status = digest_tree(of, tree);
    }
    svo_tree_destroy(&tree);
    return told(of, world.device, status);
}

static svo_status run_gl_builder(subject *of)
{
    return build_in_gl(of, world.copy);
}

/* With a new handle: shaders are compiled. */
static void prepare_gl(subject *of)
{
    const svo_gl_options options = {.struct_size = sizeof options, .share = SVO_GL_SHARE_COPY};
    prepare_plan(of);
    if (svo_gl_create(world.device, world.context, &options, &of->gl) != SVO_OK) {
        fail_msg("%s", svo_device_message(world.device));
    }
}

static svo_status run_gl_first_build(subject *of)
{
    return build_and_digest(of, svo_gl_frontend(of->gl));
}

static svo_status run_gl_first_builder(subject *of)
{
    return build_in_gl(of, of->gl);
}

/*
 * The runner.
 */

typedef struct scenario {
    const char *name;
    bool gl; /* needs OpenGL */
    bool in_child; /* calls of the import child fail */
    void (*prepare)(subject *of);
    svo_status (*run)(subject *of); /* what it makes it destroys; may run again after a failure */
    void (*look)(subject *of); /* adds to the digest what run leaves; NULL allowed */
    void (*cleanup)(subject *of);
} scenario;

static void violation(const scenario *played, uint64_t index, faults_call failed, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
static void violation(const scenario *played, uint64_t index, faults_call failed, const char *format, ...)
{
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    print_error("%s, call %" PRIu64 ", %s: %s\n", played->name, index, failed.name, text);
    ++world.violations;
}

/* Differences in counts of live objects, as text; empty where there are none. */
static const char *list_lost(const faults_objects *before, const faults_objects *after)
{
    static char text[512];
    size_t length = 0;
    text[0] = '\0';
#define LIST(member, words)                                                                 \
    if (before->member != after->member) {                                                  \
        length += (size_t)snprintf(text + length, sizeof text - length, "%+" PRId64 " %s ", \
                                   after->member - before->member, words);                  \
    }
    FAULTS_OBJECT_LIST(LIST)
#undef LIST
    return text;
}

/* Whether a message says what failed: the call by name or by its error, or what there was no memory for. */
static bool says(const char *message, faults_call failed)
{
    const char *const words[FAULT_KINDS][5] = {
        [FAULT_ALLOCATION] = {"memory", "bytes", "outofmem"},
        [FAULT_OPENCL] = {"CL_OUT_OF_RESOURCES"},
        [FAULT_OPENGL] = {"GL_OUT_OF_MEMORY"},
        [FAULT_EGL] = {"EGL_BAD_ALLOC", "EGL does not list", "the EGL display does not list", "has no function",
                       "is not current"},
        [FAULT_FILE] = {"Input/output error", "Too many open files", "the reader", "cannot be read", "reading needs"},
        [FAULT_PROCESS] = {"Cannot allocate memory", "Invalid argument", "No child processes"},
        [FAULT_LOADER] = {"libEGL", "function egl", "is not current"},
    };
    if (strstr(message, failed.name) != NULL) {
        return true;
    }
    for (size_t i = 0; i < 5 && words[failed.kind][i] != NULL; ++i) {
        if (strstr(message, words[failed.kind][i]) != NULL) {
            return true;
        }
    }
    return false;
}

/* A message begins with the function that the caller called or with the file that it named. */
static bool names_caller(const char *message)
{
    return strncmp(message, "svo_", 4) == 0 || strncmp(message, "/tmp/", 5) == 0;
}

static svo_status run_once(const scenario *played, subject *of)
{
    of->message.text[0] = '\0';
    of->warning[0] = '\0';
    of->digest = 0;
    world.device->message.text[0] = '\0';
    return played->run(of);
}

static void look(const scenario *played, subject *of)
{
    if (played->look != NULL) {
        played->look(of);
    }
}

static void arm(const scenario *played, uint64_t index)
{
    if (!played->in_child) {
        faults_arm(index);
        return;
    }
    char text[32];
    (void)snprintf(text, sizeof text, "%" PRIu64, index);
    assert_int_equal(setenv(CHILD_INDEX_VARIABLE, text, 1), 0);
    (void)unlink(world.report_path);
}

/* What failed in the child: a line of its report. */
static faults_call read_report(void)
{
    static char name[64];
    unsigned kind = 0;
    faults_call failed = {0};
    FILE *file = fopen(world.report_path, "r");
    if (file != NULL) {
        if (fscanf(file, "%u %63s", &kind, name) == 2) {
            failed = (faults_call){name, (fault_kind)kind};
        }
        (void)fclose(file);
    }
    return failed;
}

static faults_call disarm(const scenario *played)
{
    if (!played->in_child) {
        return faults_disarm();
    }
    (void)unsetenv(CHILD_INDEX_VARIABLE);
    return read_report();
}

/* One failed call. Returns false when the scenario had fewer calls. */
static bool play(const scenario *played, uint64_t index, XXH64_hash_t expected)
{
    subject of = {0};
    played->prepare(&of);
    (void)snprintf(world.current, sizeof world.current, "%s, call %" PRIu64, played->name, index);
    alarm(HANG_SECONDS);
    arm(played, index);
    svo_status status = run_once(played, &of);
    const bool in_run = played->in_child || faults_failed().name != NULL;
    if (!in_run) {
        played->cleanup(&of);
    }
    const faults_call failed = disarm(played);
    alarm(0);
    if (failed.name != NULL && getenv("SVOCL_FAULTS_TRACE") != NULL) {
        print_message("%s, call %" PRIu64 ", %s: %s %s\n", played->name, index, failed.name, svo_status_name(status),
                      of.message.text);
    }
    if (in_run) {
        if (status == SVO_OK) {
            look(played, &of);
            world.recovered += failed.name != NULL ? 1 : 0;
            if (of.digest != expected && !says(of.warning, failed)) {
                violation(played, index, failed, "SVO_OK with a wrong result, warning \"%s\"", of.warning);
            }
        } else if (!names_caller(of.message.text) || !says(of.message.text, failed)) {
            violation(played, index, failed, "%s without words on it: \"%s\"", svo_status_name(status),
                      of.message.text);
        }
        status = run_once(played, &of);
        look(played, &of);
        if (status != SVO_OK || of.digest != expected) {
            violation(played, index, failed, "the next run: %s \"%s\"", svo_status_name(status), of.message.text);
        }
        played->cleanup(&of);
    }
    if (failed.name != NULL) {
        ++world.failed_calls[failed.kind];
    }
    return failed.name != NULL;
}

static void play_all(const scenario *played)
{
    subject of = {0};
    if (played->gl && world.context == NULL) {
        print_message("skipped: no OpenGL\n");
        skip();
    }
    played->prepare(&of);
    const svo_status status = run_once(played, &of);
    look(played, &of);
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_status_name(status), of.message.text);
    }
    const XXH64_hash_t expected = of.digest;
    played->cleanup(&of);
    const unsigned violations = world.violations;
    uint64_t index = 0;
    for (uint64_t before_count = 0; index < CALLS_MAX; index += world.stride, ++before_count) {
        const faults_objects before = faults_live;
        const faults_call none = {"?", FAULT_ALLOCATION};
        const bool more = play(played, index, expected);
        const char *lost = list_lost(&before, &faults_live);
        if (lost[0] != '\0') {
            violation(played, index, more && faults_failed().name != NULL ? faults_failed() : none, "left behind: %s",
                      lost);
        }
        if (!more) {
            break;
        }
    }
    print_message("%s: about %" PRIu64 " calls\n", played->name, index);
    assert_in_range(index, 1, CALLS_MAX - 1);
    assert_int_equal(world.violations, violations);
}

static const scenario scenarios[] = {
    {"device", false, false, prepare_nothing, run_device, NULL, destroy_all},
    {"plan", false, false, prepare_nothing, run_plan, NULL, destroy_all},
    {"plan_count", false, false, prepare_plan, run_count, NULL, destroy_all},
    {"mesh_read", false, false, prepare_buffers, run_mesh_read, NULL, cleanup_buffers},
    {"build", false, false, prepare_plan, run_build, NULL, destroy_all},
    {"build_sorted", false, false, prepare_sorted, run_build, NULL, destroy_all},
    {"build_short", false, false, prepare_short, run_build, NULL, destroy_all},
    {"build_chunks", false, false, prepare_chunks, run_build, NULL, destroy_all},
    {"first_build", false, false, prepare_device, run_first_build, NULL, destroy_all},
    {"workspace", false, false, prepare_plan, run_workspace, NULL, destroy_all},
    {"enqueue", false, false, prepare_workspace, run_enqueue, NULL, destroy_all},
    {"rays", false, false, prepare_tree, run_rays, NULL, destroy_all},
    {"rays_enqueue", false, false, prepare_ray_buffers, run_rays_enqueue, NULL, cleanup_ray_buffers},
    {"set_args", false, false, prepare_tree, run_set_args, NULL, destroy_all},
    {"render", false, false, prepare_tree, run_render, NULL, destroy_all},
    {"save", false, false, prepare_host_tree, run_save, digest_saved, destroy_all},
    {"load", false, false, prepare_nothing, run_load, NULL, destroy_all},
    {"voxels", false, false, prepare_nothing, run_voxels, NULL, destroy_all},
    {"upload", false, false, prepare_loaded, run_upload, NULL, destroy_all},
    {"import", false, false, prepare_obj, run_import, NULL, destroy_all},
    {"import_obj", false, true, prepare_obj, run_import, NULL, destroy_all},
    {"import_ply", false, true, prepare_ply, run_import, NULL, destroy_all},
    {"import_stl", false, true, prepare_stl, run_import, NULL, destroy_all},
    {"import_off", false, true, prepare_off, run_import, NULL, destroy_all},
    {"gl_context", true, false, prepare_nothing, run_context, NULL, destroy_all},
    {"gl_wrapped", true, false, prepare_wrapped, run_wrapped, NULL, cleanup_wrapped},
    {"gl_mesh_read", true, false, prepare_nothing, run_gl_mesh_read, NULL, destroy_all},
    {"gl_create", true, false, prepare_nothing, run_gl, NULL, destroy_all},
    {"gl_build_host", true, false, prepare_plan, run_gl_build_host, NULL, destroy_all},
    {"gl_build_copy", true, false, prepare_plan, run_gl_build_copy, NULL, destroy_all},
    {"gl_builder", true, false, prepare_plan, run_gl_builder, NULL, destroy_all},
    {"gl_first_build", true, false, prepare_gl, run_gl_first_build, NULL, destroy_all},
    {"gl_first_builder", true, false, prepare_gl, run_gl_first_builder, NULL, destroy_all},
};
enum { SCENARIOS = sizeof scenarios / sizeof scenarios[0] };

static void play_scenario(void **state)
{
    play_all(*state);
}

/*
 * What scenarios share.
 */

static void say_where(int number)
{
    (void)number;
    static const char words[] = "hangs: ";
    (void)!write(STDERR_FILENO, words, sizeof words - 1);
    (void)!write(STDERR_FILENO, world.current, strlen(world.current));
    (void)!write(STDERR_FILENO, "\n", 1);
    _exit(1);
}

static void write_text(const char *name, const char *text)
{
    char path[160];
    (void)snprintf(path, sizeof path, "%s/%s", world.folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    (void)fputs(text, file);
    assert_int_equal(fclose(file), 0);
}

static void write_meshes(void)
{
    write_text("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\n"
                        "f 1/1 2/2 3/3\nusemtl b\nf 1/1 2/2 4/3\n");
    write_text("a.mtl", "newmtl a\nKd 1 0 0\nmap_Kd a.ppm\nnewmtl b\nKd 0 1 0\n");
    write_text("a.ppm", "P6\n2 2\n255\nabcdefghijkl");
    write_text("a.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                        "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
                        "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    write_text("a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
                        "endloop\nendfacet\nendsolid a\n");
    write_text("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
}

static void make_kernel(void)
{
    const char *sources[] = {svo_tree_kernel_source(), "kernel void empty(SVO_TREE_PARAMETERS) {}"};
    world.program = clCreateProgramWithSource(svo_device_cl_context(world.device), 2, sources, NULL, NULL);
    assert_int_equal(clBuildProgram(world.program, 0, NULL, svo_tree_kernel_options(), NULL, NULL), CL_SUCCESS);
    world.kernel = clCreateKernel(world.program, "empty", NULL);
    assert_non_null(world.kernel);
}

static void make_gl_buffer(void)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(world.context);
    svo_message message = {""};
    assert_int_equal(svo_i_gl_context_make_current(world.context, &message), SVO_OK);
    gl->GenBuffers(1, &world.gl_buffer);
    gl->BindBuffer(GL_COPY_READ_BUFFER, world.gl_buffer);
    gl->BufferData(GL_COPY_READ_BUFFER, sizeof world.rays, world.rays, GL_STATIC_DRAW);
    svo_i_gl_context_release_current(world.context);
}

static void open_gl(void)
{
    svo_message message = {""};
    if (svo_gl_context_create(SVO_GL_SURFACELESS, 0, &world.context, &message) != SVO_OK) {
        print_message("no OpenGL: %s\n", message.text);
        return;
    }
    svo_gl_options options = {.struct_size = sizeof options, .share = SVO_GL_SHARE_HOST};
    if (svo_gl_create(world.device, world.context, &options, &world.host) != SVO_OK) {
        fail_msg("%s", svo_device_message(world.device));
    }
    options.share = SVO_GL_SHARE_COPY;
    if (svo_gl_create(world.device, world.context, &options, &world.copy) != SVO_OK) {
        fail_msg("%s", svo_device_message(world.device));
    }
    make_gl_buffer();
    own_context_make_or_skip(false, &world.own);
    own_context_bind(&world.own, false);
}

static int open_world(void **state)
{
    (void)state;
    svo_message message = {""};
    (void)signal(SIGALRM, say_where);
    if (svo_device_create_default(NULL, &world.device, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    world.queue = clCreateCommandQueue(svo_device_cl_context(world.device), svo_device_cl_device(world.device),
                                       CL_QUEUE_PROFILING_ENABLE, NULL);
    assert_non_null(world.queue);
    assert_int_equal(svo_frontend_create_cl(world.device, &world.cl), SVO_OK);
    attributed_mesh_create(7, TRIANGLES, 0.0, &world.mesh);
    uint64_t random = 3;
    for (size_t i = 0; i < RAYS; ++i) {
        for (size_t axis = 0; axis < 3; ++axis) {
            world.rays[i].origin[axis] = (float)random_unit(&random) * 4.0F - 2.0F;
            world.rays[i].direction[axis] = 0.5F - world.rays[i].origin[axis];
            world.points[i].position[axis] = (float)random_unit(&random);
        }
        world.rays[i].t_max = 10.0F;
        world.points[i].max_distance = 10.0F;
    }
    (void)snprintf(world.folder, sizeof world.folder, "/tmp/test_faults.XXXXXX");
    assert_non_null(mkdtemp(world.folder));
    (void)snprintf(world.obj_path, sizeof world.obj_path, "%s/a.obj", world.folder);
    (void)snprintf(world.ply_path, sizeof world.ply_path, "%s/a.ply", world.folder);
    (void)snprintf(world.stl_path, sizeof world.stl_path, "%s/a.stl", world.folder);
    (void)snprintf(world.off_path, sizeof world.off_path, "%s/a.off", world.folder);
    (void)snprintf(world.vox_path, sizeof world.vox_path, "%s/a.vox", world.folder);
    (void)snprintf(world.tree_path, sizeof world.tree_path, "%s/a.svo", world.folder);
    (void)snprintf(world.packed_path, sizeof world.packed_path, "%s/b.svo", world.folder);
    (void)snprintf(world.report_path, sizeof world.report_path, "%s/report", world.folder);
    assert_int_equal(setenv(CHILD_REPORT_VARIABLE, world.report_path, 1), 0);
    write_meshes();
    make_kernel();
    subject of = {0};
    prepare_host_tree(&of);
    assert_int_equal(run_save(&of), SVO_OK);
    destroy_all(&of);
    open_gl();
    return 0;
}

static int close_world(void **state)
{
    (void)state;
    uint64_t sum = 0;
    print_message("failed calls:");
    for (unsigned i = 0; i < FAULT_KINDS; ++i) {
        print_message(" %s %" PRIu64 ",", fault_kind_name((fault_kind)i), world.failed_calls[i]);
        sum += world.failed_calls[i];
    }
    print_message(" in all %" PRIu64 "; of those without effect on the result %" PRIu64 "\n", sum, world.recovered);
    if (world.context != NULL) {
        own_context_destroy(&world.own);
        svo_message message = {""};
        assert_int_equal(svo_i_gl_context_make_current(world.context, &message), SVO_OK);
        svo_i_gl_context_functions(world.context)->DeleteBuffers(1, &world.gl_buffer);
        svo_i_gl_context_release_current(world.context);
    }
    clReleaseKernel(world.kernel);
    clReleaseProgram(world.program);
    svo_gl_destroy(&world.host);
    svo_gl_destroy(&world.copy);
    svo_gl_context_destroy(&world.context);
    attributed_mesh_destroy(&world.mesh);
    svo_frontend_destroy(&world.cl);
    clReleaseCommandQueue(world.queue);
    svo_device_destroy(&world.device);
    const char *const names[] = {"a.obj", "a.mtl", "a.ppm", "a.ply", "a.stl",
                                 "a.off", "a.svo", "b.svo", "a.vox", "report"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        char path[160];
        (void)snprintf(path, sizeof path, "%s/%s", world.folder, names[i]);
        (void)unlink(path);
    }
    if (rmdir(world.folder) != 0) { /* a temporary file was left */
        print_error("%s is not empty\n", world.folder);
        return -1;
    }
    const char *lost = list_lost(&(faults_objects){0}, &faults_live);
    if (lost[0] != '\0') {
        print_error("left behind at the end: %s\n", lost);
        return -1;
    }
    return 0;
}

/* In the import child: the calls of svo_import_child_main fail. The report is written even where it crashes. */
static void report_child(void)
{
    const faults_call failed = faults_disarm();
    FILE *file = failed.name != NULL ? fopen(getenv(CHILD_REPORT_VARIABLE), "w") : NULL;
    if (file != NULL) {
        (void)fprintf(file, "%u %s\n", (unsigned)failed.kind, failed.name);
        (void)fclose(file);
    }
}

int main(int argc, char **argv)
{
    int exit_code = 0;
    const char *child_index = getenv(CHILD_INDEX_VARIABLE);
    if (child_index != NULL) {
        faults_arm(strtoull(child_index, NULL, 10));
    }
    if (svo_import_child_main(argc, argv, &exit_code) != 0) {
        report_child();
        return exit_code;
    }
    (void)faults_disarm();
    world.stride = argc > 1 ? strtoull(argv[1], NULL, 10) : 20;
    if (world.stride == 0 || argc > 3) {
        (void)fprintf(stderr, "usage: %s [STRIDE [SCENARIO]]\n", argv[0]);
        return 2;
    }
    struct CMUnitTest tests[SCENARIOS];
    size_t count = 0;
    for (size_t i = 0; i < SCENARIOS; ++i) {
        if (argc < 3 || strcmp(argv[2], scenarios[i].name) == 0) {
            tests[count++] = (struct CMUnitTest){.name = scenarios[i].name,
                                                 .test_func = play_scenario,
                                                 .initial_state = (void *)(uintptr_t)&scenarios[i]};
        }
    }
    assert_in_range(count, 1, SCENARIOS);
    return _cmocka_run_group_tests("test_faults", tests, count, open_world, close_world);
}
