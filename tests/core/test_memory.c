/* SPDX-License-Identifier: MIT */
/*
 * Host memory by the caller's functions (svo_memory_callbacks). Scenarios call everything that allocates: what they
 * allocate comes from these functions, nothing from malloc, and it is all given back, with its sizes. Then each
 * scenario runs again and again with another allocation failing: a status with words, and nothing lost.
 */
#define _POSIX_C_SOURCE 200809L
#include <dirent.h>
#include <inttypes.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "core/memory.h"
#include "memory_voxels.h"
#include "support/attributed_mesh.h"
#include "support/gl_contexts.h"
#include "support/info_of.h"
#include "support/memory_ledger.h"
#include "support/work_folder.h"
#include "svocl/io.h"
#include "svocl/svocl.h"
#ifdef HAVE_GL
#include "support/suite.h"
#include "svocl/gl.h"
#endif

enum { TRIANGLES = 40, DEPTH = 3, RAYS = 8, SIDE = 16, INDICES_MAX = 2000 };

/* Everything that a scenario makes. */
typedef struct subject {
    svo_device *device;
    cl_command_queue queue;
    svo_frontend *frontend;
    svo_plan *plan;
    svo_tree *tree;
    svo_workspace *workspace;
    svo_mesh_copy *copy;
    svo_import *import;
    memory_voxels voxels;
    cl_mem positions;
#ifdef HAVE_GL
    svo_gl_context *context;
    svo_gl *gl;
#endif
    svo_message message;
} subject;

static attributed_mesh mesh;

/* The device of a scenario's plays: loading kernels for each of them would take most of the test's time. */
static struct {
    bool is_wanted;
    svo_device *device;
    uint64_t blocks; /* live ones between two plays */
} shared;

static const svo_plan_options everything = {.struct_size = sizeof everything, .need = SVO_NEED_ALL};

static svo_status of_device(subject *of, svo_status status)
{
    if (status != SVO_OK) {
        (void)snprintf(of->message.text, sizeof of->message.text, "%s", svo_device_message(of->device));
    }
    return status;
}

#define TRY_DEVICE(call) SVO_I_TRY(of_device(of, (call)))

/* The struct of the functions is gone after the call. */
static svo_status make_device(subject *of, uint64_t max_device_bytes)
{
    svo_memory_callbacks passing = ledger_callbacks;
    const svo_device_options options = {
        .struct_size = sizeof options, .max_device_bytes = max_device_bytes, .memory = &passing};
    const svo_status status = svo_device_create_default(&options, &of->device, &of->message);
    memset(&passing, 0, sizeof passing);
    return status;
}

static void release_all(subject *of)
{
    memory_voxels_destroy(&of->voxels);
    svo_import_destroy(&of->import);
    svo_mesh_copy_destroy(&of->copy);
    svo_tree_destroy(&of->tree);
    svo_workspace_destroy(&of->workspace);
    svo_plan_destroy(&of->plan);
    svo_frontend_destroy(&of->frontend);
#ifdef HAVE_GL
    svo_gl_destroy(&of->gl);
#endif
    if (of->positions != NULL) {
        clReleaseMemObject(of->positions);
    }
    if (of->queue != NULL) {
        clReleaseCommandQueue(of->queue);
    }
    if (of->device != shared.device) {
        svo_device_destroy(&of->device);
    }
#ifdef HAVE_GL
    svo_gl_context_destroy(&of->context);
#endif
}

/* ---- scenarios ----
   Each prepares what it needs, and then runs the calls that may fail. */

static svo_status prepare_nothing(subject *of)
{
    (void)of;
    return SVO_OK;
}

/* With the kernels that an earlier scenario saved, which compile much faster. */
static svo_status prepare_own_device(subject *of)
{
    SVO_I_TRY(make_device(of, 0));
    return of_device(of, svo_device_load_kernels(of->device, path_of("kernels"), NULL));
}

static svo_status prepare_device(subject *of)
{
    of->device = shared.device;
    if (of->device == NULL) {
        SVO_I_TRY(prepare_own_device(of));
        shared.device = shared.is_wanted ? of->device : NULL;
    }
    return SVO_OK;
}

static svo_status prepare_limited_device(subject *of)
{
    SVO_I_TRY(make_device(of, UINT64_C(1) << 30));
    return of_device(of, svo_device_load_kernels(of->device, path_of("kernels"), NULL));
}

static svo_status prepare_plan(subject *of)
{
    SVO_I_TRY(prepare_device(of));
    return of_device(of, svo_plan_create(of->device, &mesh.mesh, DEPTH, &everything, &of->plan));
}

static svo_status prepare_tree(subject *of)
{
    SVO_I_TRY(prepare_plan(of));
    return of_device(of, svo_build(of->plan, NULL, NULL, &of->tree, NULL));
}

static svo_status prepare_host_tree(subject *of)
{
    SVO_I_TRY(prepare_tree(of));
    return of_device(of, svo_tree_download(of->tree, NULL));
}

static svo_status run_create(subject *of)
{
    svo_device *second = NULL;
    const svo_device_options options = {.struct_size = sizeof options, .memory = &ledger_callbacks};
    SVO_I_TRY(make_device(of, UINT64_C(1) << 30));
    TRY_DEVICE(svo_frontend_create_cl(of->device, &of->frontend));
    const svo_status status = svo_device_create(info_of_device(of->device).context, info_of_device(of->device).device,
                                                &options, &second, &of->message);
    svo_device_destroy(&second);
    return status;
}

static svo_status run_build(subject *of)
{
    TRY_DEVICE(svo_plan_create(of->device, &mesh.mesh, DEPTH, &everything, &of->plan));
    TRY_DEVICE(svo_plan_count(of->plan, NULL, NULL));
    TRY_DEVICE(svo_build(of->plan, NULL, NULL, &of->tree, NULL));
    return of_device(of, svo_tree_download(of->tree, NULL));
}

/* Many chunks, sorted, with a capacity that is too small. */
static svo_status run_chunks(subject *of)
{
    svo_plan_options options = everything;
    options.chunk_bytes = 16384;
    options.builder = SVO_BUILDER_SORTED;
    TRY_DEVICE(svo_plan_create(of->device, &mesh.mesh, DEPTH + 2, &options, &of->plan));
    TRY_DEVICE(svo_build(of->plan, NULL, NULL, &of->tree, NULL));
    return SVO_OK;
}

static svo_status run_workspace(subject *of)
{
    TRY_DEVICE(svo_frontend_create_cl(of->device, &of->frontend));
    TRY_DEVICE(svo_workspace_create(of->plan, of->frontend, of->queue, NULL, &of->workspace));
    TRY_DEVICE(svo_workspace_make_tree(of->workspace, &of->tree));
    TRY_DEVICE(svo_build_enqueue(of->workspace, of->tree, &(svo_submit){.queue = of->queue}));
    TRY_DEVICE(svo_tree_finish(of->tree, of->queue, 1, NULL));
    return of_device(of, svo_tree_download(of->tree, of->queue));
}

static svo_status prepare_workspace(subject *of)
{
    SVO_I_TRY(prepare_plan(of));
    of->queue = clCreateCommandQueue(info_of_device(of->device).context, info_of_device(of->device).device, 0, NULL);
    return of->queue != NULL ? SVO_OK : SVO_CL_ERROR;
}

static svo_status run_rays(subject *of)
{
    svo_ray rays[RAYS];
    svo_hit hits[RAYS];
    svo_query_point points[RAYS];
    svo_nearest nearest[RAYS];
    for (size_t i = 0; i < RAYS; ++i) {
        rays[i] = (svo_ray){.origin = {-1.0F, 0.1F * (float)i, 0.5F}, .direction = {1.0F, 0.0F, 0.0F}, .t_max = 9.0F};
        points[i] = (svo_query_point){.position = {0.1F * (float)i, 0.5F, 0.5F}, .max_distance = 9.0F};
    }
    TRY_DEVICE(svo_trace_triangles(svo_tree_target(of->tree), svo_in_host(rays), svo_in_host(hits), RAYS,
                                   SVO_TRACE_CLOSEST, NULL));
    return of_device(of, svo_tree_nearest(of->tree, svo_in_host(points), svo_in_host(nearest), RAYS, NULL));
}

static svo_status run_render(subject *of)
{
    uint8_t picture[SIDE * SIDE * 4];
    svo_render_options options = {.struct_size = sizeof options, .width = SIDE, .height = SIDE};
    (void)svo_camera_fit(svo_tree_target(of->tree), 1.0F, &options.camera);
    TRY_DEVICE(svo_render(svo_tree_target(of->tree), &options, svo_in_host(picture), NULL));
    options.view = SVO_VIEW_TRIANGLES;
    return of_device(of, svo_render(svo_tree_target(of->tree), &options, svo_in_host(picture), NULL));
}

static svo_status run_save(subject *of)
{
    const svo_save_options packed = {.struct_size = sizeof packed, .compress = 1};
    SVO_I_TRY(svo_tree_save(of->tree, svo_to_path(path_of("a.svo")), NULL, &of->message));
    return svo_tree_save(of->tree, svo_to_path(path_of("b.svo")), &packed, &of->message);
}

static svo_status run_load(subject *of)
{
    svo_memory_callbacks passing = ledger_callbacks;
    const svo_load_options options = {.struct_size = sizeof options, .memory = &passing};
    SVO_I_TRY(svo_tree_load(svo_from_path(path_of("a.svo")), &options, &of->tree, &of->message));
    svo_tree_destroy(&of->tree);
    const svo_status status = svo_tree_load(svo_from_path(path_of("b.svo")), &options, &of->tree, &of->message);
    memset(&passing, 0, sizeof passing);
    SVO_I_TRY(status);
    TRY_DEVICE(svo_tree_upload(of->tree, of->device, NULL));
    return of_device(of, svo_tree_make_bvh(of->tree, SVO_BVH_BEST, NULL));
}

/* From memory, into a tree that outlives everything else. */
static svo_status run_load_memory(subject *of)
{
    static uint8_t bytes[1 << 20];
    const svo_load_options options = {.struct_size = sizeof options, .memory = &ledger_callbacks};
    FILE *file = fopen(path_of("b.svo"), "rb");
    assert_non_null(file);
    const size_t byte_count = fread(bytes, 1, sizeof bytes, file);
    (void)fclose(file);
    assert_in_range(byte_count, 1, sizeof bytes - 1);
    return svo_tree_load(svo_from_memory(bytes, byte_count, "b"), &options, &of->tree, &of->message);
}

static svo_status run_import(subject *of)
{
    svo_memory_callbacks passing = ledger_callbacks;
    const svo_import_options options = {.struct_size = sizeof options, .memory = &passing};
    const svo_status status = svo_import_file(path_of("a.obj"), &options, NULL, NULL, &of->import, &of->message);
    memset(&passing, 0, sizeof passing);
    return status;
}

static svo_status prepare_buffers(subject *of)
{
    static const uint16_t corners[9] = {0, 1, 2, 0, 1, 2, 0, 1, 2};
    SVO_I_TRY(prepare_workspace(of));
    of->positions = clCreateBuffer(info_of_device(of->device).context, CL_MEM_COPY_HOST_PTR, sizeof corners,
                                   (void *)(uintptr_t)corners, NULL);
    return of->positions != NULL ? SVO_OK : SVO_CL_ERROR;
}

/* Indices of 16 bits are widened, which takes another array. */
static svo_status run_mesh_read(subject *of)
{
    const svo_mesh_buffers buffers = {.struct_size = sizeof buffers,
                                      .vertex_count = 1,
                                      .triangle_count = 3,
                                      .positions = {.memory = of->positions},
                                      .indices = {.memory = of->positions},
                                      .index_bytes = 2,
                                      .memory = &ledger_callbacks};
    return svo_mesh_read(&buffers, of->queue, 0, NULL, &of->copy, &of->message);
}

/* Of each two voxels in one place one stays; then less memory would do. */
static svo_status run_voxels(subject *of)
{
    return memory_voxels_make(&of->voxels, true, &of->message);
}

static svo_status prepare_voxels(subject *of)
{
    return memory_voxels_make(&of->voxels, false, &of->message);
}

static svo_status prepare_voxels_device(subject *of)
{
    SVO_I_TRY(prepare_voxels(of));
    return prepare_device(of);
}

static svo_status run_voxels_build(subject *of)
{
    TRY_DEVICE(svo_voxels_build(of->device, of->voxels.list, 0, NULL, NULL, &of->tree, NULL));
    TRY_DEVICE(svo_tree_download(of->tree, NULL));
    return svo_tree_get_voxels(of->tree, &of->voxels.again, &of->message);
}

static svo_status run_voxels_write(subject *of)
{
    return memory_voxels_write(&of->voxels, path_of("a.vox"), &of->message);
}

static svo_status run_voxels_load(subject *of)
{
    SVO_I_TRY(memory_voxels_load_path(&of->voxels, path_of("a.vox"), &of->message));
    svo_voxels_destroy(&of->voxels.again);
    SVO_I_TRY(memory_voxels_load(&of->voxels, SVO_VOXEL_FORMAT_VOX, &of->message));
    svo_voxels_destroy(&of->voxels.again);
    if (memory_voxels_have(SVO_VOXEL_FORMAT_NVDB)) {
        SVO_I_TRY(memory_voxels_load(&of->voxels, SVO_VOXEL_FORMAT_NVDB, &of->message));
        svo_voxels_destroy(&of->voxels.again);
    }
    return memory_voxels_load(&of->voxels, SVO_VOXEL_FORMAT_BINVOX, &of->message);
}

static svo_status run_svx_load(subject *of)
{
    return memory_voxels_load(&of->voxels, SVO_VOXEL_FORMAT_SVX, &of->message);
}

/* Every kernel that the scenarios need. */
static svo_status prepare_built(subject *of)
{
    SVO_I_TRY(prepare_voxels(of));
    SVO_I_TRY(prepare_own_device(of));
    SVO_I_TRY(run_voxels_build(of));
    svo_tree_destroy(&of->tree);
    SVO_I_TRY(run_chunks(of));
    svo_tree_destroy(&of->tree);
    svo_plan_destroy(&of->plan);
    SVO_I_TRY(run_build(of));
    SVO_I_TRY(run_rays(of));
    SVO_I_TRY(run_render(of));
    svo_tree_destroy(&of->tree);
    svo_plan_destroy(&of->plan);
    return SVO_OK;
}

static svo_status run_kernels(subject *of)
{
    TRY_DEVICE(svo_device_save_kernels(of->device, path_of("kernels"), NULL));
    svo_device_destroy(&of->device);
    return prepare_own_device(of);
}

#ifdef HAVE_GL
static svo_status run_context(subject *of)
{
    const svo_gl_context_options options = {.struct_size = sizeof options, .memory = &ledger_callbacks};
    return svo_gl_context_create(&options, &of->context, &of->message);
}

static svo_status run_named_context(subject *of)
{
    const svo_gl_context_options options = {
        .struct_size = sizeof options, .memory = &ledger_callbacks, .device_name = "llvmpipe"};
    return svo_gl_context_create(&options, &of->context, &of->message);
}

static svo_status prepare_gl(subject *of)
{
    SVO_I_TRY(prepare_plan(of));
    return run_context(of);
}

static svo_status run_gl(subject *of)
{
    TRY_DEVICE(svo_gl_create(of->device, of->context, NULL, &of->gl));
    TRY_DEVICE(svo_build(of->plan, svo_gl_frontend(of->gl), NULL, &of->tree, NULL));
    svo_tree_destroy(&of->tree);
    return of_device(of, svo_gl_build(of->gl, of->plan, NULL, &of->tree, NULL));
}
#endif

typedef struct scenario {
    const char *name;
    svo_status (*prepare)(subject *of);
    svo_status (*run)(subject *of);
    unsigned stride; /* every how-manieth allocation fails after the first 16 */
    bool goes_on; /* some allocations are for what can be done without */
    bool has_others; /* stb_image allocates its own */
    bool own_devices; /* for each play: its calls are the first that ask for their kernels */
} scenario;

/* The first makes the kernels' folder and the files of the others. */
static const scenario scenarios[] = {
    {"kernels", prepare_built, run_kernels, 7, true, false, false},
    {"create", prepare_nothing, run_create, 1, false, false, false},
    {"build", prepare_device, run_build, 1, false, false, false},
    {"limited build", prepare_limited_device, run_build, 4, false, false, true},
    {"chunks", prepare_device, run_chunks, 5, false, false, false},
    {"workspace", prepare_workspace, run_workspace, 1, false, false, false},
    {"rays", prepare_tree, run_rays, 1, false, false, true},
    {"render", prepare_tree, run_render, 1, false, false, true},
    {"save", prepare_host_tree, run_save, 1, true, false, false},
    {"load", prepare_device, run_load, 1, false, false, false},
    {"load from memory", prepare_nothing, run_load_memory, 1, false, false, false},
    {"import", prepare_nothing, run_import, 1, false, false, false},
    {"mesh read", prepare_buffers, run_mesh_read, 1, false, false, false},
    {"voxels", prepare_nothing, run_voxels, 1, true, false, false},
    {"voxels to a tree and back", prepare_voxels_device, run_voxels_build, 1, false, false, false},
    {"voxels to files", prepare_voxels, run_voxels_write, 1, false, false, false},
    {"voxels from files", prepare_nothing, run_voxels_load, 1, false, false, false},
    {"voxels from .svx", prepare_nothing, run_svx_load, 1, false, true, false},
#ifdef HAVE_GL
    {"context", prepare_nothing, run_context, 50, false, false, false},
    {"named context", prepare_nothing, run_named_context, 50, false, false, false},
    {"gl", prepare_gl, run_gl, 9, true, false, false},
#endif
};

/* ---- the runs ---- */

/* Runs with the fail_at-th allocation failing. Returns what the ledger has of it. */
static ledger_counts play(const scenario *of, uint64_t fail_at)
{
    subject s = {.message = {""}};
    if (of->prepare(&s) != SVO_OK) {
        fail_msg("%s: %s", of->name, s.message.text);
    }
    s.message.text[0] = '\0';
    ledger_begin(fail_at);
    const svo_status status = of->run(&s);
    const ledger_counts counts = ledger_end();
    const bool went_on = status == SVO_OK && counts.failed && of->goes_on;
    if (status != (counts.failed && !went_on ? SVO_OUT_OF_HOST_MEMORY : SVO_OK) ||
        (status != SVO_OK && strchr(s.message.text, ':') == NULL)) {
        fail_msg("%s, allocation %" PRIu64 "%s: %s, '%s'", of->name, fail_at, counts.failed ? " fails" : "",
                 svo_name(SVO_NAME_STATUS, status), s.message.text);
    }
    release_all(&s);
    const uint64_t live = ledger_settle(shared.blocks);
    if (live > shared.blocks) {
        fail_msg("%s, allocation %" PRIu64 ": %" PRIu64 " blocks were lost", of->name, fail_at, live - shared.blocks);
    }
    shared.blocks = live;
    return counts;
}

static bool can_run(const scenario *of)
{
    if (of->run == run_svx_load) {
        return memory_voxels_have(SVO_VOXEL_FORMAT_SVX);
    }
#ifdef HAVE_GL
    svo_gl_context *context = NULL;
    const bool needs_gl = of->run == run_context || of->run == run_named_context || of->run == run_gl;
    const svo_status status = !needs_gl                      ? SVO_OK
                              : of->run == run_named_context ? context_of_name("llvmpipe", &context, NULL)
                                                             : context_of_kind(SVO_GL_SURFACELESS, 0, &context, NULL);
    svo_gl_context_destroy(&context);
    return status == SVO_OK;
#else
    (void)of;
    return true;
#endif
}

static void check_scenario(void **state)
{
    const scenario *of = *state;
    if (!can_run(of)) {
        print_message("%s: no OpenGL or no .svx files here\n", of->name);
        skip();
    }
    const ledger_counts whole = play(of, LEDGER_NEVER);
    assert_true(whole.allocations > 0);
    assert_true(whole.others == 0 || of->has_others); /* 0 without svocl_watch_malloc always */
    if (!of->own_devices) {
        shared.is_wanted = true;
        shared.blocks = UINT64_MAX;
        play(of, LEDGER_NEVER); /* the device has all that its calls make for it */
    }
    uint64_t failures = 0;
    bool failed = true;
    for (uint64_t i = 0; failed && i < INDICES_MAX; i += i < 16 ? 1 : of->stride) {
        const ledger_counts counts = play(of, i);
        failed = counts.failed;
        failures += failed ? 1 : 0;
        assert_true(counts.others == 0 || of->has_others);
    }
    assert_false(failed);
    svo_device_destroy(&shared.device);
    shared.is_wanted = false;
    shared.blocks = 0;
    const ledger_counts end = ledger_end();
    assert_int_equal(end.live_bytes, 0);
    if (end.wrong != NULL) {
        fail_msg("%s: %s", of->name, end.wrong);
    }
    print_message("%s: %" PRIu64 " allocations, the largest of %zu bytes; %" PRIu64 " were made to fail\n", of->name,
                  whole.allocations, whole.largest_bytes, failures);
}

/* ---- other tests ---- */

/* zstd's context is among what a compressed file takes, and larger than all of this tree. */
static void zstd_allocates_there_too(void **state)
{
    (void)state;
    const scenario plain = {"load", prepare_nothing, run_load_memory, 1, false, false, false};
    const ledger_counts counts = play(&plain, LEDGER_NEVER);
    assert_true(counts.largest_bytes > 65536);
}

/* Live bytes are those of the handles, and grow with them. */
static void handles_hold_their_bytes(void **state)
{
    (void)state;
    subject s = {.message = {""}};
    assert_int_equal(prepare_device(&s), SVO_OK);
    const uint64_t device_bytes = ledger_end().live_bytes;
    assert_true(device_bytes > 0);
    assert_int_equal(svo_plan_create(s.device, &mesh.mesh, DEPTH, NULL, &s.plan), SVO_OK);
    const uint64_t plan_bytes = ledger_end().live_bytes - device_bytes;
    assert_true(plan_bytes >= mesh.mesh.vertex_count * 12 + mesh.mesh.triangle_count * 12);
    svo_plan_destroy(&s.plan);
    assert_int_equal(ledger_end().live_bytes, device_bytes);
    release_all(&s);
    assert_int_equal(ledger_end().live_bytes, 0);
}

typedef svo_status (*use_memory)(const svo_memory_callbacks *memory, svo_message *message);

static svo_status use_in_device(const svo_memory_callbacks *memory, svo_message *message)
{
    subject s = {.message = {""}};
    const svo_device_options options = {.struct_size = sizeof options, .memory = memory};
    assert_int_equal(make_device(&s, 0), SVO_OK);
    svo_device *made = NULL;
    const svo_status status =
        svo_device_create(info_of_device(s.device).context, info_of_device(s.device).device, &options, &made, message);
    svo_device_destroy(&made);
    release_all(&s);
    return status;
}

static svo_status use_in_default_device(const svo_memory_callbacks *memory, svo_message *message)
{
    const svo_device_options options = {.struct_size = sizeof options, .memory = memory};
    svo_device *made = NULL;
    const svo_status status = svo_device_create_default(&options, &made, message);
    svo_device_destroy(&made);
    return status;
}

static svo_status use_in_load(const svo_memory_callbacks *memory, svo_message *message)
{
    const svo_load_options options = {.struct_size = sizeof options, .memory = memory};
    svo_tree *made = NULL;
    const svo_status status = svo_tree_load(svo_from_path(path_of("a.svo")), &options, &made, message);
    svo_tree_destroy(&made);
    return status;
}

static svo_status use_in_load_memory(const svo_memory_callbacks *memory, svo_message *message)
{
    const svo_load_options options = {.struct_size = sizeof options, .memory = memory};
    svo_tree *made = NULL;
    const svo_status status = svo_tree_load(svo_from_memory("", 1, "name"), &options, &made, message);
    return status == SVO_FILE_DAMAGED ? SVO_OK : status; /* that comes after the options */
}

static svo_status use_in_import(const svo_memory_callbacks *memory, svo_message *message)
{
    const svo_import_options options = {.struct_size = sizeof options, .memory = memory};
    svo_import *made = NULL;
    const svo_status status = svo_import_file(path_of("a.obj"), &options, NULL, NULL, &made, message);
    svo_import_destroy(&made);
    return status;
}

static svo_status use_in_voxels(const svo_memory_callbacks *memory, svo_message *message)
{
    const svo_voxels_source source = {.struct_size = sizeof source, .memory = memory};
    svo_voxels *made = NULL;
    const svo_status status = svo_voxels_create(&source, &made, message);
    svo_voxels_destroy(&made);
    return status;
}

static svo_status use_in_voxels_load(const svo_memory_callbacks *memory, svo_message *message)
{
    const svo_voxels_load_options options = {.struct_size = sizeof options, .memory = memory};
    svo_voxels *made = NULL;
    const svo_status status = svo_voxels_load(svo_from_path(path_of("a.vox")), &options, &made, NULL, message);
    svo_voxels_destroy(&made);
    return status;
}

static svo_status use_in_voxels_load_memory(const svo_memory_callbacks *memory, svo_message *message)
{
    const svo_voxels_load_options options = {.struct_size = sizeof options, .memory = memory};
    svo_voxels *made = NULL;
    const svo_status status = svo_voxels_load(svo_from_memory("", 1, "name"), &options, &made, NULL, message);
    return status == SVO_FILE_DAMAGED ? SVO_OK : status; /* that comes after the options */
}

static svo_status use_in_mesh_read(const svo_memory_callbacks *memory, svo_message *message)
{
    subject s = {.message = {""}};
    assert_int_equal(prepare_buffers(&s), SVO_OK);
    const svo_mesh_buffers buffers = {.struct_size = sizeof buffers, .memory = memory};
    const svo_status status = svo_mesh_read(&buffers, s.queue, 0, NULL, &s.copy, message);
    release_all(&s);
    return status;
}

#ifdef HAVE_GL
static svo_status use_in_context(const svo_memory_callbacks *memory, svo_message *message)
{
    const svo_gl_context_options options = {.struct_size = sizeof options, .memory = memory};
    svo_gl_context *made = NULL;
    const svo_status status = svo_gl_context_create(&options, &made, message);
    svo_gl_context_destroy(&made);
    return status == SVO_NO_GL ? SVO_OK : status;
}

static svo_status use_in_named_context(const svo_memory_callbacks *memory, svo_message *message)
{
    const svo_gl_context_options options = {.struct_size = sizeof options, .memory = memory, .device_name = "0"};
    svo_gl_context *made = NULL;
    const svo_status status = svo_gl_context_create(&options, &made, message);
    svo_gl_context_destroy(&made);
    return status == SVO_NO_GL ? SVO_OK : status;
}

static svo_gl_function no_function(void *user, const char *name)
{
    (void)user;
    (void)name;
    return NULL;
}

static svo_status use_in_wrap(const svo_memory_callbacks *memory, svo_message *message)
{
    const svo_gl_context_options options = {
        .struct_size = sizeof options, .memory = memory, .kind = SVO_GL_WRAPPED, .get_proc_address = no_function};
    svo_gl_context *made = NULL;
    const svo_status status = svo_gl_context_create(&options, &made, message);
    return status == SVO_NO_GL ? SVO_OK : status;
}
#endif

static const struct {
    use_memory use;
    const char *function, *argument;
} users[] = {
    {use_in_device, "svo_device_create", "options.memory"},
    {use_in_default_device, "svo_device_create_default", "options.memory"},
    {use_in_load, "svo_tree_load", "options.memory"},
    {use_in_load_memory, "svo_tree_load", "options.memory"},
    {use_in_import, "svo_import_file", "options.memory"},
    {use_in_voxels, "svo_voxels_create", "source.memory"},
    {use_in_voxels_load, "svo_voxels_load", "options.memory"},
    {use_in_voxels_load_memory, "svo_voxels_load", "options.memory"},
    {use_in_mesh_read, "svo_mesh_read", "buffers.memory"},
#ifdef HAVE_GL
    {use_in_context, "svo_gl_context_create", "options.memory"},
    {use_in_named_context, "svo_gl_context_create", "options.memory"},
    {use_in_wrap, "svo_gl_context_create", "options.memory"},
#endif
};

static void assert_refused(size_t user, const svo_memory_callbacks *memory, const char *what)
{
    svo_message message = {""};
    char expected[128];
    (void)snprintf(expected, sizeof expected, "%s: %s%s", users[user].function, users[user].argument, what);
    assert_int_equal(users[user].use(memory, &message), SVO_INVALID_ARGUMENT);
    if (strncmp(message.text, expected, strlen(expected)) != 0) {
        fail_msg("'%s' does not begin with '%s'", message.text, expected);
    }
}

static void functions_come_in_pairs(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof users / sizeof users[0]; ++i) {
        svo_message message = {""};
        svo_memory_callbacks memory = ledger_callbacks;
        if (users[i].use(&memory, &message) != SVO_OK || users[i].use(NULL, &message) != SVO_OK) {
            fail_msg("%s: %s", users[i].function, message.text);
        }
        memory.allocate = NULL;
        assert_refused(i, &memory, "->allocate is NULL");
        memory = ledger_callbacks;
        memory.release = NULL;
        assert_refused(i, &memory, "->release is NULL");
        memory = ledger_callbacks;
        memory.struct_size = sizeof memory - 8;
        assert_refused(i, &memory, ".struct_size is 24, not in 32 .. 32");
        memory.struct_size = sizeof memory + 8;
        assert_refused(i, &memory, ".struct_size is 40, not in 32 .. 32");
    }
    assert_int_equal(ledger_settle(0), 0);
}

/* ---- lib/core/memory.c ---- */

static void check_blocks(const svo_i_memory *memory)
{
    unsigned char *block = svo_i_alloc_zeroed(memory, 3, 100);
    assert_non_null(block);
    assert_int_equal((uintptr_t)block % 16, 0);
    for (unsigned i = 0; i < 300; ++i) {
        assert_int_equal(block[i], 0);
        block[i] = (unsigned char)(i * 7);
    }
    const size_t sizes[] = {301, 100000, 1, 300};
    for (unsigned k = 0; k < 4; ++k) {
        block = svo_i_grow(NULL, block, sizes[k]); /* stays with its functions */
        assert_non_null(block);
        for (unsigned i = 0; i < (k < 2 ? 300U : 1U); ++i) {
            assert_int_equal(block[i], (unsigned char)(i * 7));
        }
    }
    assert_null(svo_i_grow(NULL, block, SIZE_MAX - 8));
    assert_int_equal(block[0], 0);
    svo_i_free(block);
    char *copy = svo_i_copy_text(memory, "words");
    assert_string_equal(copy, "words");
    svo_i_free(copy);
    void *empty = svo_i_alloc(memory, 0);
    assert_non_null(empty);
    svo_i_free(empty);
    block = svo_i_grow(memory, NULL, 5);
    assert_non_null(block);
    svo_i_free(block);
    svo_i_free(NULL);
    assert_null(svo_i_alloc(memory, SIZE_MAX));
    assert_null(svo_i_alloc_zeroed(memory, SIZE_MAX / 2, 3));
    assert_null(svo_i_alloc_zeroed(memory, 1, SIZE_MAX - 8));
}

static void blocks_grow_and_are_zeroed(void **state)
{
    (void)state;
    const svo_i_memory standard = {NULL, NULL, NULL};
    svo_i_memory memory;
    check_blocks(NULL);
    check_blocks(&standard);
    assert_int_equal(svo_i_memory_read(NULL, "f", "a", &ledger_callbacks, &memory), SVO_OK);
    check_blocks(&memory);
    assert_int_equal(ledger_end().live_bytes, 0);
    assert_null(ledger_end().wrong);
}

/* A block that cannot grow is as it was. */
static void a_block_survives_a_failed_growth(void **state)
{
    (void)state;
    svo_i_memory memory;
    assert_int_equal(svo_i_memory_read(NULL, "f", "a", &ledger_callbacks, &memory), SVO_OK);
    char *text = svo_i_copy_text(&memory, "words");
    assert_non_null(text);
    ledger_begin(0);
    assert_null(svo_i_grow(&memory, text, 1000));
    assert_true(ledger_end().failed);
    assert_string_equal(text, "words");
    svo_i_free(text);
    assert_int_equal(ledger_end().live_bytes, 0);
}

/* ---- the program ---- */

static int set_up(void **state)
{
    if (work_folder_make(state) != 0) {
        return -1;
    }
    attributed_mesh_create(7, TRIANGLES, 0.0, &mesh);
    write_text("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\n"
                        "f 1/1 2/2 3/3\nusemtl b\nf 1/1 2/2 4/3\n");
    write_text("a.mtl", "newmtl a\nKd 1 0 0\nmap_Kd a.ppm\nnewmtl b\nKd 0 1 0\n");
    write_text("a.ppm", "P6\n2 2\n255\nabcdefghijkl");
    work_folder_remember("a.svo");
    work_folder_remember("b.svo");
    work_folder_remember("a.vox");
    return 0;
}

static int tear_down(void **state)
{
    char name[64];
    DIR *entries = opendir(path_of("kernels"));
    for (const struct dirent *entry = entries != NULL ? readdir(entries) : NULL; entry != NULL;
         entry = readdir(entries)) {
        if (entry->d_name[0] != '.') {
            (void)snprintf(name, sizeof name, "kernels/%.50s", entry->d_name);
            (void)unlink(path_of(name));
        }
    }
    if (entries != NULL) {
        (void)closedir(entries);
    }
    (void)rmdir(path_of("kernels"));
    attributed_mesh_destroy(&mesh);
    return work_folder_remove(state);
}

TEST_GROUP(memory)
{
    enum { SCENARIOS = sizeof scenarios / sizeof scenarios[0] };
    const struct CMUnitTest others[] = {
        cmocka_unit_test(blocks_grow_and_are_zeroed), cmocka_unit_test(a_block_survives_a_failed_growth),
        cmocka_unit_test(zstd_allocates_there_too), cmocka_unit_test(handles_hold_their_bytes),
        cmocka_unit_test(functions_come_in_pairs)};
    enum { OTHERS = sizeof others / sizeof others[0] };
    struct CMUnitTest tests[SCENARIOS + OTHERS];
    for (size_t i = 0; i < SCENARIOS; ++i) {
        tests[i] = (struct CMUnitTest){
            .name = scenarios[i].name, .test_func = check_scenario, .initial_state = (void *)(uintptr_t)&scenarios[i]};
    }
    memcpy(tests + SCENARIOS, others, sizeof others);
    return cmocka_run_group_tests_name("memory", tests, set_up, tear_down);
}
