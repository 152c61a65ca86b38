/* SPDX-License-Identifier: MIT */
/* Lists of voxels to files: through the caller's function, or whole or not at all through lib/output. */
#define _POSIX_C_SOURCE 200809L
#include <string.h>

#include "core/struct_size.h"
#include "core/voxel_list.h"
#include "io/voxels_formats.h"
#include "output/output.h"

static svo_status write_format(voxel_writer *writer, svo_voxel_format format)
{
    switch (format) {
    case SVO_VOXEL_FORMAT_VOX:
        return svo_i_voxels_write_vox(writer);
    case SVO_VOXEL_FORMAT_SVX:
        return svo_i_voxels_write_svx(writer);
    case SVO_VOXEL_FORMAT_BINVOX:
        return svo_i_voxels_write_binvox(writer);
    case SVO_VOXEL_FORMAT_PLY:
        return svo_i_voxels_write_ply(writer);
    default:
        return svo_i_voxels_write_obj(writer);
    }
}

/* Makes a list with z up of one with y up. */
static svo_status turn(const voxel_writer *writer, svo_voxels **out)
{
    const svo_memory_callbacks memory = {.struct_size = sizeof memory,
                                         .allocate = writer->memory->allocate,
                                         .release = writer->memory->release,
                                         .user = writer->memory->user};
    svo_voxels_source source = {.struct_size = sizeof source,
                                .voxel_count = writer->list.voxel_count,
                                .properties = writer->properties,
                                .property_count = (size_t)writer->list.property_count,
                                .origin = {writer->list.origin[0], -writer->list.origin[2], writer->list.origin[1]},
                                .voxel_edge = writer->list.voxel_edge,
                                .memory = memory.allocate != NULL ? &memory : NULL};
    svo_voxel *turned = svo_i_alloc(writer->memory, (size_t)source.voxel_count * sizeof *turned + 1);
    if (turned == NULL) {
        return svo_i_voxels_write_fail(writer, SVO_OUT_OF_HOST_MEMORY, "no memory for %llu voxels",
                                       (unsigned long long)source.voxel_count);
    }
    for (uint64_t i = 0; i < source.voxel_count; ++i) {
        turned[i] = writer->voxels[i];
        turned[i].y = -1 - writer->voxels[i].z;
        turned[i].z = writer->voxels[i].y;
    }
    source.voxels = turned;
    const svo_status status = svo_voxels_create(&source, out, writer->message);
    if (status != SVO_OK) {
        svo_i_message_rename(writer->message, writer->name);
    }
    svo_i_free(turned);
    return status;
}

static svo_status take_list(voxel_writer *writer, const svo_voxels *voxels)
{
    writer->voxels = svo_voxels_get(voxels);
    writer->properties = svo_voxels_get_properties(voxels);
    writer->list = (svo_voxels_info)SVO_VOXELS_INFO_INIT;
    return svo_voxels_get_info(voxels, &writer->list);
}

/* Writes a list whose format is known; then fills info, which may be NULL. */
static svo_status write_list(voxel_writer *writer, const svo_voxels *voxels, svo_voxel_format format,
                             svo_voxels_save_info *info)
{
    svo_status status = SVO_OK;
    svo_voxels *turned = NULL;
    writer->memory = &voxels->memory;
    SVO_I_TRY(take_list(writer, voxels));
    if (svo_i_voxels_are_turned(voxels->axes, format)) {
        SVO_I_TRY(turn(writer, &turned));
        (void)take_list(writer, turned);
    }
    writer->info = (svo_voxels_save_info){.struct_size = sizeof writer->info, .format = format, .models = 1};
    writer->buffer = svo_i_alloc(writer->memory, VOXEL_BUFFER_BYTES);
    if (writer->buffer == NULL) {
        SVO_I_TRY_CLEANUP(svo_i_voxels_write_fail(writer, SVO_OUT_OF_HOST_MEMORY, "no memory for a buffer"));
    }
    SVO_I_TRY_CLEANUP(write_format(writer, format));
    SVO_I_TRY_CLEANUP(svo_i_voxels_flush(writer));
    if (info != NULL) {
        (void)svo_i_struct_write(NULL, "", "info", &writer->info, info,
                                 SVO_I_STRUCT_SIZES(svo_voxels_save_info, bytes));
    }
cleanup:
    svo_i_free(writer->buffer);
    svo_voxels_destroy(&turned);
    return status;
}

static svo_status check_info(const char *function, const svo_voxels_save_info *info, svo_message *message)
{
    return info == NULL
               ? SVO_OK
               : svo_i_struct_check(message, function, "info", info, SVO_I_STRUCT_SIZES(svo_voxels_save_info, bytes));
}

svo_status svo_voxels_write(const svo_voxels *voxels, svo_voxel_format format, svo_voxels_write_callback write,
                            void *user, svo_voxels_save_info *info, svo_message *message)
{
    static const char function[] = "svo_voxels_write";
    if (voxels == NULL || write == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                          voxels == NULL ? "voxels" : "write");
    }
    if ((unsigned)format < SVO_VOXEL_FORMAT_VOX || (unsigned)format > SVO_VOXEL_FORMAT_OBJ) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: format %d is not in %d .. %d", function, (int)format,
                          SVO_VOXEL_FORMAT_VOX, SVO_VOXEL_FORMAT_OBJ);
    }
    SVO_I_TRY(check_info(function, info, message));
    voxel_writer writer = {.name = function, .message = message, .write = write, .user = user};
    return write_list(&writer, voxels, format, info);
}

/* An output and the first error of writing to it. */
typedef struct sink {
    svo_i_output output;
    int error;
} sink;

static int write_to_sink(void *user, const void *bytes, size_t byte_count)
{
    sink *to = user;
    to->error = svo_i_output_write(&to->output, bytes, byte_count);
    return to->error;
}

svo_status svo_voxels_save(const svo_voxels *voxels, const char *path, svo_voxel_format format,
                           svo_voxels_save_info *info, svo_message *message)
{
    static const char function[] = "svo_voxels_save";
    if (voxels == NULL || path == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                          voxels == NULL ? "voxels" : "path");
    }
    if (format == SVO_VOXEL_FORMAT_AUTO) {
        format = svo_voxel_format_of_path(path);
    }
    if ((unsigned)format < SVO_VOXEL_FORMAT_VOX || (unsigned)format > SVO_VOXEL_FORMAT_OBJ) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT,
                          "%s: the suffix of '%s' is not vox, svx, binvox, ply or obj, and format is %d", function,
                          path, (int)format);
    }
    SVO_I_TRY(check_info(function, info, message));
    sink to = {.output = {.descriptor = -1}};
    voxel_writer writer = {.name = path, .message = message, .write = write_to_sink, .user = &to};
    to.error = svo_i_output_open(path, NULL, &to.output);
    svo_status status = to.error == 0 ? write_list(&writer, voxels, format, info) : SVO_FILE_ERROR;
    if (status == SVO_OK) {
        to.error = svo_i_output_commit(&to.output);
    }
    svo_i_output_abandon(&to.output);
    return to.error != 0 ? svo_i_fail(message, SVO_FILE_ERROR, "%s: cannot be written: %s", path, strerror(to.error))
                         : status;
}
