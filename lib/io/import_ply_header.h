/* SPDX-License-Identifier: MIT */
/* The header of a PLY file (Turk, "The PLY Polygon File Format", 1994), in the import child. */
#ifndef SVO_LIB_IO_IMPORT_PLY_HEADER_H
#define SVO_LIB_IO_IMPORT_PLY_HEADER_H

#include "io/import_reader.h"

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
/* The property of this name; property_count: there is none. */
size_t svo_i_ply_find(const ply_element *element, const char *name);

#endif
