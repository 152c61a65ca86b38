/* SPDX-License-Identifier: MIT */
/*
 * Devices that this machine has not: of an old version, of the other byte order, with small limits, with a compiler
 * that refuses, in a context of many devices. The linker routes the library's queries here, and they answer so.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/device.h"
#include "core/opencl.h"
#include "scenes.h"
#include "shared/layout.h"
#include "support/fixture.h"
#include "support/info_of.h"
#include "support/suite.h"

#define BUILD_LOG "1 error generated.\nprogram.cl:7: error: no such thing\nand more"

/* What one query answers instead. */
typedef struct answer {
    cl_uint what; /* 0: nothing is replaced */
    const void *value;
    size_t bytes;
} answer;

static answer device_answer, program_answer;
static bool refuses_to_compile, refuses_short;
static size_t short_builds;
/* What is replaced in the texts of kernels, and how often; NULL: nothing. */
static const char *replaced, *replacement;
static size_t replacements;

static cl_int tell(const answer *told, size_t bytes, void *value, size_t *needed)
{
    if (needed != NULL) {
        *needed = told->bytes;
    }
    if (value != NULL) {
        assert_true(bytes >= told->bytes);
        memcpy(value, told->value, told->bytes);
    }
    return CL_SUCCESS;
}

/* NOLINTBEGIN(readability-identifier-naming) */
typedef void(CL_CALLBACK *build_callback)(cl_program, void *);
cl_int __real_clGetDeviceInfo(cl_device_id device, cl_device_info what, size_t bytes, void *value, size_t *needed);
cl_int __wrap_clGetDeviceInfo(cl_device_id device, cl_device_info what, size_t bytes, void *value, size_t *needed);
cl_int __real_clGetProgramInfo(cl_program program, cl_program_info what, size_t bytes, void *value, size_t *needed);
cl_int __wrap_clGetProgramInfo(cl_program program, cl_program_info what, size_t bytes, void *value, size_t *needed);
cl_int __wrap_clGetProgramBuildInfo(cl_program program, cl_device_id device, cl_program_build_info what, size_t bytes,
                                    void *value, size_t *needed);
cl_program __real_clCreateProgramWithSource(cl_context context, cl_uint count, const char **texts, const size_t *bytes,
                                            cl_int *error);
cl_program __wrap_clCreateProgramWithSource(cl_context context, cl_uint count, const char **texts, const size_t *bytes,
                                            cl_int *error);
cl_int __real_clBuildProgram(cl_program program, cl_uint count, const cl_device_id *devices, const char *options,
                             build_callback done, void *user);
cl_int __wrap_clBuildProgram(cl_program program, cl_uint count, const cl_device_id *devices, const char *options,
                             build_callback done, void *user);

cl_int __wrap_clGetDeviceInfo(cl_device_id device, cl_device_info what, size_t bytes, void *value, size_t *needed)
{
    return device_answer.what == what ? tell(&device_answer, bytes, value, needed)
                                      : __real_clGetDeviceInfo(device, what, bytes, value, needed);
}

cl_int __wrap_clGetProgramInfo(cl_program program, cl_program_info what, size_t bytes, void *value, size_t *needed)
{
    return program_answer.what == what ? tell(&program_answer, bytes, value, needed)
                                       : __real_clGetProgramInfo(program, what, bytes, value, needed);
}

cl_int __wrap_clGetProgramBuildInfo(cl_program program, cl_device_id device, cl_program_build_info what, size_t bytes,
                                    void *value, size_t *needed)
{
    (void)program;
    (void)device;
    (void)what;
    return tell(&(answer){.value = BUILD_LOG, .bytes = sizeof BUILD_LOG}, bytes, value, needed);
}

cl_program __wrap_clCreateProgramWithSource(cl_context context, cl_uint count, const char **texts, const size_t *bytes,
                                            cl_int *error)
{
    const char *last = texts[count - 1];
    const char *found = replaced != NULL && bytes == NULL ? strstr(last, replaced) : NULL;
    if (found == NULL) {
        return __real_clCreateProgramWithSource(context, count, texts, bytes, error);
    }
    const size_t room = strlen(last) + strlen(replacement) + 1;
    char *other = malloc(room);
    const char *changed[2] = {texts[0], other};
    assert_non_null(other);
    assert_in_range(count, 1, 2);
    (void)snprintf(other, room, "%.*s%s%s", (int)(found - last), last, replacement, found + strlen(replaced));
    ++replacements;
    cl_program program = __real_clCreateProgramWithSource(context, count, &changed[2 - count], NULL, error);
    free(other);
    return program;
}

cl_int __wrap_clBuildProgram(cl_program program, cl_uint count, const cl_device_id *devices, const char *options,
                             build_callback done, void *user)
{
    const bool is_short = strstr(options, "-D_OPENCL_H_") != NULL;
    short_builds += is_short;
    return refuses_to_compile || (refuses_short && is_short)
               ? CL_BUILD_PROGRAM_FAILURE
               : __real_clBuildProgram(program, count, devices, options, done, user);
}
/* NOLINTEND(readability-identifier-naming) */

static int forget_answers(void **state)
{
    (void)state;
    device_answer = program_answer = (answer){0};
    refuses_to_compile = refuses_short = false;
    replaced = replacement = NULL;
    replacements = 0;
    return 0;
}

static svo_status open_device(const fixture *opened, const svo_device_options *options, svo_device **out,
                              svo_message *message)
{
    return svo_device_create(info_of_device(opened->device).context, info_of_device(opened->device).device, options,
                             out, message);
}

static svo_device *open_or_fail(const fixture *opened, const svo_device_options *options)
{
    svo_device *device = NULL;
    svo_message message = {""};
    if (open_device(opened, options, &device, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return device;
}

static void expect(const svo_device *device, svo_status got, svo_status expected, const char *text)
{
    if (got != expected || strstr(svo_device_message(device), text) == NULL) {
        fail_msg("%s \"%s\", expected %s \"%s\"", svo_name(SVO_NAME_STATUS, got), svo_device_message(device),
                 svo_name(SVO_NAME_STATUS, expected), text);
    }
}

static void devices_that_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const char old[] = "OpenCL 1.1 of then", words[] = "CUDA";
    static const cl_bool big = CL_FALSE;
    static const size_t small = 31;
    const struct {
        answer told;
        const char *text;
    } rows[] = {
        {{CL_DEVICE_VERSION, old, sizeof old}, " has OpenCL 1.1, below 1.2"},
        {{CL_DEVICE_VERSION, words, sizeof words}, " has OpenCL 0.0, below 1.2"},
        {{CL_DEVICE_ENDIAN_LITTLE, &big, sizeof big}, " is big-endian"},
        {{CL_DEVICE_MAX_WORK_GROUP_SIZE, &small, sizeof small}, " has work-groups of 31 items, below "},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        svo_device *device = NULL;
        svo_message message = {""};
        device_answer = rows[i].told;
        assert_int_equal(open_device(&opened, NULL, &device, &message), SVO_UNSUPPORTED);
        if (strstr(message.text, rows[i].text) == NULL) {
            fail_msg("\"%s\", expected \"%s\" in it", message.text, rows[i].text);
        }
        assert_null(device);
    }
}

/* What runs by the device's type, and by the options whatever the type. */
static void paths_of_devices(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const struct {
        cl_device_type type;
        svo_path asked, path;
    } rows[] = {
        {CL_DEVICE_TYPE_CPU, SVO_PATH_AUTO, SVO_PATH_CPU},
        {CL_DEVICE_TYPE_CPU, SVO_PATH_CPU, SVO_PATH_CPU},
        {CL_DEVICE_TYPE_CPU, SVO_PATH_GPU, SVO_PATH_GPU},
        {CL_DEVICE_TYPE_CPU | CL_DEVICE_TYPE_DEFAULT, SVO_PATH_AUTO, SVO_PATH_CPU},
        {CL_DEVICE_TYPE_GPU, SVO_PATH_AUTO, SVO_PATH_GPU},
        {CL_DEVICE_TYPE_GPU, SVO_PATH_CPU, SVO_PATH_CPU},
        {CL_DEVICE_TYPE_GPU, SVO_PATH_GPU, SVO_PATH_GPU},
        {CL_DEVICE_TYPE_ACCELERATOR, SVO_PATH_AUTO, SVO_PATH_GPU},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        const svo_device_options options = {.struct_size = sizeof options, .path = rows[i].asked};
        device_answer = (answer){CL_DEVICE_TYPE, &rows[i].type, sizeof rows[i].type};
        svo_device *device = open_or_fail(&opened, &options);
        if (info_of_device(device).path != rows[i].path) {
            fail_msg("row %zu: path %s, expected %s", i, svo_name(SVO_NAME_PATH, info_of_device(device).path),
                     svo_name(SVO_NAME_PATH, rows[i].path));
        }
        svo_device_destroy(&device);
    }
}

static void a_path_that_is_none_is_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_device_options options = {.struct_size = sizeof options, .path = (svo_path)3};
    svo_device *device = NULL;
    svo_message message = {""};
    assert_int_equal(open_device(&opened, &options, &device, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_device_create: options.path 3 is not in 0 .. 2");
    assert_null(device);
    assert_string_equal(svo_name(SVO_NAME_PATH, SVO_PATH_AUTO), "auto");
    assert_string_equal(svo_name(SVO_NAME_PATH, options.path), "unknown path");
}

/* On the path of GPUs scans and sorts are as wide as the device has compute units, within bounds. */
static void widths_of_devices(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const struct {
        cl_uint units;
        svo_path path;
        uint32_t scan_groups, sort_groups;
    } rows[] = {
        {1, SVO_PATH_GPU, 64, 16},
        {20, SVO_PATH_GPU, 160, 80},
        {132, SVO_PATH_GPU, 1056, 512},
        {1024, SVO_PATH_GPU, 2048, 512},
        {132, SVO_PATH_CPU, SVO_SCAN_GROUPS, SVO_SORT_BLOCKS},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        const svo_device_options options = {.struct_size = sizeof options, .path = rows[i].path};
        device_answer = (answer){CL_DEVICE_MAX_COMPUTE_UNITS, &rows[i].units, sizeof rows[i].units};
        svo_device *device = open_or_fail(&opened, &options);
        assert_int_equal(device->scan_groups, rows[i].scan_groups);
        assert_int_equal(device->sort_groups, rows[i].sort_groups);
        svo_device_destroy(&device);
    }
}

/* Memory for uploads is for devices that have memory of their own, and for handles that may have any. */
static void staging_of_devices(void **state)
{
    static const struct {
        cl_bool shares_memory;
        uint64_t max_device_bytes;
        bool has_staging;
    } cases[] = {{CL_TRUE, 0, false}, {CL_FALSE, 0, true}, {CL_FALSE, UINT64_C(1) << 30, false}};
    const svo_device_info on = info_of_device(fixture_cl_of_group(state).device);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const svo_device_options options = {.struct_size = sizeof options,
                                            .max_device_bytes = cases[i].max_device_bytes};
        svo_device *device = NULL;
        device_answer = (answer){.what = CL_DEVICE_HOST_UNIFIED_MEMORY,
                                 .value = &cases[i].shares_memory,
                                 .bytes = sizeof cases[i].shares_memory};
        assert_int_equal(svo_device_create(on.context, on.device, &options, &device, NULL), SVO_OK);
        assert_int_equal(device->staging_bytes != 0, cases[i].has_staging);
        svo_device_destroy(&device);
    }
}

static void little_local_memory(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const cl_ulong local_bytes = 512;
    svo_frontend *frontend = NULL;
    device_answer = (answer){CL_DEVICE_LOCAL_MEM_SIZE, &local_bytes, sizeof local_bytes};
    expect(opened.device, svo_frontend_create_cl(opened.device, &frontend), SVO_UNSUPPORTED,
           " has 512 bytes of local memory, below ");
    assert_null(frontend);
}

/* The sorted builder has the whole list in one buffer; the other one does with chunks. */
static void a_list_above_the_largest_buffer(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const cl_ulong most_bytes = 400000;
    struct scene *knot = fixture_scene("knot:5000");
    device_answer = (answer){CL_DEVICE_MAX_MEM_ALLOC_SIZE, &most_bytes, sizeof most_bytes};
    svo_device *device = open_or_fail(&opened, NULL);
    svo_plan_options options = {.struct_size = sizeof options, .need = SVO_NEED_NONE, .builder = SVO_BUILDER_SORTED};
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    expect(device, svo_plan_create(device, scene_mesh(knot), 7, &options, &plan), SVO_OUT_OF_DEVICE_MEMORY,
           "builder sorted needs the list's ");
    assert_null(plan);
    options.builder = SVO_BUILDER_CL;
    expect(device, svo_plan_create(device, scene_mesh(knot), 7, &options, &plan), SVO_OK, "");
    expect(device, svo_build(plan, NULL, NULL, &tree, NULL), SVO_OK, "");
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    svo_device_destroy(&device);
    scene_destroy(&knot);
}

/* The list of a square at depth 16 that covers most of the grid, on a device whose allocations hold it in one buffer:
   no chunk has more fragments than kernels count in 32 bits, and workspaces, whose list is one chunk, say so. */
static void lists_above_32_bits_are_cut(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const cl_ulong most_bytes = UINT64_C(100000000000);
    static const float positions[] = {0, 0, 0.5f, 0.98f, 0, 0.5f, 0, 0.98f, 0.5f, 0.98f, 0.98f, 0.5f};
    static const uint32_t indices[] = {0, 1, 2, 2, 1, 3};
    const svo_mesh mesh = {
        .struct_size = sizeof mesh, .positions = positions, .vertex_count = 4, .indices = indices, .triangle_count = 2};
    const svo_plan_options options = {.struct_size = sizeof options, .edge = 1.0, .need = SVO_NEED_NONE};
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    svo_workspace_info room = SVO_WORKSPACE_INFO_INIT;
    svo_frontend *frontend = NULL;
    svo_plan *plan = NULL;
    uint64_t fragments = 0;
    device_answer = (answer){CL_DEVICE_MAX_MEM_ALLOC_SIZE, &most_bytes, sizeof most_bytes};
    svo_device *device = open_or_fail(&opened, NULL);
    expect(device, svo_frontend_create_cl(device, &frontend), SVO_OK, "");
    expect(device, svo_plan_create(device, &mesh, 16, &options, &plan), SVO_OK, "");
    expect(device, svo_plan_get_info(plan, &info), SVO_OK, "");
    assert_true(info.expected_fragments < 4294967295.0 && info.expected_fragments * 1.125 > 4294967295.0);
    for (size_t i = 0; i < info_of_plan(plan).buffer_count; ++i) {
        svo_buffer_info buffer = SVO_BUFFER_INFO_INIT;
        expect(device, svo_plan_get_buffer(plan, i, &buffer), SVO_OK, "");
        if (strcmp(buffer.name, "fragments") == 0) {
            fragments = buffer.bytes / 12;
            assert_in_range(buffer.count, 2, 3);
            assert_in_range(fragments / buffer.count, 1, UINT32_MAX - 65536u);
        }
    }
    assert_true((double)fragments > info.expected_fragments);
    expect(device, svo_workspace_measure(plan, frontend, &room), SVO_UNSUPPORTED,
           "and builds that are enqueued have one");
    svo_plan_destroy(&plan);
    svo_frontend_destroy(&frontend);
    svo_device_destroy(&device);
}

static void keep_text(void *user, svo_log_level level, const char *text)
{
    assert_int_equal(level, SVO_LOG_ERROR);
    (void)snprintf(user, sizeof BUILD_LOG, "%s", text);
}

static void kernels_that_do_not_compile(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    char log[sizeof BUILD_LOG] = "";
    const svo_device_options options = {.struct_size = sizeof options, .log = keep_text, .log_user = log};
    svo_device *device = open_or_fail(&opened, &options);
    struct scene *cube = fixture_scene("cube");
    svo_plan *plan = NULL;
    expect(device, svo_plan_create(device, scene_mesh(cube), 4, NULL, &plan), SVO_OK, "");
    refuses_to_compile = true;
    expect(device, svo_device_warm(device, plan), SVO_COMPILE_FAILED, ": kernels do not compile on ");
    assert_null(strchr(svo_device_message(device), '\n'));
    assert_string_equal(log, BUILD_LOG);
    refuses_to_compile = false;
    expect(device, svo_device_warm(device, plan), SVO_OK, "");
    svo_plan_destroy(&plan);
    svo_device_destroy(&device);
    scene_destroy(&cube);
}

/* Where the library's own declarations do not do, the driver's serve. */
static void drivers_declarations_serve_too(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_device *device = open_or_fail(&opened, NULL);
    struct scene *cube = fixture_scene("cube");
    svo_plan *plan = NULL;
    expect(device, svo_plan_create(device, scene_mesh(cube), 4, NULL, &plan), SVO_OK, "");
    char *driver = NULL;
    assert_int_equal(svo_i_device_text(info_of_device(device).device, CL_DRIVER_VERSION, "", NULL, &driver, NULL),
                     SVO_OK);
    const bool is_pocl_3 = strstr(info_of_device(device).name, "Portable Computing") != NULL && driver[0] == '3';
    svo_i_free(driver);
    short_builds = 0;
    refuses_short = true;
    expect(device, svo_device_warm(device, plan), SVO_OK, "");
    assert_int_equal(short_builds, is_pocl_3 ? info_of_plan(plan).kernels_count : 0);
    svo_plan_destroy(&plan);
    svo_device_destroy(&device);
    scene_destroy(&cube);
}

/* A program of many devices, and one that the driver has no binary of. Nothing is written. */
static void binaries_that_are_not_there(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const cl_uint many = 65;
    static const size_t none[64];
    svo_device *device = open_or_fail(&opened, NULL);
    struct scene *cube = fixture_scene("cube");
    svo_plan *plan = NULL;
    size_t saved = 7;
    expect(device, svo_plan_create(device, scene_mesh(cube), 4, NULL, &plan), SVO_OK, "");
    expect(device, svo_device_warm(device, plan), SVO_OK, "");
    program_answer = (answer){CL_PROGRAM_NUM_DEVICES, &many, sizeof many};
    expect(device, svo_device_save_kernels(device, "/tmp", &saved), SVO_UNSUPPORTED,
           "svo_device_save_kernels: the context has 65 devices, above 64");
    program_answer = (answer){CL_PROGRAM_BINARY_SIZES, none, sizeof(size_t)};
    expect(device, svo_device_save_kernels(device, "/tmp", &saved), SVO_CL_ERROR, "CL_PROGRAM_BINARY_SIZES");
    assert_int_equal(saved, 7);
    svo_plan_destroy(&plan);
    svo_device_destroy(&device);
    scene_destroy(&cube);
}

/* ---- rays ---- */

/* Two triangles in a grid of the unit cube: a wall inside its face x = 0 by less than a grid unit, and one that reaches
   far out. */
static svo_tree *build_wall(svo_device *device)
{
    static const float wall = 0.45F * 0x1p-20F;
    const float positions[6][3] = {{wall, 0, 0},     {wall, 1, 0},        {wall, 0, 1},
                                   {-3, 0.9F, 0.9F}, {0.2F, 0.9F, 0.95F}, {-3, 0.95F, 0.9F}};
    const uint32_t indices[6] = {0, 1, 2, 3, 4, 5};
    const svo_mesh mesh = {.struct_size = sizeof mesh,
                           .positions = positions[0],
                           .vertex_count = 6,
                           .indices = indices,
                           .triangle_count = 2};
    svo_plan_options options = {.struct_size = sizeof options, .need = SVO_NEED_RAYS, .edge = 1};
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    expect(device, svo_plan_create(device, &mesh, 8, &options, &plan), SVO_OK, "");
    expect(device, svo_build(plan, NULL, NULL, &tree, NULL), SVO_OK, "");
    svo_plan_destroy(&plan);
    return tree;
}

/* The driver fuses although the kernels forbid it, in float or in double: rays of triangles are refused with words. */
static void a_device_that_fuses_is_refused(void **state)
{
    static const char *const kinds[] = {"float", "double"};
    const fixture opened = fixture_cl_of_group(state);
    for (int i = 0; i < (opened.device->has_fp64 ? 2 : 1); ++i) {
        char text[128], fused[128];
        (void)snprintf(text, sizeof text, "(%s a, %s b, %s c, %s d)\n{\n\treturn a * b - c * d;", kinds[i], kinds[i],
                       kinds[i], kinds[i]);
        (void)snprintf(fused, sizeof fused, "(%s a, %s b, %s c, %s d)\n{\n\treturn fma(a, b, -(c * d));", kinds[i],
                       kinds[i], kinds[i], kinds[i]);
        svo_device *device = open_or_fail(&opened, NULL);
        svo_tree *tree = build_wall(device);
        svo_ray ray = {.origin = {0.5F, 0.2F, 0.2F}, .direction = {-1, 0, 0}, .t_max = 1};
        svo_hit hit;
        replaced = text;
        replacement = fused;
        expect(device,
               svo_trace_triangles(svo_tree_target(tree), svo_in_host(&ray), svo_in_host(&hit), 1, SVO_TRACE_CLOSEST,
                                   NULL),
               SVO_UNSUPPORTED, " fuses multiplications and additions although the kernels forbid it");
        assert_int_equal(replacements, 1);
        assert_int_equal(info_of_tree(tree).ray_bytes, 0);
        assert_int_equal(forget_answers(NULL), 0);
        svo_tree_destroy(&tree);
        svo_device_destroy(&device);
    }
}

/* Floats of coordinates far away round by more than the wall is inside: its hits count all the same. */
static void hits_at_the_border_count_without_doubles(void **state)
{
    enum { RAYS = 256 };
    const fixture opened = fixture_cl_of_group(state);
    svo_ray rays[RAYS];
    svo_hit hits[RAYS];
    for (int path = SVO_PATH_CPU; path <= SVO_PATH_GPU; ++path) {
        svo_device *device = open_or_fail(
            &opened, &(svo_device_options){.struct_size = sizeof(svo_device_options), .path = (svo_path)path});
        for (int i = 0; i < RAYS; ++i) {
            const int row = i / 16;
            const float y = 0.01F + 0.48F * (float)(i % 16) / 16.0F;
            const float z = 0.01F + 0.48F * (float)row / 16.0F;
            rays[i] = (svo_ray){.origin = {40.3F, y, z}, .direction = {-1, 0.001F * y, 0}, .t_max = INFINITY};
        }
        device->has_fp64 = false;
        svo_tree *tree = build_wall(device);
        replaced = "#ifdef cl_khr_fp64";
        replacement = "#undef cl_khr_fp64\n#ifdef cl_khr_fp64";
        expect(device,
               svo_trace_triangles(svo_tree_target(tree), svo_in_host(rays), svo_in_host(hits), RAYS, SVO_TRACE_CLOSEST,
                                   NULL),
               SVO_OK, "");
        assert_true(replacements >= 2); /* the BVH's kernels and the rays' */
        for (int i = 0; i < RAYS; ++i) {
            if (hits[i].triangle != 0 || !(fabsf(hits[i].t - 40.3F) < 0x1p-15F)) {
                fail_msg("path %d: ray %d meets triangle %u at %a, expected 0 at 40.3", path, i, hits[i].triangle,
                         (double)hits[i].t);
            }
        }
        rays[0] = (svo_ray){.origin = {40.3F, 0.915F, 0.915F}, .direction = {-1, 0, 0}, .t_max = INFINITY};
        expect(device,
               svo_trace_triangles(svo_tree_target(tree), svo_in_host(rays), svo_in_host(hits), 1, SVO_TRACE_CLOSEST,
                                   NULL),
               SVO_OK, "");
        assert_int_equal(hits[0].triangle, SVO_NO_TRIANGLE); /* at x = -2 */
        assert_int_equal(forget_answers(NULL), 0);
        svo_tree_destroy(&tree);
        svo_device_destroy(&device);
    }
}

TEST_GROUP(unusual_device)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(devices_that_are_refused, forget_answers),
        cmocka_unit_test_teardown(paths_of_devices, forget_answers),
        cmocka_unit_test_teardown(a_path_that_is_none_is_refused, forget_answers),
        cmocka_unit_test_teardown(widths_of_devices, forget_answers),
        cmocka_unit_test_teardown(staging_of_devices, forget_answers),
        cmocka_unit_test_teardown(little_local_memory, forget_answers),
        cmocka_unit_test_teardown(a_list_above_the_largest_buffer, forget_answers),
        cmocka_unit_test_teardown(lists_above_32_bits_are_cut, forget_answers),
        cmocka_unit_test_teardown(kernels_that_do_not_compile, forget_answers),
        cmocka_unit_test_teardown(drivers_declarations_serve_too, forget_answers),
        cmocka_unit_test_teardown(binaries_that_are_not_there, forget_answers),
        cmocka_unit_test_teardown(a_device_that_fuses_is_refused, forget_answers),
        cmocka_unit_test_teardown(hits_at_the_border_count_without_doubles, forget_answers),
    };
    return cmocka_run_group_tests_name("unusual_device", tests, fixture_group_setup, fixture_group_teardown);
}
