/* SPDX-License-Identifier: MIT */
/* Values of a PLY file in its three formats, one instance of an element after the other, in the import child. */
#ifndef SVO_LIB_IO_IMPORT_PLY_VALUE_H
#define SVO_LIB_IO_IMPORT_PLY_VALUE_H

#include "io/import_ply_header.h"

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

#endif
