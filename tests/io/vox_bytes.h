/* SPDX-License-Identifier: MIT */
/* Writes .vox files byte by byte, for tests. */
#ifndef SVOCL_TESTS_VOX_BYTES_H
#define SVOCL_TESTS_VOX_BYTES_H

#include <stddef.h>
#include <stdint.h>

/* Bytes that grow. All zero: none. */
typedef struct byte_list {
    uint8_t *bytes; /* by malloc */
    size_t count, capacity;
} byte_list;

void bytes_put(byte_list *list, const void *bytes, size_t count);
void bytes_put_u8(byte_list *list, uint8_t value);
void bytes_put_i32(byte_list *list, int32_t value);
void bytes_put_text(byte_list *list, const char *text); /* without a terminator */
void bytes_free(byte_list *list);

/* A dictionary from "key", "value", ..., NULL. */
void vox_put_dict(byte_list *list, const char *const *pairs);
/* A chunk without children; what is content becomes empty. */
void vox_put_chunk(byte_list *list, const char *id, byte_list *content);

/* SIZE and XYZI; voxels: count times x, y, z, index. */
void vox_put_model(byte_list *list, const int32_t size[3], const uint8_t *voxels, size_t count);
/* A transform of one frame. rotation below 0, translation NULL: none. */
void vox_put_transform(byte_list *list, int32_t id, int32_t child, int32_t layer, int rotation,
                       const int32_t *translation);
void vox_put_group(byte_list *list, int32_t id, const int32_t *children, size_t count);
void vox_put_shape(byte_list *list, int32_t id, int32_t model);

/* The file of chunks, which become empty. */
byte_list vox_file(int32_t version, byte_list *chunks);

#endif
