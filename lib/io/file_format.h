/* SPDX-License-Identifier: MIT */
/*
 * The .svo format as structs, for file_save.c, file_load.c and tree_load.c. io.h documents it byte by byte; the
 * assertions below keep the two equal. Hosts and files are little-endian, so a struct in memory is its bytes in the
 * file.
 */
#ifndef SVO_LIB_IO_FILE_FORMAT_H
#define SVO_LIB_IO_FILE_FORMAT_H

#include <assert.h>
#include <stddef.h>
#include <stdint.h>

#include "svocl/io.h"

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "svocl reads and writes .svo files in memory order and needs a little-endian host"
#endif

#define FILE_MAGIC       "\x89SVO\r\n\x1a\n"
#define FILE_MAGIC_BYTES 8
#define FILE_VERSION     3
#define FILE_OLDEST      1 /* version that is still read: without the mesh's own positions */
#define FILE_BY_LEVELS   3 /* the first version whose chunks are arrays of one level, without first_child */
#define FILE_HASH_BEGIN  32 /* the header's checksum covers everything from here to the end of the chunk table */

/* Files of compact trees. The header has the same fields; its levels are those of the inner nodes. */
#define FILE_COMPACT_MAGIC   "\x89SVC\r\n\x1a\n"
#define FILE_COMPACT_VERSION 1

typedef struct file_header {
    uint8_t magic[FILE_MAGIC_BYTES];
    uint32_t version;
    uint32_t header_bytes;
    uint64_t file_bytes;
    uint64_t header_hash;
    uint32_t chunk_count;
    uint32_t depth;
    uint32_t snap_bits;
    uint32_t coverage;
    uint16_t need;
    uint16_t constant;
    uint16_t weights;
    uint16_t payload_level;
    double origin[3];
    double edge;
    double scale;
    double snap_error;
    uint64_t triangles;
    uint64_t refused_triangles;
    uint64_t fragments;
    uint32_t level_begin[SVO_LEVELS_MAX];
} file_header;

typedef enum file_codec { FILE_CODEC_STORED = 0, FILE_CODEC_ZSTD = 1 } file_codec;

/* A chunk's kind has the array in its lower bits, and above them the level. */
#define FILE_KIND_BITS 16

typedef struct file_chunk {
    uint32_t kind;
    uint32_t codec;
    uint64_t offset;
    uint64_t stored_bytes;
    uint64_t plain_bytes;
    uint64_t hash;
} file_chunk;

/* Chunks of a file at most: child masks and four kinds of payload by level, and every array once. */
#define FILE_CHUNKS_MAX (5 * SVO_LEVELS_MAX + SVO_TREE_BUFFER_COUNT)

/* Header and table as they lie in the file, for as many chunks as a file can have. */
typedef struct file_head {
    file_header header;
    file_chunk chunks[FILE_CHUNKS_MAX];
} file_head;

/* The first chunk of a compact tree's file. */
#define FILE_COUNTS 64
typedef struct file_counts {
    uint32_t form;
    uint32_t minimized;
    uint32_t directory_step_log2;
    uint32_t reserved;
    uint64_t stored_count;
    uint64_t far_count;
    uint64_t shared_count;
    uint32_t level_leaf[SVO_LEVELS_MAX];
} file_counts;

static_assert(sizeof(file_counts) == 112, "io.h: counts");
static_assert(offsetof(file_header, file_bytes) == 16, "io.h: file_bytes");
static_assert(offsetof(file_header, chunk_count) == FILE_HASH_BEGIN, "io.h: chunk_count");
static_assert(offsetof(file_header, origin) == 56, "io.h: origin");
static_assert(offsetof(file_header, triangles) == 104, "io.h: triangles");
static_assert(offsetof(file_header, level_begin) == 128, "io.h: level_begin");
static_assert(sizeof(file_header) == 200, "io.h: header");
static_assert(sizeof(file_chunk) == 40, "io.h: chunk entry");
static_assert(offsetof(file_head, chunks) == 200, "io.h: chunk table");

#endif
