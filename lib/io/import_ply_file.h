/* SPDX-License-Identifier: MIT */
/*
 * A PLY file (Turk, "The PLY Polygon File Format", 1994): its header, its values, one instance of an element after the
 * other, and vertices of them.
 */
#ifndef SVO_LIB_IO_IMPORT_PLY_FILE_H
#define SVO_LIB_IO_IMPORT_PLY_FILE_H

#include "io/import_reader.h"

/* ---- the header ---- */

#define PLY_ELEMENTS_MAX   32
#define PLY_PROPERTIES_MAX 128 /* of one element */
#define PLY_NAME_BYTES     64
#define PLY_FILE_BYTES     1024

typedef enum ply_type {
    PLY_NO_TYPE = 0,
    PLY_INT8,
    PLY_UINT8,
    PLY_INT16,
    PLY_UINT16,
    PLY_INT32,
    PLY_UINT32,
    PLY_FLOAT,
    PLY_DOUBLE
} ply_type;

typedef enum ply_format { PLY_ASCII = 0, PLY_LITTLE_ENDIAN, PLY_BIG_ENDIAN } ply_format;

typedef struct ply_property {
    char name[PLY_NAME_BYTES];
    ply_type type; /* of the value, or of a list's elements */
    ply_type count_type; /* of a list's length; PLY_NO_TYPE: no list */
} ply_property;

typedef struct ply_element {
    char name[PLY_NAME_BYTES];
    uint64_t count;
    ply_property *properties;
    size_t property_count;
} ply_element;

typedef struct ply_header {
    ply_format format;
    ply_element elements[PLY_ELEMENTS_MAX];
    size_t element_count;
    char texture_file[PLY_FILE_BYTES]; /* of "comment TextureFile NAME"; "": none */
} ply_header;

/* Reads the header; the cursor is then at the first byte of the data. svo_i_ply_header_free releases what it holds,
   also after a failure. */
svo_status svo_i_ply_read_header(const mesh_reader *reader, text_cursor *cursor, ply_header *header);
void svo_i_ply_header_free(ply_header *header);

/* Bytes of a value in a binary file. */
size_t svo_i_ply_type_bytes(ply_type type);
/* Bytes of an instance of an element; 0: it has lists. */
size_t svo_i_ply_fixed_bytes(const ply_element *element);
/* The property of this name; property_count: there is none. */
size_t svo_i_ply_find(const ply_element *element, const char *name);

/* ---- values, in the three formats ---- */

typedef struct ply_source {
    const mesh_reader *reader;
    ply_format format;
    text_cursor cursor; /* line: for ascii alone */
    uint64_t earlier_bytes, later_bytes; /* of the file, where the reader has a block of it */
    number_reader numbers;
    const ply_element *element; /* for messages: what is read, and its number from 0 */
    uint64_t instance;
    uint64_t long_count, first_long_line; /* lines of ascii with more values than declared */
} ply_source;

/* Whether count instances of the element can fit into the rest of the file. */
svo_status svo_i_ply_check_fit(const ply_source *source, const ply_element *element);

/* Around the values of an instance: skips to its line, and past it; nothing in binary files. */
svo_status svo_i_ply_begin_instance(ply_source *source);
void svo_i_ply_end_instance(ply_source *source);

/* The next value, converted. A float is copied bit for bit; a double is rounded to the nearest float. */
svo_status svo_i_ply_float(ply_source *source, ply_type type, float *value);
/* The next value as a whole number; in ascii files it must be written as one. */
svo_status svo_i_ply_integer(ply_source *source, ply_type type, int64_t *value);
/* The length of a list, checked against the rest of the file. */
svo_status svo_i_ply_list_length(ply_source *source, const ply_property *property, uint64_t *length);
/* Skips a value or a list. */
svo_status svo_i_ply_skip(ply_source *source, const ply_property *property);
/* Skips all instances of an element. */
svo_status svo_i_ply_skip_element(ply_source *source, const ply_element *element);

/* ---- vertices ---- */

/* What a property of a vertex is for: components of gather_vertex. */
typedef enum ply_slot {
    PLY_SLOT_NONE = 0,
    PLY_SLOT_POSITION,
    PLY_SLOT_NORMAL = PLY_SLOT_POSITION + 3,
    PLY_SLOT_UV = PLY_SLOT_NORMAL + 3,
    PLY_SLOT_COLOR = PLY_SLOT_UV + 2,
    PLY_SLOT_END = PLY_SLOT_COLOR + 4
} ply_slot;

/* The slot of each property. with_uvs: texture coordinates are read. Sets *has_normals and *has_colors where the
   element has them. */
void svo_i_ply_note_slots(const ply_element *element, bool with_uvs, ply_slot slots[PLY_PROPERTIES_MAX],
                          bool *has_normals, bool *has_colors);
/* What a vertex has before its values are read: zero, but white. Color channels that are missing beside others are 0,
   but alpha is 255. */
gather_vertex svo_i_ply_blank_vertex(const ply_element *element, const ply_slot slots[PLY_PROPERTIES_MAX]);
/* Reads the values of a vertex. */
svo_status svo_i_ply_read_vertex(ply_source *source, const ply_element *element,
                                 const ply_slot slots[PLY_PROPERTIES_MAX], gather_vertex *vertex);
/* A color channel as a byte. Bytes are copied, 16 bits scaled, floats taken from [0, 1]; wider whole numbers hold what
   a byte would. */
svo_status svo_i_ply_read_color(ply_source *source, ply_type type, uint8_t *channel);

/* Whether vertices or faces have texture coordinates. */
bool svo_i_ply_declares_uvs(const ply_header *header);
/* The list of a face's vertices; property_count: there is none. */
size_t svo_i_ply_find_index_list(const ply_element *element);

#endif
