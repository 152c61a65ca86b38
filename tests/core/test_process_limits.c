/* SPDX-License-Identifier: MIT */
/*
 * What the process may have of memory, over invented limits: which of them counts, and that a handle refuses what they
 * do not leave before it begins, with words that name the limit and its value.
 */
#define _GNU_SOURCE /* memfd_create */
#include <CL/cl_ext.h>
#include <errno.h>
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmocka.h>

#include "core/device.h"
#include "core/limits.h"
#include "support/attributed_mesh.h"
#include "support/fixture.h"
#include "support/info_of.h"
#include "support/suite.h"

#define MIB        (UINT64_C(1) << 20)
#define PAGE_BYTES ((uint64_t)sysconf(_SC_PAGESIZE))

/* ---- invented limits ---- */

typedef struct invented_file {
    const char *path, *text;
} invented_file;

/* Of the files below /proc and /sys that are opened; NULL: the machine's own. */
static const invented_file *files;
static rlim_t space; /* 0: the process's own */
static cl_device_type type; /* 0: the device's own */
static bool has_platforms = true;

/* NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming): names of ld --wrap */
int __real_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...)
{
    if (files == NULL || (strncmp(path, "/proc/", 6) != 0 && strncmp(path, "/sys/", 5) != 0)) {
        return __real_open(path, flags, 0600);
    }
    for (const invented_file *file = files; file->path != NULL; ++file) {
        if (strcmp(file->path, path) == 0) {
            const int made = memfd_create("invented", MFD_CLOEXEC);
            assert_true(made >= 0 && write(made, file->text, strlen(file->text)) == (ssize_t)strlen(file->text));
            assert_int_equal(lseek(made, 0, SEEK_SET), 0);
            return made;
        }
    }
    errno = ENOENT;
    return -1;
}

int __real_getrlimit(__rlimit_resource_t resource, struct rlimit *limit);
int __wrap_getrlimit(__rlimit_resource_t resource, struct rlimit *limit);
int __wrap_getrlimit(__rlimit_resource_t resource, struct rlimit *limit)
{
    if (space == 0 || resource != RLIMIT_AS) {
        return __real_getrlimit(resource, limit);
    }
    *limit = (struct rlimit){.rlim_cur = space, .rlim_max = RLIM_INFINITY};
    return 0;
}

cl_int __real_clGetDeviceInfo(cl_device_id device, cl_device_info property, size_t bytes, void *value, size_t *needed);
cl_int __wrap_clGetDeviceInfo(cl_device_id device, cl_device_info property, size_t bytes, void *value, size_t *needed);
cl_int __wrap_clGetDeviceInfo(cl_device_id device, cl_device_info property, size_t bytes, void *value, size_t *needed)
{
    if (type != 0 && property == CL_DEVICE_TYPE && value != NULL) {
        *(cl_device_type *)value = type;
        return CL_SUCCESS;
    }
    if (type != 0 && property == CL_DEVICE_HOST_UNIFIED_MEMORY && value != NULL) {
        *(cl_bool *)value = CL_FALSE;
        return CL_SUCCESS;
    }
    return __real_clGetDeviceInfo(device, property, bytes, value, needed);
}

cl_int __real_clGetPlatformIDs(cl_uint count, cl_platform_id *platforms, cl_uint *found);
cl_int __wrap_clGetPlatformIDs(cl_uint count, cl_platform_id *platforms, cl_uint *found);
cl_int __wrap_clGetPlatformIDs(cl_uint count, cl_platform_id *platforms, cl_uint *found)
{
    return has_platforms ? __real_clGetPlatformIDs(count, platforms, found) : CL_PLATFORM_NOT_FOUND_KHR;
}
/* NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming) */

static int forget_invented(void **state)
{
    (void)state;
    files = NULL;
    space = 0;
    type = 0;
    has_platforms = true;
    return 0;
}

/* ---- which limit counts ---- */

static void expect_group(const invented_file *invented, const char *name, uint64_t bytes, uint64_t used_bytes)
{
    files = invented;
    const svo_i_limit limit = svo_i_limit_read(SVO_I_LIMIT_GROUP);
    if (limit.bytes != bytes || limit.used_bytes != used_bytes || strstr(limit.name, name) == NULL) {
        fail_msg("%s: %llu of %llu bytes; expected %s: %llu of %llu", limit.name, (unsigned long long)limit.used_bytes,
                 (unsigned long long)limit.bytes, name, (unsigned long long)used_bytes, (unsigned long long)bytes);
    }
}

/* Of a group and those above it, the one that leaves the least; bytes of files are given up when memory is short. */
static void the_group_that_leaves_the_least_counts(void **state)
{
    (void)state;
    static const invented_file second[] = {
        {"/proc/self/cgroup", "3:cpu:/other\n0::/a/b\n"},
        {"/sys/fs/cgroup/a/b/memory.max", "max\n"},
        {"/sys/fs/cgroup/a/memory.max", "1000000\n"},
        {"/sys/fs/cgroup/a/memory.current", "700000\n"},
        {"/sys/fs/cgroup/a/memory.stat", "anon 5\ninactive_anon 7\ninactive_file 100000\nactive_file 50000\n"},
        {"/sys/fs/cgroup/memory.max", "5000000\n"},
        {"/sys/fs/cgroup/memory.current", "4000000\n"},
        {NULL, NULL}};
    static const invented_file first[] = {
        {"/proc/self/cgroup", "5:pids:/p\n4:cpu,memory:/job/1\n2:hugememory:/no\n0::/\n"},
        {"/sys/fs/cgroup/memory/job/1/memory.limit_in_bytes", "9223372036854771712\n"},
        {"/sys/fs/cgroup/memory/job/memory.limit_in_bytes", "3000000\n"},
        {"/sys/fs/cgroup/memory/job/memory.usage_in_bytes", "2000000\n"},
        {"/sys/fs/cgroup/memory/job/memory.stat", "inactive_file 1\ntotal_inactive_file 500000\n"},
        {"/sys/fs/cgroup/memory/memory.limit_in_bytes", "2500000\n"},
        {"/sys/fs/cgroup/memory/memory.usage_in_bytes", "2400000\n"},
        {NULL, NULL}};
    expect_group(second, "memory.max", 1000000, 550000);
    expect_group(first, "memory.limit_in_bytes", 2500000, 2400000);
}

/* In a container the folder of the group's name is not there, but the root is the container's own. */
static void the_root_counts_where_the_group_is_not_seen(void **state)
{
    (void)state;
    static const invented_file container[] = {{"/proc/self/cgroup", "0::/host/slice\n"},
                                              {"/sys/fs/cgroup/memory.max", "4096\n"},
                                              {"/sys/fs/cgroup/memory.current", "9000\n"},
                                              {NULL, NULL}};
    expect_group(container, "memory.max", 4096, 9000);
    const svo_i_limit limit = svo_i_limit_read(SVO_I_LIMIT_GROUP);
    assert_int_equal(svo_i_limit_left(&limit), 0);
    assert_int_equal(svo_i_host_memory_bytes(), 4096);
}

static void what_cannot_be_read_limits_nothing(void **state)
{
    (void)state;
    static const char *const texts[] = {"", "0", "0:\n", "memory:\n:memory\n", "1:memory\n0:x:/\n", "\n\n::\n"};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; ++i) {
        const invented_file one[] = {
            {"/proc/self/cgroup", texts[i]}, {"/sys/fs/cgroup/memory.max", "eggs\n"}, {NULL, NULL}};
        expect_group(one, "memory.max", UINT64_MAX, 0);
    }
    const svo_i_limit none = svo_i_limit_read(SVO_I_LIMIT_GROUP);
    assert_true(svo_i_limit_left(&none) == UINT64_MAX);
}

static void address_space_counts_by_pages(void **state)
{
    (void)state;
    static const invented_file taken[] = {{"/proc/self/statm", "1000 9 9 9 9 9 9\n"}, {NULL, NULL}};
    files = taken;
    space = 1000 * PAGE_BYTES + 77;
    const svo_i_limit limit = svo_i_limit_read(SVO_I_LIMIT_SPACE);
    assert_int_equal(limit.used_bytes, 1000 * PAGE_BYTES);
    assert_int_equal(svo_i_limit_left(&limit), 77);
    assert_int_equal(svo_i_host_memory_bytes(), space);
}

/* Each message of a failed allocation, once; other messages do not. */
static void messages_name_the_limit(void **state)
{
    (void)state;
    svo_message message = {""};
    space = 4096 * MIB;
    (void)svo_i_fail(&message, SVO_OUT_OF_HOST_MEMORY, "f: no memory for %d bytes", 12);
    assert_non_null(
        strstr(message.text, "f: no memory for 12 bytes; out of memory: RLIMIT_AS (ulimit -v) is 4.0 GiB, "));
    const svo_message once = message;
    (void)svo_i_fail(&message, SVO_OUT_OF_HOST_MEMORY, "%s", once.text);
    assert_string_equal(message.text, once.text);
    (void)svo_i_fail_cl(&message, "f", "clFinish", CL_OUT_OF_RESOURCES);
    assert_non_null(strstr(message.text, "; out of memory: RLIMIT_AS (ulimit -v) is 4.0 GiB, "));
    (void)svo_i_fail(&message, SVO_FILE_ERROR, "f: no file");
    assert_string_equal(message.text, "f: no file");
    assert_int_equal(svo_i_fail(NULL, SVO_OUT_OF_HOST_MEMORY, "f"), SVO_OUT_OF_HOST_MEMORY);
    space = 0;
    (void)svo_i_fail(&message, SVO_OUT_OF_HOST_MEMORY, "f: no memory");
    assert_true(strcmp(message.text, "f: no memory") == 0 || strstr(message.text, "RLIMIT_AS") != NULL);
}

/* ---- devices ---- */

static svo_device *make_device(const fixture *opened)
{
    svo_device *device = NULL;
    svo_message message = {""};
    const svo_device_info info = info_of_device(opened->device);
    if (svo_device_create(info.context, info.device, NULL, &device, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return device;
}

static svo_status build(svo_device *device, const svo_mesh *mesh, char hash[SVO_HASH_TEXT_BYTES])
{
    const svo_plan_options options = {.struct_size = sizeof options, .need = SVO_NEED_COLOR, .edge = 1.0};
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(svo_plan_create(device, mesh, 6, &options, &plan));
    SVO_I_TRY_CLEANUP(svo_build(plan, NULL, NULL, &tree, NULL));
    SVO_I_TRY_CLEANUP(svo_tree_download(tree, NULL));
    SVO_I_TRY_CLEANUP(svo_tree_hash(tree, SVO_HASH_ALL, hash));
cleanup:
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    return status;
}

static void expect(const svo_device *device, svo_status status, svo_status expected, const char *const words[3])
{
    for (int i = 0; i < 3; ++i) {
        if (status != expected || strstr(svo_device_message(device), words[i]) == NULL) {
            fail_msg("%s \"%s\", expected %s \"%s\"", svo_name(SVO_NAME_STATUS, status), svo_device_message(device),
                     svo_name(SVO_NAME_STATUS, expected), words[i]);
        }
    }
}

/* A group of so many MiB, all but left_mib of them used. */
static const invented_file *group_of(unsigned mib, unsigned left_mib)
{
    static char limit[32], used[32];
    static const invented_file group[] = {{"/proc/self/cgroup", "0::/\n"},
                                          {"/sys/fs/cgroup/memory.max", limit},
                                          {"/sys/fs/cgroup/memory.current", used},
                                          {NULL, NULL}};
    (void)snprintf(limit, sizeof limit, "%llu\n", (unsigned long long)(mib * MIB));
    (void)snprintf(used, sizeof used, "%llu\n", (unsigned long long)((mib - left_mib) * MIB));
    return group;
}

/* A device of the host's memory has no more than the process; the tree is the same with a limit that leaves enough. */
static void a_plan_above_the_limit_is_refused_beforehand(void **state)
{
    static const char *const little[] = {"svo_build: the scene needs about ",
                                         "out of memory: ", "memory.max is 512.0 MiB, which leaves 1.0 MiB beside"};
    static const char *const nothing[] = {"out of memory: ", "memory.max is 512.0 MiB", "leaves 0 bytes beside"};
    const fixture opened = fixture_cl_of_group(state);
    char expected[SVO_HASH_TEXT_BYTES], actual[SVO_HASH_TEXT_BYTES];
    attributed_mesh made;
    attributed_mesh_create(6, 300, 0.1, &made);
    svo_device *device = make_device(&opened);
    assert_int_equal(build(device, &made.mesh, expected), SVO_OK);
    svo_device_destroy(&device);
    files = group_of(512, 193);
    device = make_device(&opened);
    expect(device, build(device, &made.mesh, actual), SVO_OUT_OF_DEVICE_MEMORY, little);
    assert_false(device->has_compiled);
    svo_device_destroy(&device);
    files = group_of(512, 192);
    device = make_device(&opened);
    expect(device, build(device, &made.mesh, actual), SVO_OUT_OF_HOST_MEMORY, nothing);
    svo_device_destroy(&device);
    files = group_of(512, 500);
    device = make_device(&opened);
    assert_int_equal(build(device, &made.mesh, actual), SVO_OK);
    assert_string_equal(actual, expected);
    svo_device_destroy(&device);
    attributed_mesh_destroy(&made);
}

/* A driver may get memory for a buffer when it is first used, so what is held counts beside what the process has. */
static void buffers_count_before_they_are_used(void **state)
{
    static const char *const words[] = {"f: buffer b needs 60.0 MiB beside the 60.0 MiB in use, and is out of memory: ",
                                        "RLIMIT_AS (ulimit -v) is ", "which leaves 40.0 MiB beside"};
    static const invented_file taken[] = {{"/proc/self/statm", "1000\n"}, {NULL, NULL}};
    const fixture opened = fixture_cl_of_group(state);
    cl_mem buffers[3] = {NULL, NULL, NULL};
    files = taken;
    space = 1000 * PAGE_BYTES + (192 + 100) * MIB;
    svo_device *device = make_device(&opened);
    assert_int_equal(svo_i_device_buffer(device, "f", "a", CL_MEM_READ_WRITE, 60 * MIB, &buffers[0]), SVO_OK);
    expect(device, svo_i_device_buffer(device, "f", "b", CL_MEM_READ_WRITE, 60 * MIB, &buffers[1]),
           SVO_OUT_OF_DEVICE_MEMORY, words);
    assert_int_equal(svo_i_device_buffer(device, "f", "c", CL_MEM_READ_WRITE, 40 * MIB, &buffers[1]), SVO_OK);
    svo_i_buffer_release(&buffers[0]);
    assert_int_equal(svo_i_device_buffer(device, "f", "d", CL_MEM_READ_WRITE, 60 * MIB, &buffers[2]), SVO_OK);
    svo_i_buffer_release(&buffers[1]);
    svo_i_buffer_release(&buffers[2]);
    svo_device_destroy(&device);
}

/* What the process takes elsewhere counts too, and a limit that is lifted counts no more. */
static void limits_are_read_again(void **state)
{
    static const char *const words[] = {"f: buffer b needs ", "memory.max is 512.0 MiB", "which leaves 8.0 MiB beside"};
    const fixture opened = fixture_cl_of_group(state);
    cl_mem buffer = NULL;
    files = group_of(512, 400);
    svo_device *device = make_device(&opened);
    files = group_of(512, 200);
    expect(device, svo_i_device_buffer(device, "f", "b", CL_MEM_READ_WRITE, 9 * MIB, &buffer), SVO_OUT_OF_DEVICE_MEMORY,
           words);
    files = group_of(512, 400);
    expect(device, svo_i_device_buffer(device, "f", "b", CL_MEM_READ_WRITE, 300 * MIB, &buffer),
           SVO_OUT_OF_DEVICE_MEMORY, (const char *const[3]){"memory.max", "512.0 MiB", "which leaves 208.0 MiB"});
    files = (const invented_file[]){{NULL, NULL}};
    assert_int_equal(svo_i_device_buffer(device, "f", "b", CL_MEM_READ_WRITE, 300 * MIB, &buffer), SVO_OK);
    svo_i_buffer_release(&buffer);
    svo_device_destroy(&device);
}

static void nothing_compiles_where_a_compiler_would_end_the_process(void **state)
{
    static const char *const words[] = {"f: out of memory: compiling kernels needs about 192.0 MiB, and ",
                                        "RLIMIT_AS (ulimit -v) is ", "which leaves 191.0 MiB"};
    static const invented_file taken[] = {{"/proc/self/statm", "1000\n"}, {NULL, NULL}};
    const fixture opened = fixture_cl_of_group(state);
    files = taken;
    space = 1000 * PAGE_BYTES + 191 * MIB;
    svo_device *device = make_device(&opened);
    expect(device, svo_i_device_check_compiler(device, "f"), SVO_OUT_OF_HOST_MEMORY, words);
    space += MIB;
    assert_int_equal(svo_i_device_check_compiler(device, "f"), SVO_OK);
    space -= 96 * MIB;
    device->has_compiled = true;
    assert_int_equal(svo_i_device_check_compiler(device, "f"), SVO_OK);
    svo_device_destroy(&device);
}

/* Memory of a GPU of its own is none of the process's; and without limits nothing counts. */
static void other_devices_have_no_such_budget(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    files = group_of(512, 10);
    type = CL_DEVICE_TYPE_GPU;
    svo_device *device = make_device(&opened);
    assert_null(device->budget);
    svo_device_destroy(&device);
    type = 0;
    device = make_device(&opened);
    assert_non_null(device->budget);
    assert_false(device->saves_memory);
    svo_device_destroy(&device);
    files = (const invented_file[]){{NULL, NULL}};
    space = RLIM_INFINITY;
    device = make_device(&opened);
    assert_null(device->budget);
    svo_device_destroy(&device);
}

/* The loader says that there is no platform, also where it could load none. */
static void no_platform_and_no_memory_are_told_apart(void **state)
{
    (void)state;
    static const invented_file taken[] = {{"/proc/self/statm", "1000\n"}, {NULL, NULL}};
    svo_device *device = NULL;
    svo_message message = {""};
    has_platforms = false;
    files = taken;
    space = 1000 * PAGE_BYTES + 447 * MIB;
    assert_int_equal(svo_device_create_default(NULL, &device, &message), SVO_OUT_OF_HOST_MEMORY);
    assert_non_null(
        strstr(message.text, "out of memory: no OpenCL platform could be loaded; RLIMIT_AS (ulimit -v) is "));
    assert_non_null(strstr(message.text, "leaves 447.0 MiB"));
    space += MIB;
    assert_int_equal(svo_device_create_default(NULL, &device, &message), SVO_NO_DEVICE);
    assert_non_null(strstr(message.text, "no OpenCL platform is installed"));
    assert_null(device);
    has_platforms = true;
    space = 1000 * PAGE_BYTES + 135 * MIB; /* for the threads of a CPU, at least one */
    assert_int_equal(svo_device_create_default(NULL, &device, &message), SVO_OUT_OF_HOST_MEMORY);
    assert_non_null(strstr(message.text, "out of memory: opening devices needs about "));
    assert_non_null(strstr(message.text, "leaves 135.0 MiB"));
}

TEST_GROUP(process_limits)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(the_group_that_leaves_the_least_counts, forget_invented),
        cmocka_unit_test_teardown(the_root_counts_where_the_group_is_not_seen, forget_invented),
        cmocka_unit_test_teardown(what_cannot_be_read_limits_nothing, forget_invented),
        cmocka_unit_test_teardown(address_space_counts_by_pages, forget_invented),
        cmocka_unit_test_teardown(messages_name_the_limit, forget_invented),
        cmocka_unit_test_teardown(a_plan_above_the_limit_is_refused_beforehand, forget_invented),
        cmocka_unit_test_teardown(buffers_count_before_they_are_used, forget_invented),
        cmocka_unit_test_teardown(limits_are_read_again, forget_invented),
        cmocka_unit_test_teardown(nothing_compiles_where_a_compiler_would_end_the_process, forget_invented),
        cmocka_unit_test_teardown(other_devices_have_no_such_budget, forget_invented),
        cmocka_unit_test_teardown(no_platform_and_no_memory_are_told_apart, forget_invented),
    };
    return cmocka_run_group_tests_name("process_limits", tests, fixture_group_setup, fixture_group_teardown);
}
