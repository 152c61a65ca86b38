/* SPDX-License-Identifier: MIT */
/*
 * The host passes each kernel the arguments that its source declares: before every launch, each argument was set once,
 * with the size of its type. Builds and queries launch every kernel of the library.
 *
 * The linker puts this file between svocl and the OpenCL loader (ld --wrap, in CMakeLists.txt). Programs are compiled
 * with -cl-kernel-arg-info, which records argument types; svocl itself does not use it.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "core/kernel_text.h"
#include "light/radiance_filter.h"
#include "rays/rays.h"
#include "shared/bvh_layout.h"
#include "shared/light_layout.h"
#include "shared/moving_layout.h"
#include "shared/probe_layout.h"
#include "shared/scene_layout.h"
#include "shared/sdf_layout.h"
#include "shared/solid_layout.h"
#include "support/fixture.h"
#include "support/info_of.h"
#include "support/meshes.h"
#include "support/solid_meshes.h"
#include "support/suite.h"

#define KERNELS_MAX   256
#define HANDLES_MAX   256 /* cl_kernel handles, live or released */
#define ARGUMENTS_MAX 32
#define NAME_BYTES    64
#define DEPTH         5

/* All files of kernels, made by cmake/embed.cmake. */
extern const svo_i_kernel_text *const kernel_files[];

typedef struct passed_argument {
    unsigned times; /* how often it was set since the last launch */
    size_t bytes;
    bool is_null; /* no value: local memory */
} passed_argument;

typedef struct noted_kernel {
    cl_kernel handle;
    char name[NAME_BYTES];
    cl_uint argument_count;
    bool launched; /* at least once: unchanged arguments remain set */
    passed_argument arguments[ARGUMENTS_MAX];
} noted_kernel;

static struct {
    noted_kernel kernels[HANDLES_MAX];
    size_t kernel_count;
    char launched[KERNELS_MAX][NAME_BYTES];
    size_t launched_count;
} notes;

/* ---- conditions of a launch ---- */

/* Bytes of a parameter that is passed by value. */
static size_t bytes_of_type(const char *type)
{
    static const struct {
        const char *name;
        size_t bytes;
    } types[] = {
        {"uint", sizeof(cl_uint)},     {"ulong", sizeof(cl_ulong)},     {"float", sizeof(cl_float)},
        {"float4", sizeof(cl_float4)}, {"double4", sizeof(cl_double4)},
#define RECORD(record, items, first) {#record, sizeof(record)},
#define SCALAR(record, items, field)
#define ARRAY(record, items, field)
#include "layout_fields.h"
    };
    for (size_t i = 0; i < sizeof types / sizeof types[0]; ++i) {
        if (strcmp(types[i].name, type) == 0) {
            return types[i].bytes;
        }
    }
    return 0;
}

static void check_argument(const noted_kernel *kernel, cl_uint index)
{
    const passed_argument *passed = &kernel->arguments[index];
    cl_kernel_arg_address_qualifier where = 0;
    char type[NAME_BYTES] = "";
    assert_int_equal(
        clGetKernelArgInfo(kernel->handle, index, CL_KERNEL_ARG_ADDRESS_QUALIFIER, sizeof where, &where, NULL),
        CL_SUCCESS);
    assert_int_equal(clGetKernelArgInfo(kernel->handle, index, CL_KERNEL_ARG_TYPE_NAME, sizeof type, type, NULL),
                     CL_SUCCESS);
    if (passed->times != 1 && !(passed->times == 0 && kernel->launched)) {
        fail_msg("%s: argument %u (%s) was set %u times", kernel->name, index, type, passed->times);
    }
    if (where == CL_KERNEL_ARG_ADDRESS_LOCAL) {
        if (!passed->is_null || passed->bytes == 0) {
            fail_msg("%s: argument %u (local %s) has %s", kernel->name, index, type,
                     passed->is_null ? "no bytes" : "a value");
        }
        return;
    }
    const bool is_buffer = where == CL_KERNEL_ARG_ADDRESS_GLOBAL || where == CL_KERNEL_ARG_ADDRESS_CONSTANT;
    const size_t bytes = is_buffer ? sizeof(cl_mem) : bytes_of_type(type);
    if (passed->is_null || passed->bytes != bytes) {
        fail_msg("%s: argument %u (%s) has %s of %zu bytes, not a value of %zu", kernel->name, index, type,
                 passed->is_null ? "local memory" : "a value", passed->bytes, bytes);
    }
}

static noted_kernel *find_kernel(cl_kernel handle)
{
    for (size_t i = 0; i < notes.kernel_count; ++i) {
        if (notes.kernels[i].handle == handle) {
            return &notes.kernels[i];
        }
    }
    fail_msg("a kernel that clCreateKernel did not make");
    return NULL;
}

static bool was_launched(const char *name)
{
    for (size_t i = 0; i < notes.launched_count; ++i) {
        if (strcmp(notes.launched[i], name) == 0) {
            return true;
        }
    }
    return false;
}

static void check_launch(cl_kernel handle)
{
    noted_kernel *kernel = find_kernel(handle);
    for (cl_uint i = 0; i < kernel->argument_count; ++i) {
        check_argument(kernel, i);
        kernel->arguments[i].times = 0;
    }
    kernel->launched = true;
    if (!was_launched(kernel->name)) {
        assert_true(notes.launched_count < KERNELS_MAX);
        memcpy(notes.launched[notes.launched_count++], kernel->name, NAME_BYTES);
    }
}

/* ---- the calls ---- */

/* The linker's names for the real calls and for their wrappers. */
/* NOLINTBEGIN(readability-identifier-naming) */
typedef void(CL_CALLBACK *build_callback)(cl_program program, void *user);
cl_int __real_clBuildProgram(cl_program program, cl_uint count, const cl_device_id *devices, const char *options,
                             build_callback done, void *user);
cl_int __wrap_clBuildProgram(cl_program program, cl_uint count, const cl_device_id *devices, const char *options,
                             build_callback done, void *user);
cl_kernel __real_clCreateKernel(cl_program program, const char *name, cl_int *error);
cl_kernel __wrap_clCreateKernel(cl_program program, const char *name, cl_int *error);
cl_int __real_clReleaseKernel(cl_kernel handle);
cl_int __wrap_clReleaseKernel(cl_kernel handle);
cl_int __real_clSetKernelArg(cl_kernel handle, cl_uint index, size_t bytes, const void *value);
cl_int __wrap_clSetKernelArg(cl_kernel handle, cl_uint index, size_t bytes, const void *value);
cl_int __real_clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t *offset,
                                     const size_t *global, const size_t *local, cl_uint num_wait, const cl_event *wait,
                                     cl_event *event);
cl_int __wrap_clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t *offset,
                                     const size_t *global, const size_t *local, cl_uint num_wait, const cl_event *wait,
                                     cl_event *event);

cl_int __wrap_clBuildProgram(cl_program program, cl_uint count, const cl_device_id *devices, const char *options,
                             build_callback done, void *user)
{
    /* The kernels' results do not matter here: without optimization they compile in a third of the time. */
    char with_types[1024];
    const int length = snprintf(with_types, sizeof with_types, "%s -cl-kernel-arg-info -cl-opt-disable", options);
    assert_in_range(length, 1, sizeof with_types - 1);
    const cl_int error = __real_clBuildProgram(program, count, devices, with_types, done, user);
    if (error != CL_SUCCESS) {
        fail_msg("error %d: %s; a function that kernels/shared/builtins.clh does not declare?", error, options);
    }
    return error;
}

cl_kernel __wrap_clCreateKernel(cl_program program, const char *name, cl_int *error)
{
    const cl_kernel handle = __real_clCreateKernel(program, name, error);
    if (handle != NULL) {
        assert_true(notes.kernel_count < HANDLES_MAX);
        noted_kernel *kernel = &notes.kernels[notes.kernel_count++];
        *kernel = (noted_kernel){.handle = handle};
        assert_in_range(snprintf(kernel->name, sizeof kernel->name, "%s", name), 1, sizeof kernel->name - 1);
        assert_int_equal(
            clGetKernelInfo(handle, CL_KERNEL_NUM_ARGS, sizeof kernel->argument_count, &kernel->argument_count, NULL),
            CL_SUCCESS);
        assert_in_range(kernel->argument_count, 1, ARGUMENTS_MAX);
    }
    return handle;
}

/* svocl retains no kernel: this call destroys it, and its handle may be reused. */
cl_int __wrap_clReleaseKernel(cl_kernel handle)
{
    noted_kernel *kernel = find_kernel(handle);
    --notes.kernel_count;
    *kernel = notes.kernels[notes.kernel_count];
    return __real_clReleaseKernel(handle);
}

cl_int __wrap_clSetKernelArg(cl_kernel handle, cl_uint index, size_t bytes, const void *value)
{
    noted_kernel *kernel = find_kernel(handle);
    if (index >= kernel->argument_count) {
        fail_msg("%s: argument %u of %u was set", kernel->name, index, kernel->argument_count);
    }
    kernel->arguments[index] = (passed_argument){kernel->arguments[index].times + 1, bytes, value == NULL};
    return __real_clSetKernelArg(handle, index, bytes, value);
}

cl_int __wrap_clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t *offset,
                                     const size_t *global, const size_t *local, cl_uint num_wait, const cl_event *wait,
                                     cl_event *event)
{
    check_launch(kernel);
    return __real_clEnqueueNDRangeKernel(queue, kernel, dimensions, offset, global, local, num_wait, wait, event);
}
/* NOLINTEND(readability-identifier-naming) */

/* ---- builds and queries that launch every kernel ---- */

/* Payload that differs between voxels, so that none of it is left out: vertex colors, two materials. Uniform weights
   without SVO_NEED_FILL compile the least source and do not change signatures; areas add arguments. */
typedef struct painted_mesh {
    owned_mesh base;
    svo_mesh mesh;
    uint8_t *colors;
    uint16_t *triangle_materials;
} painted_mesh;

#define PAYLOAD ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_MATERIAL)

static void painted_mesh_create(size_t triangle_count, painted_mesh *out)
{
    static const svo_material materials[] = {{{255, 255, 255, 255}, SVO_NO_TEXTURE}, {{9, 9, 9, 255}, SVO_NO_TEXTURE}};
    static const double corner[3] = {0.25, 0.25, 0.25};
    uint64_t seed = 7;
    /* Tiny triangles: they need one overlap test only, that is one program of the voxelizer. */
    random_dust(seed, triangle_count, corner, 0.5, &out->base);
    out->mesh = out->base.mesh;
    out->colors = malloc(out->mesh.vertex_count * 4);
    out->triangle_materials = malloc(out->mesh.triangle_count * sizeof *out->triangle_materials);
    assert_non_null(out->colors);
    assert_non_null(out->triangle_materials);
    for (size_t i = 0; i < out->mesh.vertex_count * 4; ++i) {
        out->colors[i] = (uint8_t)random_below(&seed, 256);
    }
    for (size_t i = 0; i < out->mesh.triangle_count; ++i) {
        out->triangle_materials[i] = (uint16_t)(i % 2);
    }
    out->mesh.colors = out->colors;
    out->mesh.triangle_materials = out->triangle_materials;
    out->mesh.materials = materials;
    out->mesh.material_count = sizeof materials / sizeof materials[0];
}

static void painted_mesh_destroy(painted_mesh *made)
{
    free(made->colors);
    free(made->triangle_materials);
    owned_mesh_free(&made->base);
}

static void succeed(const fixture *opened, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), svo_device_message(opened->device));
    }
}

static void enqueue_build(const fixture *opened, const svo_mesh *mesh, const svo_plan_options *options)
{
    svo_plan_options with_size = *options;
    with_size.struct_size = sizeof with_size;
    svo_plan *plan = NULL;
    svo_workspace *workspace = NULL;
    svo_tree *tree = NULL;
    succeed(opened, svo_plan_create(opened->device, mesh, DEPTH, &with_size, &plan));
    succeed(opened, svo_workspace_create(plan, opened->frontend, opened->queue, NULL, &workspace));
    succeed(opened, svo_workspace_make_tree(workspace, &tree));
    succeed(opened, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened->queue}));
    succeed(opened, svo_tree_finish(tree, opened->queue, 0, NULL));
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
}

static cl_mem buffer_of(const fixture *opened, const void *bytes, size_t count)
{
    cl_int error = CL_SUCCESS;
    const cl_mem buffer =
        clCreateBuffer(info_of_device(opened->device).context, CL_MEM_READ_WRITE, count, NULL, &error);
    assert_int_equal(error, CL_SUCCESS);
    assert_int_equal(clEnqueueWriteBuffer(opened->queue, buffer, CL_TRUE, 0, count, bytes, 0, NULL, NULL), CL_SUCCESS);
    return buffer;
}

/* The list in one chunk and in several, each with and without areas, the same with a workspace, where pairs are
   dropped, too, the sorted builder, which has the same payload stages, and a deep tree. */
static void build_all(const fixture *opened, const svo_mesh *mesh, built *out)
{
    svo_plan_options options = {.need = PAYLOAD | (uint32_t)SVO_NEED_RAYS, .weights = SVO_WEIGHTS_UNIFORM, .edge = 1.0};
    built other;
    fixture_build(opened, mesh, DEPTH, &options, out);
    enqueue_build(opened, mesh, &options);
    options.chunk_bytes = 16384;
    for (int areas = 0; areas < 2; ++areas) {
        fixture_build(opened, mesh, DEPTH, &options, &other);
        assert_true(other.report.list_chunks > 1);
        built_destroy(&other);
        options.need |= SVO_NEED_PROJECTED_AREA;
    }
    options.chunk_bytes = 0;
    options.drop_alpha = 0.5;
    enqueue_build(opened, mesh, &options);
    options.drop_alpha = 0.0;
    options = (svo_plan_options){.need = SVO_NEED_RAYS, .builder = SVO_BUILDER_SORTED, .edge = 1.0};
    fixture_build(opened, mesh, DEPTH, &options, &other);
    built_destroy(&other);
    options.edge = 0.5; /* triangles leave the grid */
    fixture_build(opened, mesh, DEPTH, &options, &other);
    succeed(opened, svo_tree_make_bvh(other.tree, SVO_BVH_BEST, opened->queue));
    built_destroy(&other);
    options.edge = 1.0;
    options.builder = SVO_BUILDER_CL;
    fixture_build(opened, mesh, 2 * DEPTH, &options, &other); /* its lower levels have blocks for nodes alone */
    built_destroy(&other);
}

/* The path of GPUs, also with leaves that a group sorts; twice, since the first builds warm up. */
static void build_as_on_gpus(fixture *opened, const svo_mesh *mesh)
{
    const svo_plan_options options = {
        .need = PAYLOAD | (uint32_t)SVO_NEED_PROJECTED_AREA, .weights = SVO_WEIGHTS_UNIFORM, .edge = 1.0};
    const bool cpu_path = opened->device->cpu_path;
    painted_mesh many;
    painted_mesh_create(12 * SVO_LONG_LEAF, &many);
    opened->device->cpu_path = false;
    for (int i = 0; i < 2; ++i) {
        built made;
        fixture_build(opened, mesh, DEPTH, &options, &made);
        built_destroy(&made);
        fixture_build(opened, &many.mesh, 1, &options, &made); /* eight leaves */
        built_destroy(&made);
    }
    opened->device->cpu_path = cpu_path;
    painted_mesh_destroy(&many);
}

/* A plan by kernels of all that they do: some triangles are outside, indices are narrow and begin at an offset. */
static void plan_all(const fixture *opened, const svo_mesh *mesh)
{
    static const float points[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const uint16_t corners[4] = {0, 0, 1, 2};
    static const uint8_t texel[4] = {1, 2, 3, 255};
    const svo_texture texture = {.rgba = texel, .width = 1, .height = 1};
    const svo_material material = {{255, 255, 255, 255}, 0};
    svo_plan_options options = {.struct_size = sizeof options, .need = SVO_NEED_ALL, .edge = 0.5};
    svo_mesh_buffers buffers = {
        .struct_size = sizeof buffers, .vertex_count = 3, .triangle_count = 1, .index_bytes = 2};
    svo_plan *plan = NULL;
    options.place = SVO_PLACE_DEVICE;
    succeed(opened, svo_plan_create(opened->device, mesh, DEPTH, &options, &plan));
    svo_plan_destroy(&plan);
    options.updatable = 1;
    succeed(opened, svo_plan_create(opened->device, mesh, DEPTH, &options, &plan));
    svo_plan_destroy(&plan);
    options.updatable = 0;
    options.edge = 0.0;
    succeed(opened, svo_plan_create(opened->device, mesh, DEPTH, &options, &plan));
    svo_plan_destroy(&plan);
    buffers.indices.offset_bytes = 2;
    buffers.positions.memory = buffer_of(opened, points, sizeof points);
    buffers.normals.memory = buffers.uvs.memory = buffers.positions.memory; /* any floats */
    buffers.materials = &material;
    buffers.textures = &texture;
    buffers.material_count = buffers.texture_count = 1;
    buffers.indices.memory = buffer_of(opened, corners, sizeof corners);
    succeed(opened, svo_plan_create_from_buffers(opened->device, &buffers, DEPTH, NULL, opened->queue, 0, NULL, &plan));
    svo_plan_destroy(&plan);
    clReleaseMemObject(buffers.positions.memory);
    clReleaseMemObject(buffers.indices.memory);
}

static void query_all(const fixture *opened, svo_tree *tree)
{
    const svo_ray ray = {.origin = {0.5F, 0.5F, -1.0F}, .t_max = 10.0F, .direction = {0.0F, 0.0F, 1.0F}};
    const svo_query_point point = {.position = {0.5F, 0.5F, 0.5F}, .max_distance = 1.0F};
    svo_hit hit;
    svo_nearest nearest;
    uint8_t picture[8 * 8 * 4];
    svo_render_options options = {.struct_size = sizeof options, .width = 8, .height = 8};
    (void)svo_camera_fit(svo_tree_target(tree), 1.0F, &options.camera);
    /* Ranges above the size of a job are split by other kernels. */
    succeed(opened, svo_i_rays_make(tree, "test", opened->queue, &(svo_i_bvh_options){.subtree_items = 64}));
    succeed(opened, svo_tree_make_bvh(tree, SVO_BVH_FAST, opened->queue));
    succeed(opened,
            svo_render(svo_tree_target(tree), &options, svo_in_host(picture), &(svo_submit){.queue = opened->queue}));
    options.view = SVO_VIEW_DEPTH;
    succeed(opened,
            svo_render(svo_tree_target(tree), &options, svo_in_host(picture), &(svo_submit){.queue = opened->queue}));
    succeed(opened, svo_trace_triangles(svo_tree_target(tree), svo_in_host(&ray), svo_in_host(&hit), 1,
                                        SVO_TRACE_CLOSEST, &(svo_submit){.queue = opened->queue}));
    succeed(opened, svo_tree_nearest(tree, svo_in_host(&point), svo_in_host(&nearest), 1,
                                     &(svo_submit){.queue = opened->queue}));
}

/* Two instances, so that there is a hierarchy. */
static void place_all(const fixture *opened, svo_tree *tree)
{
    const svo_instance instances[2] = {{0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}},
                                       {0, {1, 0, 0, 2, 0, 1, 0, 0, 0, 0, 1, 0}}};
    const svo_scene_options options = {.struct_size = sizeof options,
                                       .trees = &tree,
                                       .instances = instances,
                                       .tree_count = 1,
                                       .instance_count = 2,
                                       .need = (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL |
                                               (uint32_t)SVO_NEED_RAYS};
    const svo_ray ray = {.origin = {0.5F, 0.5F, -1.0F}, .t_max = 10.0F, .direction = {0.0F, 0.0F, 1.0F}};
    svo_scene *scene = NULL;
    svo_scene_hit hit;
    svo_scene_triangle_hit triangle;
    uint8_t picture[8 * 8 * 4];
    svo_render_options render = {.struct_size = sizeof render, .width = 8, .height = 8};
    succeed(opened, svo_scene_create(opened->device, &options, opened->queue, &scene));
    succeed(opened, svo_scene_set_transforms(scene, 0, 1, instances[0].transform, opened->queue));
    succeed(opened, svo_trace_voxels(svo_scene_target(scene), svo_in_host(&ray), svo_in_host(&hit), 1, 0.0F,
                                     SVO_SCENE_CLOSEST, &(svo_submit){.queue = opened->queue}));
    succeed(opened, svo_trace_triangles(svo_scene_target(scene), svo_in_host(&ray), svo_in_host(&triangle), 1,
                                        SVO_SCENE_CLOSEST, &(svo_submit){.queue = opened->queue}));
    (void)svo_camera_fit(svo_scene_target(scene), 1.0F, &render.camera);
    succeed(opened,
            svo_render(svo_scene_target(scene), &render, svo_in_host(picture), &(svo_submit){.queue = opened->queue}));
    svo_scene_destroy(&scene);
}

static void compact_all(const fixture *opened, svo_tree *tree)
{
    for (int form = 0; form < SVO_FORM_COUNT; ++form) {
        const svo_compact_options options = {.struct_size = sizeof options, .form = (svo_form)form, .minimize = 1};
        const svo_ray ray = {.t_max = 10.0F, .direction = {0.0F, 0.0F, 1.0F}};
        uint8_t picture[8 * 8 * 4];
        svo_render_options shown = {.struct_size = sizeof shown, .width = 8, .height = 8};
        svo_voxel_hit hit;
        svo_compact *plain = NULL;
        svo_compact *compact = NULL;
        svo_tree *expanded = NULL;
        (void)svo_camera_fit(svo_tree_target(tree), 1.0F, &shown.camera);
        succeed(opened, svo_compact_create(opened->device, tree, &options, opened->queue, &plain));
        succeed(opened, svo_compact_pack(plain, NULL, opened->queue, &compact));
        svo_compact_destroy(&plain);
        succeed(opened, svo_compact_expand(compact, opened->queue, &expanded));
        succeed(opened, svo_trace_voxels(svo_compact_target(compact), svo_in_host(&ray), svo_in_host(&hit), 1, 0.0F, 0,
                                         &(svo_submit){.queue = opened->queue}));
        succeed(opened, svo_render(svo_compact_target(compact), &shown, svo_in_host(picture),
                                   &(svo_submit){.queue = opened->queue}));
        shown.view = SVO_VIEW_STEPS;
        succeed(opened, svo_render(svo_compact_target(compact), &shown, svo_in_host(picture),
                                   &(svo_submit){.queue = opened->queue}));
        svo_tree_destroy(&expanded);
        svo_compact_destroy(&compact);
    }
}

/* A box with material inside, with and without one of its faces, and a leaf with a list that a work-group reads; its
   distance fields. */
static void fill_box(const fixture *opened, int skipped_face)
{
    static const double low[3] = {0.1, 0.1, 0.1};
    static const double high[3] = {0.9, 0.9, 0.9};
    static const double tiny[4][3] = {{0.5, 0.5, 0.5}, {0.51, 0.5, 0.5}, {0.5, 0.51, 0.5}, {0.5, 0.5, 0.51}};
    const svo_plan_options options = {.need = (uint32_t)SVO_NEED_RAYS | (uint32_t)SVO_NEED_NORMAL, .edge = 1.0};
    parts made = {.vertex_count = 0};
    svo_compact *solid = NULL;
    built tree;
    parts_add_box(&made, low, high, false, skipped_face);
    for (int i = 0; i < SVO_SHORT_LIST_MAX / 3; ++i) {
        parts_add_tetrahedron(&made, tiny);
    }
    const svo_mesh mesh = parts_mesh(&made);
    fixture_build(opened, &mesh, DEPTH, &options, &tree);
    for (int rule = SVO_SOLID_WINDING; rule <= SVO_SOLID_GENERALIZED; ++rule) {
        const svo_solid_options filling = {.struct_size = sizeof filling, .rule = (svo_solid_rule)rule};
        succeed(opened, svo_solid_create(tree.tree, &filling, opened->queue, &solid, NULL));
        svo_compact_destroy(&solid);
    }
    for (int is_band = 0; is_band < 2; ++is_band) {
        const svo_sdf_options asked = {.struct_size = sizeof asked, .band = (float)is_band};
        svo_sdf *sdf = NULL;
        succeed(opened, svo_sdf_create(tree.tree, &asked, opened->queue, &sdf));
        svo_sdf_destroy(&sdf);
    }
    built_destroy(&tree);
    parts_free(&made);
}

static void fill_all(const fixture *opened)
{
    fill_box(opened, -1);
    fill_box(opened, 0);
}

/* A light of each form, with one lit leaf. */
static void light_all(const fixture *opened, svo_tree *tree)
{
    static const uint32_t leaf = 0;
    static const uint32_t radiance[18] = {1};
    static const svo_gather_point point = {.normal = {0, 0, 1}};
    static const svo_finish glow = {.emission = {1, 1, 1}};
    svo_gather_result result;
    for (int form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
        const svo_light_options options = {.struct_size = sizeof options, .form = (svo_light_form)form};
        svo_i_lit_leaves lit = {.lit_count = 1, .unit = 1};
        svo_i_device_work work;
        const svo_light_source lamp = {.kind = SVO_SOURCE_POINT, .position = {0.5F, 0.5F, 0.5F}, .value = {1, 1, 1}};
        const svo_light_setup setup = {
            .struct_size = sizeof setup, .sources = &lamp, .source_count = 1, .view_resolution = 8, .updatable = 1};
        const svo_box changed = {.high = {1, 1, 1}};
        svo_light *light = NULL;
        succeed(opened, svo_light_create(tree, &options, opened->queue, &light));
        succeed(opened, svo_light_set_sources(light, &setup, opened->queue));
        succeed(opened, svo_light_update(light, tree, &changed, 1, opened->queue));
        succeed(opened, svo_light_update(light, tree, &changed, 1, opened->queue)); /* from what the first one kept */
        svo_light_setup onward = setup;
        onward.finishes = &glow;
        onward.finish_count = 1;
        onward.emission_photons = 8;
        onward.bounces = 2;
        onward.photon_alpha = 1;
        succeed(opened, svo_light_set_sources(light, &onward, opened->queue));
        succeed(opened, svo_i_work_begin(opened->device, "light_all", opened->queue, &work));
        succeed(opened, svo_i_work_alloc(&work, "leaves", sizeof leaf, &lit.leaves));
        succeed(opened, svo_i_work_alloc(&work, "radiance", sizeof radiance, &lit.radiance));
        succeed(opened, svo_i_work_write(&work, lit.leaves, &leaf, sizeof leaf));
        succeed(opened, svo_i_work_write(&work, lit.radiance, radiance, sizeof radiance));
        succeed(opened, svo_i_light_filter(&work, light, &lit));
        svo_i_work_end(&work);
        succeed(opened, svo_gather(light, svo_in_host(&point), svo_in_host(&result), 1, NULL,
                                   &(svo_submit){.queue = opened->queue}));
        svo_light_destroy(&light);
    }
}

/* Probes with all that they can have, a ray and a point. */
static void probe_all(const fixture *opened, svo_tree *tree, svo_light *light)
{
    static const svo_ray ray = {.direction = {0, 0, 1}, .t_max = 1};
    static const svo_gather_point point = {.normal = {0, 0, 1}};
    svo_probe_options options = SVO_PROBE_OPTIONS_INIT;
    svo_probes *probes = NULL;
    svo_probe_hit hit;
    svo_probe_irradiance irradiance;
    options.counts[0] = options.counts[1] = options.counts[2] = 1;
    options.resolution = 64;
    options.field_size = 2;
    options.tree = tree;
    options.light = light;
    options.diffuse = 1;
    options.cones = 1;
    succeed(opened, svo_probes_create(&options, opened->queue, &probes));
    succeed(opened, svo_probes_trace(probes, svo_in_host(&ray), svo_in_host(&hit), 1, NULL,
                                     &(svo_submit){.queue = opened->queue}));
    succeed(opened, svo_probes_irradiance(probes, svo_in_host(&point), svo_in_host(&irradiance), 1,
                                          &(svo_submit){.queue = opened->queue}));
    svo_probes_destroy(&probes);
}

/* Probes of a scene of a tree that shows in part. */
static void probe_scene(const fixture *opened, svo_tree *tree)
{
    const svo_instance instance = {0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    const svo_scene_options placed = {.struct_size = sizeof placed,
                                      .trees = &tree,
                                      .instances = &instance,
                                      .tree_count = 1,
                                      .instance_count = 1,
                                      .need = SVO_NEED_COLOR};
    svo_probe_options options = SVO_PROBE_OPTIONS_INIT;
    svo_scene *scene = NULL;
    svo_probes *probes = NULL;
    succeed(opened, svo_scene_create(opened->device, &placed, opened->queue, &scene));
    options.counts[0] = options.counts[1] = options.counts[2] = 1;
    options.resolution = 64;
    options.field_size = 2;
    options.scene = scene;
    succeed(opened, svo_probes_create(&options, opened->queue, &probes));
    svo_probes_destroy(&probes);
    svo_scene_destroy(&scene);
}

/* A lamp on triangles and on voxels, and materials that emit; all that it counts. */
static void shine_all(const fixture *opened, const svo_mesh *mesh)
{
    const svo_finish finishes[2] = {{.emission = {1, 1, 1}}, {.emission = {0, 0, 0}}};
    const svo_light_source lamp = {.kind = SVO_SOURCE_POINT, .position = {0.5F, 0.5F, 0.5F}, .value = {1, 1, 1}};
    const uint32_t needs[2] = {PAYLOAD | (uint32_t)SVO_NEED_RAYS, PAYLOAD};
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    svo_render_options picture = SVO_RENDER_OPTIONS_INIT;
    uint8_t pixels[8 * 8 * 4];
    picture.width = picture.height = 8;
    picture.camera = (svo_camera){{0.5F, 0.5F, 3}, {0.5F, 0.5F, 0.5F}, {0, 1, 0}, 0.5F};
    setup.sources = &lamp;
    setup.source_count = 1;
    setup.finishes = finishes;
    setup.finish_count = 2;
    setup.view_resolution = 16;
    setup.diagnose = 1;
    setup.photon_alpha = 1;
    for (int i = 0; i < 2; ++i) {
        const svo_plan_options options = {.need = needs[i], .weights = SVO_WEIGHTS_UNIFORM, .edge = 1.0};
        const svo_light_options faces = SVO_LIGHT_OPTIONS_INIT;
        svo_light *light = NULL;
        built made;
        fixture_build(opened, mesh, DEPTH, &options, &made);
        succeed(opened, svo_light_create(made.tree, &faces, opened->queue, &light));
        succeed(opened, svo_light_set_sources(light, &setup, opened->queue));
        succeed(opened, svo_render(svo_light_target(light), &picture, svo_in_host(pixels),
                                   &(svo_submit){.queue = opened->queue}));
        probe_all(opened, made.tree, light);
        probe_scene(opened, made.tree);
        svo_light_destroy(&light);
        built_destroy(&made);
    }
}

/* Two objects that move beside the mesh, with lists, materials and projected areas. */
static void move_all(const fixture *opened, const svo_mesh *mesh)
{
    const double transform[12] = {0.5, 0, 0, 0.1, 0, 0.5, 0, 0.1, 0, 0, 0.5, 0.1};
    const svo_moving_options options = {.struct_size = sizeof options,
                                        .need = PAYLOAD | (uint32_t)SVO_NEED_RAYS | (uint32_t)SVO_NEED_PROJECTED_AREA,
                                        .edge = 1.0,
                                        .max_area = 1e3};
    svo_moving *moving = NULL;
    uint32_t object = 0;
    succeed(opened, svo_moving_create(opened->device, mesh, DEPTH, &options, opened->queue, &moving));
    succeed(opened, svo_moving_add(moving, mesh, transform, &object));
    succeed(opened, svo_moving_add(moving, mesh, NULL, &object));
    succeed(opened, svo_moving_update(moving, NULL, NULL));
    succeed(opened, svo_moving_set_transform(moving, 0, transform));
    succeed(opened, svo_moving_update(moving, &(svo_submit){.queue = opened->queue}, NULL));
    succeed(opened, svo_moving_finish(moving, NULL));
    succeed(opened, svo_moving_make_bvh(moving, SVO_BVH_BEST, 0.0F, opened->queue, NULL));
    svo_moving_destroy(&moving);
}

/* The same on the path of GPUs. */
static void move_as_on_gpus(fixture *opened, const svo_mesh *mesh)
{
    const bool cpu_path = opened->device->cpu_path;
    opened->device->cpu_path = false;
    move_all(opened, mesh);
    opened->device->cpu_path = cpu_path;
}

/* The one kernel that no build launches on this device; NULL: there is none. */
static const char *find_unused(const fixture *opened)
{
    const bool lanes = fixture_has_pair_lanes(opened);
    if (!lanes) {
        print_message("svo_k_gather_level is not for %s\n", opened->device->name);
    }
    return lanes ? NULL : "svo_k_gather_level";
}

/* Fails if a kernel defined in the source was never launched, but for unused, which must not have been. Returns how
   many the source defines. */
static size_t check_all_launched(const char *source, const char *unused)
{
    static const char prefix[] = "svo_k_";
    size_t count = 0;
    for (const char *at = strstr(source, prefix); at != NULL; at = strstr(at + 1, prefix)) {
        const size_t length = strspn(at, "abcdefghijklmnopqrstuvwxyz0123456789_");
        char name[NAME_BYTES] = "";
        if (at[length] == '(') {
            assert_true(length < sizeof name);
            memcpy(name, at, length);
            ++count;
            const bool expected = unused == NULL || strcmp(name, unused) != 0;
            if (was_launched(name) != expected) {
                fail_msg("%s was %slaunched", name, expected ? "not " : "");
            }
        }
    }
    return count;
}

static void every_launch_matches_its_kernel(void **state)
{
    (void)state;
    fixture opened;
    fixture_open_cl(&(fixture_options){.share = SVO_GL_SHARE_AUTO}, &opened);
    opened.device->tests_programs = false; /* so that what is launched is what builds and queries launch */
    painted_mesh painted;
    painted_mesh_create(300, &painted);
    built tree;
    build_all(&opened, &painted.mesh, &tree);
    built_destroy(&tree);
    /* The first builds also launched every kernel as a warm-up (warm_up.c). These have only the stages' launches. */
    notes.launched_count = 0;
    plan_all(&opened, &painted.mesh);
    build_all(&opened, &painted.mesh, &tree);
    build_as_on_gpus(&opened, &painted.mesh);
    query_all(&opened, tree.tree);
    compact_all(&opened, tree.tree);
    place_all(&opened, tree.tree);
    fill_all(&opened);
    light_all(&opened, tree.tree);
    shine_all(&opened, &painted.mesh);
    move_all(&opened, &painted.mesh);
    move_as_on_gpus(&opened, &painted.mesh);
    const char *unused = find_unused(&opened);
    opened.device->tests_programs = true; /* by svo_k_arithmetic too, which has no other use */
    query_all(&opened, tree.tree);
    size_t kernels = 0;
    for (size_t i = 0; kernel_files[i] != NULL; ++i) {
        kernels += check_all_launched(kernel_files[i]->text, unused);
    }
    assert_in_range(notes.launched_count, 1, kernels); /* some have two definitions */
    built_destroy(&tree);
    painted_mesh_destroy(&painted);
    fixture_close(&opened);
}

TEST_GROUP(kernel_signatures)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_launch_matches_its_kernel)};
    return cmocka_run_group_tests_name("kernel_signatures", tests, NULL, NULL);
}
