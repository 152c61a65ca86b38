/* SPDX-License-Identifier: MIT */
/* Reads a header and chunks: of a built tree, or of a compact one. Nothing larger than the file is allocated. */
#ifndef SVO_LIB_IO_FILE_LOAD_H
#define SVO_LIB_IO_FILE_LOAD_H

#include "core/memory.h"
#include "io/file_format.h"

/* A file that is read, from a descriptor or from memory. */
typedef struct svo_i_file_load {
    const char *name; /* begins messages */
    svo_message *message;
    svo_i_memory host_memory;
    uint64_t voxels_max; /* 0: by memory */
    const uint8_t *memory; /* the whole file, or NULL: read from file */
    int file;
    uint64_t file_bytes;
    file_head head;
} svo_i_file_load;

/* What tells a format's files from others. */
typedef struct svo_i_file_kind {
    const char *name; /* ".svo" */
    const char *magic; /* FILE_MAGIC_BYTES */
    uint32_t oldest_version, version; /* that are read */
    uint32_t chunks_max; /* at most FILE_CHUNKS_MAX */
} svo_i_file_kind;

/* Takes the caller's options. function: for the message. */
svo_status svo_i_file_read_options(const svo_load_options *options, const char *function, svo_i_file_load *state);
/* Opens the file whose path is state->name; closed by svo_i_file_load_close. */
svo_status svo_i_file_load_open(svo_i_file_load *state);
void svo_i_file_load_close(svo_i_file_load *state);

/* Reads header and chunk table into state->head and checks the header's values, levels included. */
svo_status svo_i_file_read_head(svo_i_file_load *state, const svo_i_file_kind *kind);
/* Checks a chunk's place, which must be offset, its codec, and that its bytes can hold what it says. array: its name.
   */
svo_status svo_i_file_check_place(const svo_i_file_load *state, const file_chunk *chunk, const char *array,
                                  uint64_t offset);
/* Checks that there are no further chunks or bytes. */
svo_status svo_i_file_check_end(const svo_i_file_load *state, uint32_t chunk_index, uint64_t offset);
/* Reads bytes that were checked to lie inside the file. */
svo_status svo_i_file_read_at(const svo_i_file_load *state, uint64_t offset, void *out, size_t byte_count);
/* Reads a chunk whose place was checked into memory for chunk->plain_bytes, and checks its checksum. */
svo_status svo_i_file_read_chunk(const svo_i_file_load *state, const file_chunk *chunk, const char *array, void *plain);
/* The same into new memory. *out, in host_memory, is set as soon as there is memory, also on failure. */
svo_status svo_i_file_load_chunk(const svo_i_file_load *state, const file_chunk *chunk, const char *array, void **out);

/* Fails where so many voxels, or the bytes of their arrays, are above the limit. */
svo_status svo_i_file_limit(const svo_i_file_load *state, uint64_t voxel_count, uint64_t byte_count);

/* SVO_FILE_DAMAGED, with the file's name before the words. */
svo_status svo_i_file_damaged(const svo_i_file_load *state, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* SVO_OUT_OF_HOST_MEMORY, with the file's name and the array's. */
svo_status svo_i_file_no_memory(const svo_i_file_load *state, const char *array, uint64_t byte_count);

#endif
