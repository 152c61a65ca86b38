/* SPDX-License-Identifier: MIT */
/*
 * What the readers of mesh files share, in the import child. The library's own read the whole file or fail with its
 * line or byte, the value and the limit. What they leave out on purpose is a warning.
 */
#ifndef SVO_LIB_IO_IMPORT_READER_H
#define SVO_LIB_IO_IMPORT_READER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "io/import_gather.h"
#include "io/import_stream.h"
#include "io/import_text.h"
#include "svocl/io.h"

/* ---- memory of the child ---- */

/* An array that grows. Elements of one size, which each call names. All zero: empty. free(items) releases it. */
typedef struct item_list {
    void *items;
    size_t count, capacity;
} item_list;

/* A new last element, not initialized; NULL when memory runs out. */
static inline void *list_add(item_list *list, size_t element_bytes)
{
    if (list->count == list->capacity) {
        const size_t capacity = list->capacity == 0 ? 256 : 2 * list->capacity;
        void *items = capacity <= SIZE_MAX / element_bytes ? realloc(list->items, capacity * element_bytes) : NULL;
        if (items == NULL) {
            return NULL;
        }
        list->items = items;
        list->capacity = capacity;
    }
    return (char *)list->items + list->count++ * element_bytes;
}

/* A copy up to a zero or the given length, for free. Unlike strndup it looks at no byte beyond, as sanitizers may. */
static inline char *text_copy(const char *text, size_t length)
{
    const char *zero = length > 0 ? memchr(text, '\0', length) : NULL;
    const size_t kept = zero != NULL ? (size_t)(zero - text) : length;
    char *copy = malloc(kept + 1);
    if (copy != NULL) {
        memcpy(copy, text, kept);
        copy[kept] = '\0';
    }
    return copy;
}

/* ---- files, mapped for reading ---- */

typedef struct file_bytes {
    const char *bytes; /* not NULL */
    size_t byte_count;
} file_bytes;

/* Returns NULL, or why the file cannot be read: a static string. */
const char *svo_i_file_open(const char *path, file_bytes *file);
/* A file whose name is relative to the folder of another one, with either system's separators. */
const char *svo_i_file_open_beside(const char *path, const char *name, file_bytes *file);
void svo_i_file_close(file_bytes *file);

/* Tells the parent at the other end of stream that such a file is read. Returns -1 when memory runs out or the parent
   is gone. */
int svo_i_file_tell_beside(int stream, const char *path, const char *name);

/* ---- reading ---- */

typedef struct mesh_reader {
    const char *path; /* whose folder material libraries and textures are relative to; NULL: none are read */
    const char *bytes; /* the whole file */
    size_t byte_count;
    int stream; /* receives textures and warnings */
    stream_work *work; /* announced to it; NULL: no memory is limited */
    gather *mesh; /* receives the mesh */
    bool normal_maps; /* are read */
    stream_counts *counts; /* receives what the file declares and what was read */
    svo_message *message;
} mesh_reader;

/* Parts of messages that all readers use. */
svo_status svo_i_read_out_of_memory(const mesh_reader *reader);
void svo_i_read_warn(const mesh_reader *reader, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Counts the vertices that the file declares and those that a triangle has; warns of the others. */
void svo_i_read_count_vertices(const mesh_reader *reader, uint64_t used_count, uint64_t declared_count);
/* The same for faces; those left out have fewer than three corners. */
void svo_i_read_count_faces(const mesh_reader *reader, uint64_t left_out_count, uint64_t declared_count);

/* The file as text. A byte order mark of UTF-8 is skipped, UTF-16 refused. */
svo_status svo_i_read_begin_text(const mesh_reader *reader, text_cursor *cursor);

/*
 * Number at the cursor: skips blanks, reads it and goes to the end of its word. *odd_count grows where text follows the
 * digits in the same word; the first such word is kept.
 */
typedef struct number_reader {
    const mesh_reader *reader;
    uint64_t odd_count, first_odd_line;
    text_word first_odd;
} number_reader;

svo_status svo_i_read_float(number_reader *numbers, text_cursor *cursor, float *value);
/* After the last number: warns of words that were numbers in part. */
void svo_i_read_warn_odd(const number_reader *numbers);

/* ---- materials ---- */

/* [0, 1] to 0 .. 255, rounded half up; NaN becomes 0. */
uint8_t svo_i_import_color_byte(float value);

/* A finish that svo_light_set_sources takes: what is negative or not finite becomes 0, specular color is at most 1. A
   material without specular color has no exponent. */
void svo_i_import_tame_finish(svo_finish *finish);

/* ---- textures ---- */

struct aiScene;

#define TEXTURE_KEEP_ALPHA (-1)

/* What a material asks for. */
typedef struct texture_source {
    const char *name; /* of a file beside the mesh file, or of an image inside */
    const void *bytes; /* the packed image inside the mesh file, where its reader knows it; else NULL */
    size_t byte_count;
    svo_wrap wrap_u, wrap_v;
    int alpha_from; /* texels of at least this alpha (0 .. 256) are opaque, others transparent; or TEXTURE_KEEP_ALPHA */
    bool is_bump; /* normals are wanted: heights become such */
} texture_source;

/* An image as a material asks for it. Each is decoded and sent once, also where that fails. */
typedef struct texture_entry {
    char *name;
    svo_wrap wrap_u, wrap_v;
    int alpha_from;
    bool is_bump;
    uint32_t index; /* SVO_NO_TEXTURE: it could not be read */
} texture_entry;

typedef struct texture_list {
    const struct aiScene *scene; /* may have images in it; NULL: all are files */
    const char *mesh_path;
    int stream;
    stream_work *work; /* announced to it; NULL: no memory is limited */
    texture_entry *entries;
    size_t entry_count, entry_capacity;
    uint32_t texture_count; /* sent */
} texture_list;

/*
 * The index of the texture that a material names; *index is SVO_NO_TEXTURE if it cannot be read.
 * Sends a new image, or a warning. Returns false when memory runs out or the parent has closed the pipe.
 */
bool svo_i_import_texture(texture_list *textures, const texture_source *source, uint32_t *index);
void svo_i_texture_list_free(texture_list *textures);

#endif
