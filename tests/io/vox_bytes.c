/* SPDX-License-Identifier: MIT */
/* Writes .vox files byte by byte, for tests. */
#include "vox_bytes.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void bytes_put(byte_list *list, const void *bytes, size_t count)
{
    if (list->count + count > list->capacity) {
        list->capacity = 2 * (list->count + count);
        uint8_t *larger = realloc(list->bytes, list->capacity);
        if (larger == NULL) {
            abort();
        }
        list->bytes = larger;
    }
    if (count > 0) {
        memcpy(list->bytes + list->count, bytes, count);
    }
    list->count += count;
}

void bytes_put_u8(byte_list *list, uint8_t value)
{
    bytes_put(list, &value, 1);
}

void bytes_put_i32(byte_list *list, int32_t value)
{
    const uint32_t word = (uint32_t)value;
    for (unsigned shift = 0; shift < 32; shift += 8) {
        bytes_put_u8(list, (uint8_t)(word >> shift));
    }
}

void bytes_put_text(byte_list *list, const char *text)
{
    bytes_put(list, text, strlen(text));
}

void bytes_free(byte_list *list)
{
    free(list->bytes);
    *list = (byte_list){0};
}

void vox_put_dict(byte_list *list, const char *const *pairs)
{
    int32_t count = 0;
    while (pairs[2 * count] != NULL) {
        ++count;
    }
    bytes_put_i32(list, count);
    for (int32_t i = 0; i < 2 * count; ++i) {
        bytes_put_i32(list, (int32_t)strlen(pairs[i]));
        bytes_put_text(list, pairs[i]);
    }
}

void vox_put_chunk(byte_list *list, const char *id, byte_list *content)
{
    bytes_put_text(list, id);
    bytes_put_i32(list, (int32_t)content->count);
    bytes_put_i32(list, 0);
    bytes_put(list, content->bytes, content->count);
    bytes_free(content);
}

void vox_put_model(byte_list *list, const int32_t size[3], const uint8_t *voxels, size_t count)
{
    byte_list content = {0};
    for (int axis = 0; axis < 3; ++axis) {
        bytes_put_i32(&content, size[axis]);
    }
    vox_put_chunk(list, "SIZE", &content);
    bytes_put_i32(&content, (int32_t)count);
    bytes_put(&content, voxels, 4 * count);
    vox_put_chunk(list, "XYZI", &content);
}

void vox_put_transform(byte_list *list, int32_t id, int32_t child, int32_t layer, int rotation,
                       const int32_t *translation)
{
    static const char *const none[] = {NULL};
    const char *pairs[5] = {NULL};
    char rotation_text[16];
    char translation_text[64];
    size_t used = 0;
    byte_list content = {0};
    bytes_put_i32(&content, id);
    vox_put_dict(&content, none);
    bytes_put_i32(&content, child);
    bytes_put_i32(&content, -1);
    bytes_put_i32(&content, layer);
    bytes_put_i32(&content, 1);
    if (rotation >= 0) {
        (void)snprintf(rotation_text, sizeof rotation_text, "%d", rotation);
        pairs[used++] = "_r";
        pairs[used++] = rotation_text;
    }
    if (translation != NULL) {
        (void)snprintf(translation_text, sizeof translation_text, "%" PRId32 " %" PRId32 " %" PRId32, translation[0],
                       translation[1], translation[2]);
        pairs[used++] = "_t";
        pairs[used++] = translation_text;
    }
    vox_put_dict(&content, pairs);
    vox_put_chunk(list, "nTRN", &content);
}

void vox_put_group(byte_list *list, int32_t id, const int32_t *children, size_t count)
{
    static const char *const none[] = {NULL};
    byte_list content = {0};
    bytes_put_i32(&content, id);
    vox_put_dict(&content, none);
    bytes_put_i32(&content, (int32_t)count);
    for (size_t i = 0; i < count; ++i) {
        bytes_put_i32(&content, children[i]);
    }
    vox_put_chunk(list, "nGRP", &content);
}

void vox_put_shape(byte_list *list, int32_t id, int32_t model)
{
    static const char *const none[] = {NULL};
    byte_list content = {0};
    bytes_put_i32(&content, id);
    vox_put_dict(&content, none);
    bytes_put_i32(&content, 1);
    bytes_put_i32(&content, model);
    vox_put_dict(&content, none);
    vox_put_chunk(list, "nSHP", &content);
}

byte_list vox_file(int32_t version, byte_list *chunks)
{
    byte_list file = {0};
    bytes_put_text(&file, "VOX ");
    bytes_put_i32(&file, version);
    bytes_put_text(&file, "MAIN");
    bytes_put_i32(&file, 0);
    bytes_put_i32(&file, (int32_t)chunks->count);
    bytes_put(&file, chunks->bytes, chunks->count);
    bytes_free(chunks);
    return file;
}
