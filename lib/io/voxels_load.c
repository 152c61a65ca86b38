/* SPDX-License-Identifier: MIT */
/* Voxel files to lists of voxels: reads the file into memory, and finds its reader by its first bytes. */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/memory.h"
#include "core/struct_size.h"
#include "io/voxels_formats.h"

static const char *const names[] = {"auto", "vox", "svx", "binvox", "ply", "obj"};

const char *svo_voxel_format_name(svo_voxel_format format)
{
    return (unsigned)format <= SVO_VOXEL_FORMAT_OBJ ? names[format] : "unknown format";
}

svo_voxel_format svo_voxel_format_of_path(const char *path)
{
    const char *dot = path != NULL ? strrchr(path, '.') : NULL;
    for (int format = SVO_VOXEL_FORMAT_VOX; format <= SVO_VOXEL_FORMAT_OBJ && dot != NULL; ++format) {
        if (strcasecmp(dot + 1, names[format]) == 0) {
            return (svo_voxel_format)format;
        }
    }
    return SVO_VOXEL_FORMAT_AUTO;
}

static bool begins(const voxel_reader *reader, const char *magic)
{
    const size_t bytes = strlen(magic);
    return reader->byte_count >= bytes && memcmp(reader->bytes, magic, bytes) == 0;
}

static svo_status read_format(voxel_reader *reader)
{
    reader->info = (svo_voxel_file_info){.struct_size = sizeof reader->info, .models = 1, .instances = 1};
    if (begins(reader, "VOX ")) {
        reader->info.format = SVO_VOXEL_FORMAT_VOX;
        return svo_i_voxels_read_vox(reader);
    }
    if (begins(reader, "#binvox")) {
        reader->info.format = SVO_VOXEL_FORMAT_BINVOX;
        return svo_i_voxels_read_binvox(reader);
    }
    if (begins(reader, "PK\3\4")) {
        reader->info.format = SVO_VOXEL_FORMAT_SVX;
        return svo_i_voxels_read_svx(reader);
    }
    return svo_i_voxels_damaged(reader, "byte 0: neither a .vox nor a .svx nor a .binvox file");
}

bool svo_i_voxels_are_turned(svo_axes axes, svo_voxel_format format)
{
    return axes == SVO_AXES_Z_UP || (axes == SVO_AXES_AUTO && format == SVO_VOXEL_FORMAT_VOX);
}

/* From z up to y up. */
static void turn(voxel_reader *reader)
{
    for (uint64_t i = 0; i < reader->voxel_count; ++i) {
        svo_voxel *voxel = &reader->voxels[i];
        const int32_t y = voxel->y;
        voxel->y = voxel->z;
        voxel->z = -1 - y;
    }
    const double y = reader->origin[1];
    reader->origin[1] = reader->origin[2];
    reader->origin[2] = -y;
}

/* Makes the list of what was read. */
static svo_status make_list(voxel_reader *reader, svo_voxels **out)
{
    svo_voxels_source source = {.struct_size = sizeof source,
                                .voxels = reader->voxels,
                                .voxel_count = reader->voxel_count,
                                .property_count = reader->property_count,
                                .voxel_edge = reader->voxel_edge,
                                .memory = reader->options.memory};
    memcpy(source.origin, reader->origin, sizeof source.origin);
    svo_voxel_property *properties = svo_i_alloc(&reader->memory, (reader->property_count + 1) * sizeof *properties);
    if (properties == NULL) {
        return svo_i_voxels_fail(reader, SVO_OUT_OF_HOST_MEMORY, "no memory for %zu properties",
                                 reader->property_count);
    }
    for (size_t i = 0; i < reader->property_count; ++i) {
        const voxel_property *one = &reader->properties[i];
        properties[i] = (svo_voxel_property){
            .material = one->material, .key = reader->texts + one->key, .value = reader->texts + one->value};
    }
    source.properties = properties;
    const svo_status status = svo_voxels_create(&source, out, reader->message);
    if (status != SVO_OK) {
        svo_i_message_rename(reader->message, reader->name);
    }
    svo_i_free(properties);
    return status;
}

static svo_status load(voxel_reader *reader, svo_voxels **out, svo_voxel_file_info *info)
{
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(read_format(reader));
    const svo_axes axes = (svo_axes)reader->options.axes;
    if (svo_i_voxels_are_turned(axes, (svo_voxel_format)reader->info.format)) {
        turn(reader);
    }
    SVO_I_TRY_CLEANUP(make_list(reader, out));
    (void)svo_voxels_set_axes(*out, axes);
    if (info != NULL) {
        (void)svo_i_struct_write(NULL, "", "info", &reader->info, info,
                                 SVO_I_STRUCT_SIZES(svo_voxel_file_info, warnings));
    }
cleanup:
    svo_i_free(reader->voxels);
    svo_i_free(reader->properties);
    svo_i_free(reader->texts);
    return status;
}

/* Checks what both functions take and prepares the reader. */
static svo_status start(const char *function, const svo_voxels_load_options *options, const svo_voxel_file_info *info,
                        voxel_reader *reader)
{
    SVO_I_TRY(svo_i_struct_read(reader->message, function, "options", options, &reader->options,
                                SVO_I_STRUCT_SIZES(svo_voxels_load_options, log_user)));
    SVO_I_TRY(svo_i_memory_read(reader->message, function, "options.memory", reader->options.memory, &reader->memory));
    if (reader->options.axes > SVO_AXES_Z_UP) {
        return svo_i_fail(reader->message, SVO_INVALID_ARGUMENT, "%s: options.axes %u is not in 0 .. %d", function,
                          reader->options.axes, SVO_AXES_Z_UP);
    }
    const uint64_t most = SVO_VOXELS_MAX;
    reader->limit_is_default = reader->options.voxels_max == 0;
    if (reader->limit_is_default) {
        reader->options.voxels_max = svo_i_host_memory_bytes() / BUILT_VOXEL_BYTES;
    }
    if (reader->options.voxels_max > most) {
        reader->options.voxels_max = most;
    }
    return info == NULL ? SVO_OK
                        : svo_i_struct_check(reader->message, function, "info", info,
                                             SVO_I_STRUCT_SIZES(svo_voxel_file_info, warnings));
}

svo_status svo_voxels_load_memory(const void *bytes, size_t byte_count, const char *name,
                                  const svo_voxels_load_options *options, svo_voxels **out, svo_voxel_file_info *info,
                                  svo_message *message)
{
    if (bytes == NULL || name == NULL || out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_voxels_load_memory: %s is NULL",
                          bytes == NULL ? "bytes" : (name == NULL ? "name" : "out"));
    }
    voxel_reader reader = {.name = name, .bytes = bytes, .byte_count = byte_count, .message = message};
    SVO_I_TRY(start("svo_voxels_load_memory", options, info, &reader));
    return load(&reader, out, info);
}

/* Reads a regular file, of the length that it had when it was opened. */
static svo_status read_file(const voxel_reader *reader, int file, uint8_t **bytes, size_t *byte_count)
{
    const char *path = reader->name;
    svo_message *message = reader->message;
    struct stat entry;
    if (fstat(file, &entry) != 0) {
        return svo_i_fail(message, SVO_FILE_ERROR, "%s: cannot be read: %s", path, strerror(errno));
    }
    if (!S_ISREG(entry.st_mode)) {
        return svo_i_fail(message, SVO_FILE_ERROR, "%s: cannot be read: %s", path,
                          S_ISDIR(entry.st_mode) ? strerror(EISDIR) : "not a regular file");
    }
    const size_t whole = (size_t)entry.st_size;
    *bytes = svo_i_alloc(&reader->memory, whole + 1);
    if (*bytes == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for its %zu bytes", path, whole);
    }
    *byte_count = 0;
    while (*byte_count < whole) {
        const ssize_t got = read(file, *bytes + *byte_count, whole - *byte_count);
        if (got < 0 && errno == EINTR) {
            continue;
        }
        if (got < 0) {
            return svo_i_fail(message, SVO_FILE_ERROR, "%s: cannot be read: %s", path, strerror(errno));
        }
        if (got == 0) {
            return SVO_OK; /* it became shorter; the reader sees what is missing */
        }
        *byte_count += (size_t)got;
    }
    return SVO_OK;
}

svo_status svo_voxels_load(const char *path, const svo_voxels_load_options *options, svo_voxels **out,
                           svo_voxel_file_info *info, svo_message *message)
{
    if (path == NULL || out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_voxels_load: %s is NULL", path == NULL ? "path" : "out");
    }
    voxel_reader reader = {.name = path, .message = message};
    SVO_I_TRY(start("svo_voxels_load", options, info, &reader));
    /* Non-blocking: opening a named pipe must fail below, not wait for a writer. */
    const int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0) {
        return svo_i_fail(message, SVO_FILE_ERROR, "%s: cannot be read: %s", path, strerror(errno));
    }
    uint8_t *bytes = NULL;
    svo_status status = read_file(&reader, file, &bytes, &reader.byte_count);
    close(file);
    if (status == SVO_OK) {
        reader.bytes = bytes;
        status = load(&reader, out, info);
    }
    svo_i_free(bytes);
    return status;
}
