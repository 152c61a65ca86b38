/* SPDX-License-Identifier: MIT */
/*
 * Compiled programs in the caller's folder: one file per program, named by the hash of its key. The key is a text of
 * everything that the binary depends on: platform, device, driver, its environment, source and options. Drivers are not
 * asked whether a binary is whole (PoCL loads one with a flipped bit without an error), so a file has a checksum.
 *
 *   offset  bytes
 *        0      8  "svokern1"
 *        8      8  bytes of the key, little-endian
 *       16      8  bytes of the binary
 *       24     16  XXH3-128, in canonical order, of the bytes 0 .. 23, the key and the binary
 *       40         the key, then the binary
 */
#define _POSIX_C_SOURCE 200809L
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/opencl.h"
#include "core/program.h"
#include "core/system.h"

#define SAVE "svo_device_save_kernels"
#define LOAD "svo_device_load_kernels"

#define MAGIC        "svokern1"
#define SUFFIX       ".kernels"
#define HEAD_BYTES   40u
#define HASHED_BYTES 24u /* of the head, before the hash */
#define KEY_BYTES    4096
#define VALUE_BYTES  256 /* of a line of the key; longer texts are there by their hash */
#define FILE_MAX     ((size_t)1 << 30)
#define ATTEMPTS_MAX 100

/* What the binary of a program depends on. */
typedef struct program_key {
    char text[KEY_BYTES];
    char name[40]; /* of the file */
} program_key;

/* The contents of a file. */
typedef struct kernel_file {
    unsigned char *bytes;
    size_t size, key_bytes, binary_bytes;
} kernel_file;

static svo_status fail_errno(svo_device *device, const char *function, const char *path, const char *what)
{
    return svo_i_device_fail(device, SVO_FILE_ERROR, "%s: %s %s: %s", function, path, what, strerror(errno));
}

static svo_status no_memory(svo_device *device, const char *function)
{
    return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a program's binary", function);
}

static void hash_text(XXH128_hash_t hash, char text[SVO_I_HASH_BYTES])
{
    (void)snprintf(text, SVO_I_HASH_BYTES, "%016llx%016llx", (unsigned long long)hash.high64,
                   (unsigned long long)hash.low64);
}

/* Adds "name value" as a line. */
static void add_line(program_key *key, const char *name, const char *value)
{
    const size_t used = strlen(key->text);
    (void)snprintf(key->text + used, sizeof key->text - used, "%s %s\n", name, value);
}

/* The same for a text of any length, which a driver or the environment has. */
static void add_text(program_key *key, const char *name, const char *text)
{
    char hash[SVO_I_HASH_BYTES];
    hash_text(XXH3_128bits(text, strlen(text)), hash);
    add_line(key, name, strlen(text) < VALUE_BYTES ? text : hash);
}

static svo_status add_device_line(program_key *key, const char *function, const char *name, svo_device *device,
                                  cl_device_info what)
{
    char *text = NULL;
    SVO_I_TRY(svo_i_device_text(device->device, what, function, &device->memory, &text, &device->message));
    add_text(key, name, text);
    svo_i_free(text);
    return SVO_OK;
}

static svo_status add_platform_line(program_key *key, const char *function, const char *name, svo_device *device,
                                    cl_platform_info what)
{
    char *text = NULL;
    cl_platform_id platform = NULL;
    SVO_I_TRY(svo_i_device_property(device->device, CL_DEVICE_PLATFORM, sizeof(cl_platform_id), &platform, function,
                                    &device->message));
    SVO_I_TRY(svo_i_platform_text(platform, what, function, &device->memory, &text, &device->message));
    add_text(key, name, text);
    svo_i_free(text);
    return SVO_OK;
}

/* PoCL chooses instructions by these and names the device the same. */
static void add_environment(program_key *key)
{
    static const char *const names[] = {"POCL_KERNELLIB_NAME", "POCL_WORK_GROUP_METHOD"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        const char *value = getenv(names[i]);
        if (value != NULL) {
            add_text(key, names[i], value);
        }
    }
}

/* Which driver compiles for which device. */
static svo_status add_driver(program_key *key, const char *function, svo_device *device)
{
    cl_uint bits = 0;
    SVO_I_TRY(add_platform_line(key, function, "platform", device, CL_PLATFORM_NAME));
    SVO_I_TRY(add_platform_line(key, function, "platform-version", device, CL_PLATFORM_VERSION));
    SVO_I_TRY(add_device_line(key, function, "device", device, CL_DEVICE_NAME));
    SVO_I_TRY(add_device_line(key, function, "vendor", device, CL_DEVICE_VENDOR));
    SVO_I_TRY(add_device_line(key, function, "device-version", device, CL_DEVICE_VERSION));
    SVO_I_TRY(add_device_line(key, function, "driver", device, CL_DRIVER_VERSION));
    SVO_I_TRY(
        svo_i_device_property(device->device, CL_DEVICE_ADDRESS_BITS, sizeof bits, &bits, function, &device->message));
    add_line(key, "address-bits", bits == 64 ? "64" : "32");
    return SVO_OK;
}

static svo_status make_key(svo_device *device, const char *function, const svo_i_program_entry *entry, program_key *key)
{
    char options[SVO_I_PROGRAM_OPTIONS_BYTES];
    char hash[SVO_I_HASH_BYTES];
    key->text[0] = '\0';
    SVO_I_TRY(add_driver(key, function, device));
    add_environment(key);
    add_line(key, "source", entry->source);
    add_line(key, "program", entry->name);
    svo_i_program_options(device, entry->defines, options);
    add_line(key, "options", options);
    hash_text(XXH3_128bits(key->text, strlen(key->text)), hash);
    (void)snprintf(key->name, sizeof key->name, "%.24s" SUFFIX, hash);
    return SVO_OK;
}

/* "FOLDER/NAME" and up to 64 bytes more; the caller frees it. */
static char *path_of(const svo_device *device, const char *folder, const char *name)
{
    const size_t bytes = strlen(folder) + strlen(name) + 66;
    char *path = svo_i_alloc(&device->memory, bytes);
    if (path != NULL) {
        (void)snprintf(path, bytes, "%s/%s", folder, name);
    }
    return path;
}

static XXH128_canonical_t checksum(const unsigned char *bytes, size_t size)
{
    XXH128_canonical_t canonical;
    XXH3_state_t state;
    XXH3_128bits_reset(&state);
    XXH3_128bits_update(&state, bytes, HASHED_BYTES);
    XXH3_128bits_update(&state, bytes + HEAD_BYTES, size - HEAD_BYTES);
    XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(&state));
    return canonical;
}

/* Whether a file is whole. Sets the sizes of its parts. */
static bool is_whole(kernel_file *file)
{
    if (file->size < HEAD_BYTES || memcmp(file->bytes, MAGIC, sizeof MAGIC - 1) != 0) {
        return false;
    }
    uint64_t key_bytes = 0;
    uint64_t binary_bytes = 0;
    memcpy(&key_bytes, file->bytes + 8, sizeof key_bytes);
    memcpy(&binary_bytes, file->bytes + 16, sizeof binary_bytes);
    const size_t rest = file->size - HEAD_BYTES;
    if (key_bytes >= KEY_BYTES || key_bytes > rest || binary_bytes != rest - key_bytes) {
        return false;
    }
    file->key_bytes = (size_t)key_bytes;
    file->binary_bytes = (size_t)binary_bytes;
    const XXH128_canonical_t expected = checksum(file->bytes, file->size);
    return memcmp(file->bytes + HASHED_BYTES, &expected, sizeof expected) == 0;
}

/* Reads a regular file. False when it cannot be read, or is no file of kernels. The caller frees file->bytes. */
static bool read_file(const svo_device *device, const char *path, kernel_file *file)
{
    struct stat entry;
    *file = (kernel_file){0};
    const int descriptor = svo_i_system_open(path);
    if (descriptor < 0) {
        return false;
    }
    const bool is_usable = fstat(descriptor, &entry) == 0 && S_ISREG(entry.st_mode) && entry.st_size > 0 &&
                           (uint64_t)entry.st_size <= FILE_MAX;
    file->size = is_usable ? (size_t)entry.st_size : 0;
    file->bytes = is_usable ? svo_i_alloc(&device->memory, file->size) : NULL;
    const bool is_read = file->bytes != NULL && svo_i_system_read(descriptor, file->bytes, file->size);
    close(descriptor);
    return is_read && is_whole(file);
}

/* ---- saving ---- */

/* Writes a new file beside the path and renames it. */
static svo_status write_file(svo_device *device, const char *path, const kernel_file *file)
{
    svo_status status = SVO_OK;
    const size_t bytes = strlen(path) + 64;
    char *temporary = svo_i_alloc(&device->memory, bytes);
    int descriptor = -1;
    if (temporary == NULL) {
        return no_memory(device, SAVE);
    }
    errno = EEXIST;
    for (int i = 0; i < ATTEMPTS_MAX && descriptor < 0 && errno == EEXIST; ++i) {
        (void)snprintf(temporary, bytes, "%s.%ld.%d.tmp", path, (long)getpid(), i);
        descriptor = svo_i_system_make(temporary);
    }
    if (descriptor < 0) {
        status = fail_errno(device, SAVE, path, "cannot be written");
        goto cleanup;
    }
    const bool is_written = svo_i_system_write(descriptor, file->bytes, file->size);
    const bool is_closed = close(descriptor) == 0;
    if (!is_written || !is_closed || !svo_i_system_replace(temporary, path)) {
        status = fail_errno(device, SAVE, path, "cannot be written");
        (void)unlink(temporary);
    }
cleanup:
    svo_i_free(temporary);
    return status;
}

/* The index of the handle's device in the program, which may have been built for several. */
static svo_status find_binary(svo_device *device, cl_program program, cl_uint *count, cl_uint *index)
{
    cl_device_id devices[64] = {NULL};
    cl_int error = clGetProgramInfo(program, CL_PROGRAM_NUM_DEVICES, sizeof *count, count, NULL);
    if (error == CL_SUCCESS && *count > 64) {
        return svo_i_device_fail(device, SVO_UNSUPPORTED, SAVE ": the context has %u devices, above 64", *count);
    }
    if (error == CL_SUCCESS) {
        error = clGetProgramInfo(program, CL_PROGRAM_DEVICES, sizeof devices, devices, NULL);
    }
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(device, SAVE, "clGetProgramInfo", error);
    }
    *index = 0;
    /* PoCL lists the whole device where the handle has a part of it. */
    while (*count > 1 && *index < *count && devices[*index] != device->device) {
        ++*index;
    }
    return *index < *count
               ? SVO_OK
               : svo_i_device_fail(device, SVO_UNSUPPORTED, SAVE ": the driver lists no binary for %s", device->name);
}

/* Asks the driver for the binary, after a head and the key. The caller frees file->bytes. */
static svo_status get_binary(svo_device *device, cl_program program, const program_key *key, kernel_file *file)
{
    size_t sizes[64] = {0};
    unsigned char *binaries[64] = {NULL};
    cl_uint count = 0;
    cl_uint index = 0;
    SVO_I_TRY(find_binary(device, program, &count, &index));
    cl_int error = clGetProgramInfo(program, CL_PROGRAM_BINARY_SIZES, count * sizeof *sizes, sizes, NULL);
    if (error != CL_SUCCESS || sizes[index] == 0) {
        return svo_i_device_fail_cl(device, SAVE, "clGetProgramInfo(CL_PROGRAM_BINARY_SIZES)", error);
    }
    file->key_bytes = strlen(key->text);
    file->binary_bytes = sizes[index];
    file->size = HEAD_BYTES + file->key_bytes + file->binary_bytes;
    file->bytes = svo_i_alloc_zeroed(&device->memory, 1, file->size);
    if (file->bytes == NULL) {
        return no_memory(device, SAVE);
    }
    binaries[index] = file->bytes + HEAD_BYTES + file->key_bytes; /* NULL: not wanted */
    error = clGetProgramInfo(program, CL_PROGRAM_BINARIES, count * sizeof *binaries, (void *)binaries, NULL);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(device, SAVE, "clGetProgramInfo", error);
}

static void fill_head(const program_key *key, kernel_file *file)
{
    const uint64_t key_bytes = file->key_bytes;
    const uint64_t binary_bytes = file->binary_bytes;
    memcpy(file->bytes, MAGIC, sizeof MAGIC - 1);
    memcpy(file->bytes + 8, &key_bytes, sizeof key_bytes);
    memcpy(file->bytes + 16, &binary_bytes, sizeof binary_bytes);
    memcpy(file->bytes + HEAD_BYTES, key->text, file->key_bytes);
    const XXH128_canonical_t hash = checksum(file->bytes, file->size);
    memcpy(file->bytes + HASHED_BYTES, &hash, sizeof hash);
}

static bool has_key(const kernel_file *file, const program_key *key)
{
    return file->key_bytes == strlen(key->text) && memcmp(file->bytes + HEAD_BYTES, key->text, file->key_bytes) == 0;
}

/* Saves a program, unless the folder has it. */
static svo_status save_program(svo_device *device, const char *folder, const svo_i_program_entry *entry, size_t *saved)
{
    svo_status status = SVO_OK;
    program_key key;
    kernel_file file = {0};
    SVO_I_TRY(make_key(device, SAVE, entry, &key));
    char *path = path_of(device, folder, key.name);
    if (path == NULL) {
        return no_memory(device, SAVE);
    }
    if (!read_file(device, path, &file) || !has_key(&file, &key)) {
        svo_i_free(file.bytes);
        file = (kernel_file){0};
        SVO_I_TRY_CLEANUP(get_binary(device, entry->program, &key, &file));
        fill_head(&key, &file);
        SVO_I_TRY_CLEANUP(write_file(device, path, &file));
        ++*saved;
    }
cleanup:
    svo_i_free(file.bytes);
    svo_i_free(path);
    return status;
}

svo_status svo_device_save_kernels(svo_device *device, const char *folder, size_t *saved)
{
    size_t count = 0;
    if (device == NULL || folder == NULL || folder[0] == '\0') {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, SAVE ": %s",
                                 device == NULL ? "device is NULL" : "folder is NULL or empty");
    }
    if (!svo_i_system_make_folder(folder)) {
        return fail_errno(device, SAVE, folder, "cannot be made");
    }
    for (size_t i = 0; svo_i_program_at(device, i) != NULL; ++i) {
        SVO_I_TRY(save_program(device, folder, svo_i_program_at(device, i), &count));
    }
    if (saved != NULL) {
        *saved = count;
    }
    return SVO_OK;
}

/* ---- loading ---- */

/* The value of the key's line of that name; false without one. */
static bool find_line(const kernel_file *file, const char *name, char *value, size_t value_bytes)
{
    const char *line = (const char *)file->bytes + HEAD_BYTES;
    const char *end = line + file->key_bytes;
    const size_t name_bytes = strlen(name);
    while (line < end) {
        const char *newline = memchr(line, '\n', (size_t)(end - line));
        const size_t length = (size_t)((newline != NULL ? newline : end) - line);
        if (length > name_bytes && memcmp(line, name, name_bytes) == 0 && line[name_bytes] == ' ') {
            const size_t taken = length - name_bytes - 1;
            if (taken >= value_bytes) {
                return false;
            }
            memcpy(value, line + name_bytes + 1, taken);
            value[taken] = '\0';
            return true;
        }
        line += length + 1;
    }
    return false;
}

/* The program that the key names, without its binary; false where its options are not the library's. */
static bool read_entry(const svo_device *device, const kernel_file *file, svo_i_program_entry *entry)
{
    char options[SVO_I_PROGRAM_OPTIONS_BYTES];
    char plain[SVO_I_PROGRAM_OPTIONS_BYTES];
    *entry = (svo_i_program_entry){.program = NULL};
    svo_i_program_options(device, "", plain);
    if (!find_line(file, "program", entry->name, sizeof entry->name) ||
        !find_line(file, "source", entry->source, sizeof entry->source) ||
        !find_line(file, "options", options, sizeof options) || strncmp(options, plain, strlen(plain)) != 0 ||
        strlen(options + strlen(plain)) >= sizeof entry->defines) {
        return false;
    }
    (void)snprintf(entry->defines, sizeof entry->defines, "%.*s", SVO_I_PROGRAM_DEFINES_BYTES - 1,
                   options + strlen(plain));
    return true;
}

static void warn(const svo_device *device, const char *path, const char *why)
{
    char text[SVO_MESSAGE_BYTES];
    (void)snprintf(text, sizeof text, LOAD ": %s %s; its kernels are compiled when they are needed", path, why);
    svo_i_device_log(device, SVO_LOG_WARNING, text);
}

/* The program of a binary; NULL when the driver does not take it. */
static cl_program program_of(const svo_device *device, const kernel_file *file, const char *defines)
{
    const unsigned char *binary = file->bytes + HEAD_BYTES + file->key_bytes;
    const size_t size = file->binary_bytes;
    cl_int error = CL_SUCCESS;
    char options[SVO_I_PROGRAM_OPTIONS_BYTES];
    svo_i_program_options(device, defines, options);
    cl_program program = clCreateProgramWithBinary(device->context, 1, &device->device, &size, &binary, NULL, &error);
    if (error != CL_SUCCESS) {
        return NULL;
    }
    if (clBuildProgram(program, 1, &device->device, options, NULL, NULL) != CL_SUCCESS) {
        clReleaseProgram(program);
        return NULL;
    }
    return program;
}

static bool has_program(const svo_device *device, const svo_i_program_entry *entry)
{
    const svo_i_program_entry *at = svo_i_program_at(device, 0);
    for (size_t i = 1; at != NULL; ++i) {
        if (strcmp(at->name, entry->name) == 0 && strcmp(at->source, entry->source) == 0 &&
            strcmp(at->defines, entry->defines) == 0) {
            return true;
        }
        at = svo_i_program_at(device, i);
    }
    return false;
}

/* Loads a file that is whole, unless it is of another device or driver, or the handle has its program. The key has the
   hash of the source; whether it is that of this library shows when a room asks for the program. */
static svo_status load_program(svo_device *device, const char *path, const kernel_file *file, size_t *loaded)
{
    program_key key;
    svo_i_program_entry entry;
    if (!read_entry(device, file, &entry)) {
        return SVO_OK;
    }
    SVO_I_TRY(make_key(device, LOAD, &entry, &key));
    if (!has_key(file, &key) || has_program(device, &entry)) {
        return SVO_OK;
    }
    entry.program = program_of(device, file, entry.defines);
    if (entry.program == NULL) {
        warn(device, path, "is refused by the driver");
        return SVO_OK;
    }
    const svo_status status = svo_i_program_add(device, LOAD, &entry);
    if (status != SVO_OK) {
        clReleaseProgram(entry.program);
        return status;
    }
    ++*loaded;
    return SVO_OK;
}

static svo_status load_file(svo_device *device, const char *folder, const char *name, size_t *loaded)
{
    svo_status status = SVO_OK;
    kernel_file file;
    const size_t length = strlen(name);
    if (length <= strlen(SUFFIX) || strcmp(name + length - strlen(SUFFIX), SUFFIX) != 0) {
        return SVO_OK;
    }
    char *path = path_of(device, folder, name);
    if (path == NULL) {
        return no_memory(device, LOAD);
    }
    if (read_file(device, path, &file)) {
        status = load_program(device, path, &file, loaded);
    } else {
        warn(device, path, "is damaged or cannot be read");
    }
    svo_i_free(file.bytes);
    svo_i_free(path);
    return status;
}

static svo_status load_files(svo_device *device, const char *folder, DIR *entries, size_t *loaded)
{
    for (;;) {
        errno = 0;
        const struct dirent *entry = readdir(entries);
        if (entry == NULL) {
            return errno == 0 ? SVO_OK : fail_errno(device, LOAD, folder, "cannot be read");
        }
        SVO_I_TRY(load_file(device, folder, entry->d_name, loaded));
    }
}

svo_status svo_device_load_kernels(svo_device *device, const char *folder, size_t *loaded)
{
    size_t count = 0;
    if (device == NULL || folder == NULL || folder[0] == '\0') {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, LOAD ": %s",
                                 device == NULL ? "device is NULL" : "folder is NULL or empty");
    }
    const double start_ms = svo_i_now_ms();
    DIR *entries = opendir(folder);
    if (entries == NULL && errno != ENOENT) {
        return fail_errno(device, LOAD, folder, "cannot be read");
    }
    const svo_status status = entries != NULL ? load_files(device, folder, entries, &count) : SVO_OK;
    if (entries != NULL) {
        closedir(entries);
    }
    device->compile_ms += svo_i_now_ms() - start_ms;
    SVO_I_TRY(status);
    if (loaded != NULL) {
        *loaded = count;
    }
    return SVO_OK;
}
