/* SPDX-License-Identifier: MIT */
/*
 * What the readers of OBJ, PLY, STL, OFF and glTF share, in the import child. They read the whole file or fail with its
 * line or byte, the value and the limit. What they leave out on purpose is a warning.
 */
#ifndef SVO_LIB_IO_IMPORT_READER_H
#define SVO_LIB_IO_IMPORT_READER_H

#include "io/import_gather.h"
#include "io/import_stream.h"
#include "io/import_text.h"

typedef struct mesh_reader {
    const char *path; /* whose folder material libraries and textures are relative to; NULL: none are read */
    const char *bytes; /* the whole file */
    size_t byte_count;
    int stream; /* receives textures and warnings */
    gather *mesh; /* receives the mesh */
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

#endif
