/* SPDX-License-Identifier: MIT */
/*
 * Kernels compiled beforehand and kept in a folder: a build then compiles nothing and makes the same tree; files that
 * are damaged or of another device are passed over; and no build asks a driver for binaries.
 */
#define _POSIX_C_SOURCE 200809L
#include <dirent.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "support/attributed_mesh.h"
#include "support/counting.h"
#include "support/fixture.h"
#include "support/info_of.h"
#include "support/suite.h"

enum { DEPTH = 5, FILES_MAX = 8, PATH_BYTES = 512 };

/* The linker routes the library's calls here. */
static size_t binaries_asked;
/* NOLINTBEGIN(readability-identifier-naming) */
cl_int __real_clGetProgramInfo(cl_program program, cl_program_info what, size_t bytes, void *value, size_t *needed);
cl_int __wrap_clGetProgramInfo(cl_program program, cl_program_info what, size_t bytes, void *value, size_t *needed);

cl_int __wrap_clGetProgramInfo(cl_program program, cl_program_info what, size_t bytes, void *value, size_t *needed)
{
    binaries_asked += what == CL_PROGRAM_BINARIES || what == CL_PROGRAM_BINARY_SIZES;
    return __real_clGetProgramInfo(program, what, bytes, value, needed);
}

static bool refuses_binaries;
cl_program __real_clCreateProgramWithBinary(cl_context context, cl_uint count, const cl_device_id *devices,
                                            const size_t *sizes, const unsigned char **binaries, cl_int *states,
                                            cl_int *error);
cl_program __wrap_clCreateProgramWithBinary(cl_context context, cl_uint count, const cl_device_id *devices,
                                            const size_t *sizes, const unsigned char **binaries, cl_int *states,
                                            cl_int *error);

cl_program __wrap_clCreateProgramWithBinary(cl_context context, cl_uint count, const cl_device_id *devices,
                                            const size_t *sizes, const unsigned char **binaries, cl_int *states,
                                            cl_int *error)
{
    if (refuses_binaries) {
        *error = CL_INVALID_BINARY;
        return NULL;
    }
    return __real_clCreateProgramWithBinary(context, count, devices, sizes, binaries, states, error);
}
/* NOLINTEND(readability-identifier-naming) */

/* A folder with the kernels of one plan, and the hash of its tree. */
typedef struct saved {
    const fixture *opened;
    attributed_mesh made;
    char folder[PATH_BYTES];
    char files[FILES_MAX][PATH_BYTES];
    size_t count;
    char hash[SVO_HASH_TEXT_BYTES];
    unsigned warnings; /* logged by devices of new_device */
} saved;

static void succeed(const svo_device *device, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), svo_device_message(device));
    }
}

static void count_warning(void *user, svo_log_level level, const char *text)
{
    (void)text;
    ((saved *)user)->warnings += level == SVO_LOG_WARNING;
}

/* A device handle that has compiled nothing. */
static svo_device *new_device(saved *kept)
{
    const svo_device_options options = {.struct_size = sizeof options, .log = count_warning, .log_user = kept};
    svo_device *device = NULL;
    svo_message message = {""};
    if (svo_device_create(info_of_device(kept->opened->device).context, info_of_device(kept->opened->device).device,
                          &options, &device, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return device;
}

static svo_plan *new_plan(saved *kept, svo_device *device)
{
    const svo_plan_options options = {.struct_size = sizeof options, .need = SVO_NEED_COLOR, .edge = 1.0};
    svo_plan *plan = NULL;
    succeed(device, svo_plan_create(device, &kept->made.mesh, DEPTH, &options, &plan));
    return plan;
}

/* Builds and compares the tree with the first one. Returns how many programs were compiled from source. */
static uint64_t build(saved *kept, svo_device *device)
{
    svo_plan *plan = new_plan(kept, device);
    svo_tree *tree = NULL;
    char hash[SVO_HASH_TEXT_BYTES];
    const size_t asked = binaries_asked;
    counting_begin();
    succeed(device, svo_build(plan, NULL, NULL, &tree, NULL));
    const uint64_t programs = counting_read().programs;
    assert_int_equal(binaries_asked, asked);
    succeed(device, svo_tree_download(tree, NULL));
    succeed(device, svo_tree_hash(tree, SVO_HASH_ALL, hash));
    if (kept->hash[0] == '\0') {
        memcpy(kept->hash, hash, sizeof hash);
    }
    assert_string_equal(hash, kept->hash);
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    return programs;
}

static void list_files(saved *kept)
{
    DIR *entries = opendir(kept->folder);
    assert_non_null(entries);
    kept->count = 0;
    for (const struct dirent *entry = readdir(entries); entry != NULL; entry = readdir(entries)) {
        if (entry->d_name[0] != '.') {
            assert_true(kept->count < FILES_MAX);
            snprintf(kept->files[kept->count++], PATH_BYTES, "%.200s/%.255s", kept->folder, entry->d_name);
        }
    }
    closedir(entries);
}

static void begin(void **state, saved *kept)
{
    static fixture opened;
    opened = fixture_cl_of_group(state);
    *kept = (saved){.opened = &opened};
    snprintf(kept->folder, sizeof kept->folder, "/tmp/svocl_kernels_XXXXXX");
    assert_non_null(mkdtemp(kept->folder));
    attributed_mesh_create(6, 60, 0.0, &kept->made);
    svo_device *device = new_device(kept);
    svo_plan *plan = new_plan(kept, device);
    size_t written = 0;
    succeed(device, svo_device_warm(device, plan));
    assert_int_equal(build(kept, device), 0);
    succeed(device, svo_device_save_kernels(device, kept->folder, &written));
    list_files(kept);
    assert_int_equal(written, info_of_plan(plan).kernels_count);
    assert_int_equal(written, kept->count);
    svo_plan_destroy(&plan);
    svo_device_destroy(&device);
}

static void end(saved *kept)
{
    list_files(kept);
    for (size_t i = 0; i < kept->count; ++i) {
        assert_int_equal(remove(kept->files[i]), 0); /* an empty folder too */
    }
    assert_int_equal(rmdir(kept->folder), 0); /* nothing else was left in it */
    attributed_mesh_destroy(&kept->made);
}

/* Loads into a new device, which then builds. Returns how many programs were loaded. */
static size_t load_and_build(saved *kept, unsigned warnings)
{
    size_t loaded = SIZE_MAX;
    svo_device *device = new_device(kept);
    kept->warnings = 0;
    succeed(device, svo_device_load_kernels(device, kept->folder, &loaded));
    assert_int_equal(kept->warnings, warnings);
    const uint64_t compiled = build(kept, device);
    svo_plan *plan = new_plan(kept, device);
    assert_int_equal(loaded + compiled, info_of_plan(plan).kernels_count);
    svo_plan_destroy(&plan);
    svo_device_destroy(&device);
    return loaded;
}

static void saved_kernels_replace_compiling(void **state)
{
    saved kept;
    size_t again = SIZE_MAX;
    begin(state, &kept);
    const size_t files = kept.count;
    assert_int_equal(load_and_build(&kept, 0), files);
    svo_device *device = new_device(&kept);
    succeed(device, svo_device_load_kernels(device, kept.folder, NULL));
    succeed(device, svo_device_load_kernels(device, kept.folder, &again));
    assert_int_equal(again, 0); /* the handle has them */
    const size_t asked = binaries_asked;
    succeed(device, svo_device_save_kernels(device, kept.folder, &again));
    assert_int_equal(again, 0); /* the folder has them */
    assert_int_equal(binaries_asked, asked);
    svo_device_destroy(&device);
    end(&kept);
}

static size_t read_bytes(const char *path, unsigned char **bytes)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    const long size = ftell(file);
    rewind(file);
    *bytes = malloc((size_t)size);
    assert_non_null(*bytes);
    assert_int_equal(fread(*bytes, 1, (size_t)size, file), size);
    fclose(file);
    return (size_t)size;
}

static void write_bytes(const char *path, const unsigned char *bytes, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

/* One bit of each part of a file, and a file that is cut. The driver never sees them. */
static void damaged_files_are_passed_over_and_replaced(void **state)
{
    saved kept;
    begin(state, &kept);
    const size_t files = kept.count;
    unsigned char *bytes = NULL;
    const size_t size = read_bytes(kept.files[0], &bytes);
    const size_t at[] = {0, 9, 17, 24, 39, 60, size / 2, size - 1};
    for (size_t i = 0; i < sizeof at / sizeof at[0]; ++i) {
        bytes[at[i]] ^= 4;
        write_bytes(kept.files[0], bytes, size);
        bytes[at[i]] ^= 4;
        assert_int_equal(load_and_build(&kept, 1), files - 1);
    }
    const size_t cut[] = {0, 1, 39, 40, size - 1};
    for (size_t i = 0; i < sizeof cut / sizeof cut[0]; ++i) {
        write_bytes(kept.files[0], bytes, cut[i]);
        assert_int_equal(load_and_build(&kept, 1), files - 1);
    }
    svo_device *device = new_device(&kept);
    size_t written = 0;
    assert_int_equal(build(&kept, device), files);
    succeed(device, svo_device_save_kernels(device, kept.folder, &written));
    assert_int_equal(written, 1);
    svo_device_destroy(&device);
    assert_int_equal(load_and_build(&kept, 0), files);
    free(bytes);
    end(&kept);
}

/* Replaces a part of a file's key by as many bytes, and makes the file whole again. */
static void rewrite_key(const char *path, const char *from, const char *to)
{
    unsigned char *bytes = NULL;
    const size_t size = read_bytes(path, &bytes), length = strlen(from);
    unsigned char *at = bytes + 40;
    assert_int_equal(length, strlen(to));
    while (memcmp(at, from, length) != 0) {
        ++at;
        assert_true(at < bytes + size - length);
    }
    memcpy(at, to, length);
    XXH3_state_t hash;
    XXH128_canonical_t canonical;
    XXH3_128bits_reset(&hash);
    XXH3_128bits_update(&hash, bytes, 24);
    XXH3_128bits_update(&hash, bytes + 40, size - 40);
    XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(&hash));
    memcpy(bytes + 24, &canonical, sizeof canonical);
    write_bytes(path, bytes, size);
    free(bytes);
}

/* Files with another driver, program or options in their keys, whole as they are, and things that are no files of
   kernels. */
static void files_of_others_are_passed_over(void **state)
{
    static const char *const keys[][2] = {{"\ndriver ", "\nDriver "},
                                          {"\nprogram ", "\nProgram "},
                                          {"\nprogram ", "\nprogram-"},
                                          {"\noptions -cl-std=CL1.2", "\noptions -cl-std=CL1.1"}};
    saved kept;
    begin(state, &kept);
    const size_t files = kept.count;
    char path[PATH_BYTES];
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; ++i) {
        rewrite_key(kept.files[0], keys[i][0], keys[i][1]);
        assert_int_equal(load_and_build(&kept, 0), files - 1);
        rewrite_key(kept.files[0], keys[i][1], keys[i][0]);
    }
    assert_int_equal(load_and_build(&kept, 0), files);
    rewrite_key(kept.files[0], "\nprogram ", "\nprogram=");
    snprintf(path, sizeof path, "%.200s/notes.txt", kept.folder);
    write_bytes(path, (const unsigned char *)"words", 5);
    assert_int_equal(load_and_build(&kept, 0), files - 1);
    snprintf(path, sizeof path, "%.200s/words.kernels", kept.folder);
    write_bytes(path, (const unsigned char *)"words", 5);
    assert_int_equal(load_and_build(&kept, 1), files - 1);
    snprintf(path, sizeof path, "%.200s/folder.kernels", kept.folder);
    assert_int_equal(mkdir(path, 0777), 0);
    assert_int_equal(load_and_build(&kept, 2), files - 1);
    end(&kept);
}

/* PoCL compiles for the instructions that the variable names. */
static void files_of_another_environment_are_passed_over(void **state)
{
    saved kept;
    begin(state, &kept);
    const char *set = getenv("POCL_WORK_GROUP_METHOD");
    assert_null(set);
    setenv("POCL_WORK_GROUP_METHOD", "loops", 1);
    svo_device *device = new_device(&kept);
    size_t loaded = SIZE_MAX;
    succeed(device, svo_device_load_kernels(device, kept.folder, &loaded));
    assert_int_equal(loaded, 0);
    svo_device_destroy(&device);
    unsetenv("POCL_WORK_GROUP_METHOD");
    assert_int_equal(load_and_build(&kept, 0), kept.count);
    end(&kept);
}

/* The source in the key is not that of this library: the file is loaded, and its program is compiled all the same. */
static void files_of_another_version_are_not_used(void **state)
{
    saved kept;
    size_t loaded = 0;
    begin(state, &kept);
    unsigned char *bytes = NULL;
    read_bytes(kept.files[0], &bytes);
    const char *at = strstr((const char *)bytes + 40, "\nsource ");
    assert_non_null(at);
    char from[42] = "", to[42] = "";
    memcpy(from, at, 40);
    memcpy(to, at, 40);
    to[39] = to[39] == '0' ? '1' : '0';
    rewrite_key(kept.files[0], from, to);
    free(bytes);
    svo_device *device = new_device(&kept);
    succeed(device, svo_device_load_kernels(device, kept.folder, &loaded));
    assert_int_equal(loaded, kept.count);
    assert_int_equal(build(&kept, device), 1);
    svo_device_destroy(&device);
    end(&kept);
}

static void binaries_that_the_driver_refuses_are_compiled(void **state)
{
    saved kept;
    begin(state, &kept);
    refuses_binaries = true;
    assert_int_equal(load_and_build(&kept, (unsigned)kept.count), 0);
    refuses_binaries = false;
    assert_int_equal(load_and_build(&kept, 0), kept.count);
    end(&kept);
}

static void folders_that_do_not_work_are_named(void **state)
{
    saved kept;
    char path[PATH_BYTES];
    size_t loaded = SIZE_MAX;
    begin(state, &kept);
    svo_device *device = new_device(&kept);
    snprintf(path, sizeof path, "%.200s/none", kept.folder);
    succeed(device, svo_device_load_kernels(device, path, &loaded));
    assert_int_equal(loaded, 0);
    assert_int_equal(svo_device_load_kernels(device, kept.files[0], NULL), SVO_FILE_ERROR);
    assert_non_null(strstr(svo_device_message(device), kept.files[0]));
    succeed(device, svo_device_load_kernels(device, kept.folder, NULL));
    assert_int_equal(svo_device_save_kernels(device, kept.files[0], NULL), SVO_FILE_ERROR);
    assert_non_null(strstr(svo_device_message(device), kept.files[0]));
    snprintf(path, sizeof path, "%.200s/none/below", kept.folder);
    assert_int_equal(svo_device_save_kernels(device, path, NULL), SVO_FILE_ERROR);
    assert_int_equal(svo_device_load_kernels(device, NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_device_save_kernels(device, "", NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_device_load_kernels(NULL, kept.folder, NULL), SVO_INVALID_ARGUMENT);
    svo_device_destroy(&device);
    end(&kept);
}

static void plans_of_another_device_do_not_warm(void **state)
{
    saved kept;
    begin(state, &kept);
    svo_device *device = new_device(&kept);
    svo_device *other = new_device(&kept);
    svo_plan *plan = new_plan(&kept, other);
    assert_int_equal(svo_device_warm(device, plan), SVO_INVALID_ARGUMENT);
    assert_string_equal(svo_device_message(device), "svo_device_warm: plan is of another device");
    assert_int_equal(svo_device_warm(device, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_device_warm(NULL, plan), SVO_INVALID_ARGUMENT);
    svo_plan_destroy(&plan);
    svo_device_destroy(&other);
    svo_device_destroy(&device);
    end(&kept);
}

TEST_GROUP(saved_kernels)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(saved_kernels_replace_compiling),
        cmocka_unit_test(damaged_files_are_passed_over_and_replaced),
        cmocka_unit_test(files_of_others_are_passed_over),
        cmocka_unit_test(files_of_another_environment_are_passed_over),
        cmocka_unit_test(files_of_another_version_are_not_used),
        cmocka_unit_test(binaries_that_the_driver_refuses_are_compiled),
        cmocka_unit_test(folders_that_do_not_work_are_named),
        cmocka_unit_test(plans_of_another_device_do_not_warm),
    };
    return cmocka_run_group_tests_name("saved_kernels", tests, fixture_group_setup, fixture_group_teardown);
}
