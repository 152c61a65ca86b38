/* SPDX-License-Identifier: MIT */
/* Writes a header and chunks: of a built tree, or of a compact one. */
#ifndef SVO_LIB_IO_FILE_SAVE_H
#define SVO_LIB_IO_FILE_SAVE_H

#include <stdbool.h>

#include "core/memory.h"
#include "io/file_format.h"

/* An array of the file. */
typedef struct svo_i_file_array {
    uint32_t kind; /* of its chunk */
    const char *name; /* for messages */
    const void *plain; /* the caller's */
    uint64_t bytes;
} svo_i_file_array;

typedef struct svo_i_file_save {
    const char *name; /* begins messages: the path or the function */
    svo_message *message;
    const svo_i_memory *memory; /* for compressed chunks; NULL: malloc and free */
    svo_write_callback write;
    void *user;
    bool compress;
    file_head head; /* the caller fills the header, but for lengths, counts and checksums */
    svo_i_file_array arrays[FILE_CHUNKS_MAX]; /* in the order of their chunks */
    uint32_t array_count;
    void *packed[FILE_CHUNKS_MAX]; /* compressed chunks, in the order of head.chunks; NULL: written as they are */
} svo_i_file_save;

/* Fills the header of a built tree's file, but for lengths, counts and checksums. */
void svo_i_file_fill_header(file_header *header, const svo_tree_info *info);
/* Writes the file through state->write. */
svo_status svo_i_file_write(svo_i_file_save *state);
/* Writes the file to a path, whole or not at all; sets name, write and user. */
svo_status svo_i_file_save_to(svo_i_file_save *state, const char *path);

#endif
