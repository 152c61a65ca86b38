/* SPDX-License-Identifier: MIT */
/* What all parts of the .vox reader use: messages with a place, growing lists, numbers. */
#include "io/voxels_vox_file.h"

#include <string.h>

svo_status svo_i_vox_damaged(const vox_cursor *cursor, const char *format, ...)
{
    svo_message detail;
    va_list arguments;
    va_start(arguments, format);
    svo_i_fail_v(&detail, SVO_FILE_DAMAGED, format, arguments);
    va_end(arguments);
    return svo_i_voxels_damaged(cursor->reader, "chunk %s at byte %zu: %s, at byte %zu", cursor->id, cursor->offset,
                                detail.text, (size_t)(cursor->at - cursor->reader->bytes));
}

svo_status svo_i_vox_grow(const voxel_reader *reader, void **list, size_t count, size_t *capacity, size_t element_bytes)
{
    if (count < *capacity) {
        return SVO_OK;
    }
    const size_t larger = 2 * *capacity + 16;
    void *grown = svo_i_grow(&reader->memory, *list, larger * element_bytes);
    if (grown == NULL) {
        return svo_i_voxels_fail(reader, SVO_OUT_OF_HOST_MEMORY, "no memory for %zu parts of the scene", larger);
    }
    *list = grown;
    *capacity = larger;
    return SVO_OK;
}

int32_t svo_i_vox_i32_at(const uint8_t *bytes)
{
    int32_t value = 0;
    memcpy(&value, bytes, sizeof value);
    return value;
}

svo_status svo_i_vox_read_i32(vox_cursor *cursor, const char *what, int32_t *out)
{
    if (cursor->end - cursor->at < 4) {
        return svo_i_vox_damaged(cursor, "%s ends beyond its chunk", what);
    }
    *out = svo_i_vox_i32_at(cursor->at);
    cursor->at += 4;
    return SVO_OK;
}
