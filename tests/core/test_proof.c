/* SPDX-License-Identifier: MIT */
/*
 * A driver that compiles a kernel wrongly is found out before a result of it is stored. The linker puts this file
 * between svocl and the OpenCL loader (ld --wrap, in CMakeLists.txt): after each launch of one kernel it flips a bit of
 * one of that kernel's buffers. Whatever kernel it is, what needs its program fails and names it, or does without it.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "core/opencl.h"
#include "scenes.h"
#include "support/fixture.h"
#include "support/info_of.h"
#include "support/suite.h"

/* ---- the driver ---- */

#define KERNELS_MAX   64
#define ARGUMENTS_MAX 40
#define NAME_BYTES    64

/* A kernel and what its arguments are. */
typedef struct noted_kernel {
    cl_kernel handle;
    cl_mem buffers[ARGUMENTS_MAX];
} noted_kernel;

/* Where a bit is flipped. kernel: NULL: nowhere. */
typedef struct fault {
    const char *kernel;
    cl_uint argument; /* a buffer */
    size_t byte;
} fault;

static struct {
    noted_kernel kernels[KERNELS_MAX];
    size_t next; /* place of the next kernel that is not noted yet */
    fault fault;
    unsigned launches, faults;
} driver;

/* The linker's names for the real calls and for their wrappers. */
/* NOLINTBEGIN(readability-identifier-naming) */
cl_int __real_clSetKernelArg(cl_kernel kernel, cl_uint index, size_t bytes, const void *value);
cl_int __wrap_clSetKernelArg(cl_kernel kernel, cl_uint index, size_t bytes, const void *value);
cl_int __real_clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t *offset,
                                     const size_t *global, const size_t *local, cl_uint num_wait, const cl_event *wait,
                                     cl_event *event);
cl_int __wrap_clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t *offset,
                                     const size_t *global, const size_t *local, cl_uint num_wait, const cl_event *wait,
                                     cl_event *event);

static noted_kernel *find_kernel(cl_kernel handle)
{
    for (size_t i = 0; i < KERNELS_MAX; ++i) {
        if (driver.kernels[i].handle == handle) {
            return &driver.kernels[i];
        }
    }
    noted_kernel *const kernel = &driver.kernels[driver.next++ % KERNELS_MAX];
    *kernel = (noted_kernel){.handle = handle};
    return kernel;
}

cl_int __wrap_clSetKernelArg(cl_kernel kernel, cl_uint index, size_t bytes, const void *value)
{
    assert_true(index < ARGUMENTS_MAX);
    cl_mem *const buffer = &find_kernel(kernel)->buffers[index];
    *buffer = NULL;
    if (bytes == sizeof(cl_mem) && value != NULL) {
        memcpy((void *)buffer, value, sizeof(cl_mem));
    }
    return __real_clSetKernelArg(kernel, index, bytes, value);
}

static bool is_faulty(cl_kernel kernel)
{
    char name[NAME_BYTES] = "";
    return driver.fault.kernel != NULL &&
           clGetKernelInfo(kernel, CL_KERNEL_FUNCTION_NAME, sizeof name, name, NULL) == CL_SUCCESS &&
           strcmp(name, driver.fault.kernel) == 0;
}

static void flip(cl_command_queue queue, cl_kernel kernel)
{
    cl_mem buffer = find_kernel(kernel)->buffers[driver.fault.argument];
    unsigned char byte = 0;
    assert_int_equal(clFinish(queue), CL_SUCCESS);
    assert_int_equal(clEnqueueReadBuffer(queue, buffer, CL_TRUE, driver.fault.byte, 1, &byte, 0, NULL, NULL),
                     CL_SUCCESS);
    byte ^= 1;
    assert_int_equal(clEnqueueWriteBuffer(queue, buffer, CL_TRUE, driver.fault.byte, 1, &byte, 0, NULL, NULL),
                     CL_SUCCESS);
    ++driver.faults;
}

cl_int __wrap_clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t *offset,
                                     const size_t *global, const size_t *local, cl_uint num_wait, const cl_event *wait,
                                     cl_event *event)
{
    ++driver.launches;
    const cl_int error =
        __real_clEnqueueNDRangeKernel(queue, kernel, dimensions, offset, global, local, num_wait, wait, event);
    if (error == CL_SUCCESS && is_faulty(kernel)) {
        flip(queue, kernel);
    }
    return error;
}
/* NOLINTEND(readability-identifier-naming) */

static void use_driver(const char *kernel, cl_uint argument, size_t byte)
{
    driver.fault = (fault){kernel, argument, byte};
    driver.launches = driver.faults = 0;
}

/* ---- devices and builds ---- */

/* What a device was told, one after the other. */
typedef struct told {
    unsigned count;
    svo_log_level level;
    char text[2048];
} told;

static void note_text(void *user, svo_log_level level, const char *text)
{
    told *said = user;
    ++said->count;
    said->level = level;
    (void)snprintf(said->text, sizeof said->text, "%s", text);
}

static svo_device *open_device(const fixture *opened, svo_path path, bool trusts, told *said)
{
    svo_device *device = NULL;
    svo_message message = {""};
    const svo_device_info info = info_of_device(opened->device);
    const svo_device_options options = {.struct_size = sizeof options,
                                        .log = said != NULL ? note_text : NULL,
                                        .log_user = said,
                                        .path = path,
                                        .trust_driver = trusts ? 1 : 0};
    if (svo_device_create(info.context, info.device, &options, &device, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return device;
}

/* A build of a scene, as far as it goes. */
typedef struct recipe {
    const char *scene;
    unsigned depth;
    svo_path path;
    svo_plan_options options;
} recipe;

/* hash: of the tree; where: where the plan was made. NULL allowed. */
static svo_status build(svo_device *device, const recipe *how, char hash[SVO_HASH_TEXT_BYTES], uint32_t *where)
{
    struct scene *made = fixture_scene(how->scene);
    svo_plan_options options = how->options;
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    options.struct_size = sizeof options;
    svo_status status = svo_plan_create(device, scene_mesh(made), how->depth, &options, &plan);
    if (status == SVO_OK && where != NULL) {
        *where = info_of_plan(plan).place;
    }
    if (status == SVO_OK) {
        status = svo_build(plan, NULL, NULL, &tree, NULL);
    }
    if (status == SVO_OK && hash != NULL) {
        assert_int_equal(svo_tree_download(tree, NULL), SVO_OK);
        assert_int_equal(svo_tree_hash(tree, SVO_HASH_ALL, hash), SVO_OK);
    }
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    scene_destroy(&made);
    return status;
}

/* ---- tests ---- */

#define PAYLOAD (SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_FILL)

static const recipe on_device = {
    "cube", 4, SVO_PATH_AUTO, {.need = PAYLOAD | SVO_NEED_PROJECTED_AREA, .place = SVO_PLACE_DEVICE}};
static const recipe by_cpu = {"cube", 4, SVO_PATH_CPU, {.need = PAYLOAD | SVO_NEED_RAYS, .place = SVO_PLACE_HOST}};
static const recipe by_gpu = {"cube", 4, SVO_PATH_GPU, {.need = PAYLOAD | SVO_NEED_RAYS, .place = SVO_PLACE_HOST}};
/* The faces of the cube have colors of their own. */
static const recipe drops_by_cpu = {
    "cube", 4, SVO_PATH_CPU, {.need = SVO_NEED_NONE, .place = SVO_PLACE_HOST, .drop_alpha = 0.5}};
static const recipe drops_by_gpu = {
    "cube", 4, SVO_PATH_GPU, {.need = PAYLOAD, .place = SVO_PLACE_HOST, .drop_alpha = 0.5}};
static const recipe sorted = {
    "cube", 4, SVO_PATH_GPU, {.need = SVO_NEED_RAYS, .builder = SVO_BUILDER_SORTED, .place = SVO_PLACE_HOST}};
static const recipe sorted_by_cpu = {
    "cube", 4, SVO_PATH_CPU, {.need = SVO_NEED_RAYS, .builder = SVO_BUILDER_SORTED, .place = SVO_PLACE_HOST}};

/* A kernel and one of the buffers that it writes, which a build uses. */
typedef struct fault_row {
    const recipe *how;
    const char *kernel;
    cl_uint argument;
} fault_row;

static const fault_row fault_rows[] = {
    {&on_device, "svo_k_plan_totals", 0},
    {&on_device, "svo_k_plan_totals", 1},
    {&on_device, "svo_k_plan_accept", 2},
    {&on_device, "svo_k_plan_bounds", 2},
    {&on_device, "svo_k_plan_snap", 2},
    {&on_device, "svo_k_plan_snap", 3},
    {&on_device, "svo_k_plan_classify", 3},
    {&on_device, "svo_k_plan_classify", 4},
    {&on_device, "svo_k_plan_classify", 5},
    {&on_device, "svo_k_plan_closed", 3},
    {&on_device, "svo_k_plan_keep", 5},
    {&on_device, "svo_k_plan_keep", 6},
    {&on_device, "svo_k_plan_keep", 7},
    {&on_device, "svo_k_plan_keep", 8},
    {&on_device, "svo_k_plan_keep", 9},
    {&on_device, "svo_k_plan_keep", 10},
    {&on_device, "svo_k_plan_keep", 11},
    {&on_device, "svo_k_plan_clear", 1},
    {&on_device, "svo_k_plan_positions", 2},
    {&on_device, "svo_k_plan_normals", 1},
    {&on_device, "svo_k_plan_records", 7},
    {&on_device, "svo_k_plan_records", 8},
    {&on_device, "svo_k_plan_records", 9},
    {&by_cpu, "svo_k_voxelize", 4},
    {&by_cpu, "svo_k_voxelize", 5},
    {&by_gpu, "svo_k_voxelize", 4},
    {&by_gpu, "svo_k_voxelize", 5},
    {&by_cpu, "svo_k_decide", 3},
    {&by_gpu, "svo_k_decide", 3},
    {&by_cpu, "svo_k_keep_decided", 0},
    {&by_cpu, "svo_k_keep_decided", 1},
    {&by_gpu, "svo_k_keep_decided", 1},
    {&drops_by_cpu, "svo_k_drop_pairs", 0},
    {&drops_by_gpu, "svo_k_drop_pairs", 11},
    {&drops_by_cpu, "svo_k_find_places", 3},
    {&drops_by_gpu, "svo_k_move_pairs", 0},
    {&by_cpu, "svo_k_mark", 1},
    {&by_gpu, "svo_k_mark", 1},
    {&by_cpu, "svo_k_mark_above", 0},
    {&by_cpu, "svo_k_make_top", 0},
    {&by_cpu, "svo_k_make_top", 2},
    {&by_gpu, "svo_k_make_top", 3},
    {&by_gpu, "svo_k_make_top", 4},
    {&by_cpu, "svo_k_count_blocks", 1},
    {&by_gpu, "svo_k_count_blocks", 1},
    {&by_cpu, "svo_k_scan_blocks", 0},
    {&by_gpu, "svo_k_scan_blocks", 1},
    {&by_cpu, "svo_k_make_nodes", 3},
    {&by_cpu, "svo_k_make_nodes", 4},
    {&by_gpu, "svo_k_make_nodes", 4},
    {&by_cpu, "svo_k_make_nodes", 0},
    {&by_cpu, "svo_k_find_leaves", 3},
    {&by_cpu, "svo_k_count", 1},
    {&by_cpu, "svo_k_scan_lists_reduce", 1},
    {&by_cpu, "svo_k_scan_lists_add", 2},
    {&by_cpu, "svo_k_scatter", 4},
    {&by_gpu, "svo_k_scatter", 5},
    {&by_cpu, "svo_k_sort_short", 1},
    {&by_cpu, "svo_k_sort_long", 1},
    {&by_cpu, "svo_k_filter", 5},
    {&by_cpu, "svo_k_filter", 6},
    {&by_cpu, "svo_k_filter", 7},
    {&by_cpu, "svo_k_filter", 8},
    {&by_cpu, "svo_k_filter", 9},
    {&by_cpu, "svo_k_filter", 10},
    {&by_cpu, "svo_k_filter_top", 8},
    {&by_gpu, "svo_k_filter_top", 5},
    {&by_gpu, "svo_k_filter_top", 8},
    {&sorted, "svo_k_sort_count", 1},
    {&sorted, "svo_k_sort_scatter", 1},
    {&sorted, "svo_k_scan_lists_add", 2},
    {&sorted, "svo_k_bottom_up_count", 1},
    {&sorted, "svo_k_bottom_up_flags", 1},
    {&sorted, "svo_k_bottom_up_leaves", 2},
    {&sorted, "svo_k_bottom_up_leaves", 3},
    {&sorted, "svo_k_bottom_up_lists", 2},
    {&sorted, "svo_k_bottom_up_lists", 3},
    {&sorted, "svo_k_bottom_up_nodes", 2},
    {&sorted, "svo_k_bottom_up_nodes", 3},
    {&sorted, "svo_k_bottom_up_nodes", 4},
    {&sorted_by_cpu, "svo_k_sort_count", 1},
    {&sorted_by_cpu, "svo_k_sort_scatter", 1},
};

static void expect_found(const fixture *opened, const fault_row *row)
{
    char expected[512];
    char *version = NULL;
    told said = {.count = 0};
    svo_device *device = open_device(opened, row->how->path, false, &said);
    const svo_device_info info = info_of_device(device);
    assert_int_equal(svo_i_device_text(info.device, CL_DRIVER_VERSION, "", NULL, &version, NULL), SVO_OK);
    (void)snprintf(expected, sizeof expected, "%s: kernel %s gives wrong results on %s, driver %s",
                   row->how->options.place == SVO_PLACE_DEVICE ? "svo_plan_create" : "svo_build", row->kernel,
                   info.name, version);
    svo_i_free(version);
    for (unsigned attempt = 0; attempt < 2; ++attempt) {
        use_driver(row->kernel, row->argument, 0);
        const svo_status status = build(device, row->how, NULL, NULL);
        if (status != SVO_DEVICE_UNRELIABLE || strcmp(svo_device_message(device), expected) != 0) {
            fail_msg("%s, argument %u: status %d, '%s'", row->kernel, row->argument, (int)status,
                     svo_device_message(device));
        }
        assert_int_equal(driver.faults, attempt == 0 ? 1 : 0); /* the second time it is known */
    }
    assert_int_equal(said.count, 0);
    svo_device_destroy(&device);
}

static void a_flipped_bit_is_found_and_its_kernel_named(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (size_t i = 0; i < sizeof fault_rows / sizeof fault_rows[0]; ++i) {
        expect_found(&opened, &fault_rows[i]);
    }
    use_driver(NULL, 0, 0);
}

static const recipe with_rays = {"cube", 3, SVO_PATH_AUTO, {.need = SVO_NEED_RAYS, .place = SVO_PLACE_HOST}};

/* Traces a ray against the triangles of a cube, and another against its voxels. */
static svo_status trace(svo_device *device, bool voxels)
{
    const svo_ray ray = {.origin = {0.4F, 0.4F, 9.0F}, .direction = {0.01F, 0.02F, -1.0F}, .t_max = 100.0F};
    struct scene *made = fixture_scene(with_rays.scene);
    svo_plan_options options = with_rays.options;
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    svo_hit hit;
    svo_voxel_hit voxel_hit;
    options.struct_size = sizeof options;
    assert_int_equal(svo_plan_create(device, scene_mesh(made), with_rays.depth, &options, &plan), SVO_OK);
    assert_int_equal(svo_build(plan, NULL, NULL, &tree, NULL), SVO_OK);
    const svo_target target = svo_tree_target(tree);
    svo_status status = SVO_OK;
    if (voxels) {
        status = svo_trace_voxels(target, svo_in_host(&ray), svo_in_host(&voxel_hit), 1, 0.0F, 0, NULL);
    } else {
        status = svo_tree_make_bvh(tree, SVO_BVH_FAST, NULL);
        status =
            status == SVO_OK ? svo_trace_triangles(target, svo_in_host(&ray), svo_in_host(&hit), 1, 0, NULL) : status;
    }
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    scene_destroy(&made);
    return status;
}

/* Rays: the sort of the BVH, products that are fused with sums, quotients that are not rounded. */
static void rays_of_a_wrong_driver_are_refused(void **state)
{
    static const struct {
        bool voxels;
        const char *kernel;
        cl_uint argument;
        size_t byte;
    } rows[] = {{false, "svo_k_sort_scatter", 1, 0}, {false, "svo_k_arithmetic", 1, 4},
                {true, "svo_k_arithmetic", 1, 0},    {true, "svo_k_arithmetic", 1, 8},
                {true, "svo_k_arithmetic", 1, 12},   {true, "svo_k_arithmetic", 1, 16}};
    const fixture opened = fixture_cl_of_group(state);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        svo_device *device = open_device(&opened, SVO_PATH_AUTO, false, NULL);
        use_driver(rows[i].kernel, rows[i].argument, rows[i].byte);
        const svo_status status = trace(device, rows[i].voxels);
        if (status != SVO_DEVICE_UNRELIABLE || strstr(svo_device_message(device), rows[i].kernel) == NULL) {
            fail_msg("row %zu: status %d, '%s'", i, (int)status, svo_device_message(device));
        }
        use_driver(NULL, 0, 0);
        svo_device_destroy(&device);
    }
}

/* Nothing is wrong, and nothing is said: by the kernels of both paths, in each variant that a build may take. */
static void nothing_is_said_of_a_right_driver(void **state)
{
    static const struct {
        unsigned depth;
        svo_plan_options options;
    } rows[] = {{5, {.need = SVO_NEED_ALL, .place = SVO_PLACE_DEVICE}},
                {11, {.need = SVO_NEED_COLOR, .coverage = SVO_COVERAGE_THIN, .edge = 64.0}}, /* the scene is small */
                {5, {.need = SVO_NEED_RAYS, .builder = SVO_BUILDER_SORTED}},
                {1, {.need = SVO_NEED_NONE, .edge = 0.3, .origin = {0.1, 0.1, 0.1}}}};
    const fixture opened = fixture_cl_of_group(state);
    use_driver(NULL, 0, 0);
    for (int path = SVO_PATH_CPU; path <= SVO_PATH_GPU; ++path) {
        told said = {.count = 0};
        svo_device *device = open_device(&opened, (svo_path)path, false, &said);
        for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
            const recipe how = {"cornell", rows[i].depth, (svo_path)path, rows[i].options};
            if (build(device, &how, NULL, NULL) != SVO_OK) {
                fail_msg("row %zu: %s", i, svo_device_message(device));
            }
        }
        if (said.count != 0) {
            fail_msg("%s", said.text);
        }
        svo_device_destroy(&device);
    }
}

static unsigned launches_of(svo_device *device, const recipe *how)
{
    use_driver(NULL, 0, 0);
    assert_int_equal(build(device, how, NULL, NULL), SVO_OK);
    return driver.launches;
}

/* A device that is trusted launches what builds need alone; another one launches more, once. */
static void programs_are_tested_once(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_device *trusted = open_device(&opened, SVO_PATH_AUTO, true, NULL);
    svo_device *tested = open_device(&opened, SVO_PATH_AUTO, false, NULL);
    const unsigned needed = launches_of(trusted, &on_device);
    const unsigned first = launches_of(tested, &on_device);
    assert_true(first > needed);
    assert_int_equal(launches_of(tested, &on_device), launches_of(trusted, &on_device));
    svo_device_destroy(&tested);
    svo_device_destroy(&trusted);
}

/* A caller who trusts the driver gets what it makes. */
static void a_trusted_driver_is_not_tested(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    char hashes[2][SVO_HASH_TEXT_BYTES];
    svo_device *device = open_device(&opened, SVO_PATH_CPU, true, NULL);
    for (unsigned i = 0; i < 2; ++i) {
        use_driver(i == 0 ? NULL : "svo_k_filter_top", 8, 0);
        assert_int_equal(build(device, &by_cpu, hashes[i], NULL), SVO_OK);
    }
    assert_string_not_equal(hashes[0], hashes[1]);
    use_driver(NULL, 0, 0);
    svo_device_destroy(&device);
}

/* The host makes plans in place of kernels that are wrong, and the same trees. It says so once. */
static void plans_are_made_on_the_host_instead(void **state)
{
    static const recipe large = {"terrain:525000", 4, SVO_PATH_AUTO, {.need = SVO_NEED_COLOR}};
    const fixture opened = fixture_cl_of_group(state);
    char hashes[3][SVO_HASH_TEXT_BYTES];
    uint32_t where = SVO_PLACE_DEFAULT;
    told said = {.count = 0};
    svo_device *right = open_device(&opened, SVO_PATH_AUTO, false, &said);
    svo_device *wrong = open_device(&opened, SVO_PATH_AUTO, false, &said);
    use_driver(NULL, 0, 0);
    assert_int_equal(build(right, &large, hashes[0], &where), SVO_OK);
    assert_int_equal(where, SVO_PLACE_DEVICE);
    assert_int_equal(said.count, 0);
    for (unsigned i = 1; i < 3; ++i) {
        use_driver("svo_k_plan_bounds", 2, 0);
        assert_int_equal(build(wrong, &large, hashes[i], &where), SVO_OK);
        assert_int_equal(where, SVO_PLACE_HOST);
        assert_string_equal(hashes[i], hashes[0]);
        assert_int_equal(driver.faults, i == 1 ? 1 : 0);
        assert_int_equal(said.count, 1);
    }
    assert_int_equal(said.level, SVO_LOG_WARNING);
    assert_non_null(strstr(said.text, "svo_plan_create: kernel svo_k_plan_bounds gives wrong results on "));
    assert_non_null(strstr(said.text, "; plans are made on the host"));
    use_driver(NULL, 0, 0);
    svo_device_destroy(&wrong);
    svo_device_destroy(&right);
}

TEST_GROUP(proof)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_flipped_bit_is_found_and_its_kernel_named),
        cmocka_unit_test(rays_of_a_wrong_driver_are_refused),
        cmocka_unit_test(nothing_is_said_of_a_right_driver),
        cmocka_unit_test(programs_are_tested_once),
        cmocka_unit_test(a_trusted_driver_is_not_tested),
        cmocka_unit_test(plans_are_made_on_the_host_instead),
    };
    return cmocka_run_group_tests(tests, fixture_group_setup, fixture_group_teardown);
}
