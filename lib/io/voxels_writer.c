/* SPDX-License-Identifier: MIT */
/* The buffer before the callback, messages, and voxels in other orders, for the writers of voxel files. */
#include "io/voxels_writer.h"

#include <stdio.h>
#include <string.h>

svo_status svo_i_voxels_write_fail(const voxel_writer *writer, svo_status status, const char *format, ...)
{
    svo_message detail;
    va_list arguments;
    va_start(arguments, format);
    svo_i_fail_v(&detail, status, format, arguments);
    va_end(arguments);
    return svo_i_fail(writer->message, status, "%s: %s", writer->name, detail.text);
}

svo_status svo_i_voxels_flush(voxel_writer *writer)
{
    const size_t byte_count = writer->used;
    writer->used = 0;
    if (byte_count > 0 && writer->write(writer->user, writer->buffer, byte_count) != 0) {
        return svo_i_voxels_write_fail(writer, SVO_FILE_ERROR, "%zu bytes before byte %llu could not be written",
                                       byte_count, (unsigned long long)writer->info.bytes);
    }
    return SVO_OK;
}

svo_status svo_i_voxels_put(voxel_writer *writer, const void *bytes, size_t byte_count)
{
    const uint8_t *from = bytes;
    writer->info.bytes += byte_count;
    while (byte_count > 0) {
        const size_t room = VOXEL_BUFFER_BYTES - writer->used;
        const size_t part = byte_count < room ? byte_count : room;
        memcpy(writer->buffer + writer->used, from, part);
        writer->used += part;
        from += part;
        byte_count -= part;
        if (writer->used == VOXEL_BUFFER_BYTES) {
            SVO_I_TRY(svo_i_voxels_flush(writer));
        }
    }
    return SVO_OK;
}

svo_status svo_i_voxels_print(voxel_writer *writer, const char *format, ...)
{
    svo_message line;
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(line.text, sizeof line.text, format, arguments);
    va_end(arguments);
    return svo_i_voxels_put(writer, line.text, (size_t)length);
}

svo_status svo_i_voxels_sorted(const voxel_writer *writer, svo_i_voxel_order order, svo_voxel **out)
{
    const size_t count = (size_t)writer->list.voxel_count;
    svo_voxel *sorted = svo_i_alloc(writer->memory, count * sizeof *sorted + 1);
    svo_voxel *spare = svo_i_alloc(writer->memory, count * sizeof *spare + 1);
    if (sorted == NULL || spare == NULL) {
        svo_i_free(sorted);
        svo_i_free(spare);
        return svo_i_voxels_write_fail(writer, SVO_OUT_OF_HOST_MEMORY, "no memory to sort %zu voxels", count);
    }
    if (count > 0) {
        memcpy(sorted, writer->voxels, count * sizeof *sorted);
        svo_i_voxel_sort(sorted, spare, count, writer->list.low, svo_i_voxel_bits(writer->list.low, writer->list.high),
                         order);
    }
    svo_i_free(spare);
    *out = sorted;
    return SVO_OK;
}

double svo_i_voxels_world(const voxel_writer *writer, int axis, double place)
{
    return writer->list.origin[axis] + place * writer->list.voxel_edge;
}
