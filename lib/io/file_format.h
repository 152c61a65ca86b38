/* SPDX-License-Identifier: MIT */
/*
 * The .svo format as structs, and the functions that read and write it. io.h documents the format byte by byte; the
 * assertions below keep the two equal. Hosts and files are little-endian, so a struct in memory is its bytes in the
 * file.
 */
#ifndef SVO_LIB_IO_FILE_FORMAT_H
#define SVO_LIB_IO_FILE_FORMAT_H

#include <assert.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/compact.h"
#include "core/memory.h"
#include "core/tree.h"
#include "io/files.h"
#include "svocl/io.h"
#include "svocl/tree.h"

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "svocl reads and writes .svo files in memory order and needs a little-endian host"
#endif

#define FILE_MAGIC       "\x89SVO\r\n\x1a\n"
#define FILE_MAGIC_BYTES 8
#define FILE_VERSION     4
#define FILE_OLDEST      1 /* version that is still read: without the mesh's own positions */
#define FILE_EXACT       4 /* the first version whose voxels are those of the mesh as given */
#define FILE_BY_LEVELS   3 /* the first version whose chunks are arrays of one level, without first_child */
#define FILE_HASH_BEGIN  32 /* the header's checksum covers everything from here to the end of the chunk table */

/* Files of compact trees. The header has the same fields; its levels are those of the inner nodes. */
#define FILE_COMPACT_MAGIC   "\x89SVC\r\n\x1a\n"
#define FILE_COMPACT_VERSION 3 /* with packed payload; other files have the version before */
#define FILE_COMPACT_OLDEST  1 /* version that is still read */
#define FILE_COMPACT_EXACT   2 /* the first version whose voxels are those of the mesh as given */
#define FILE_COMPACT_PACKED  3 /* the first version with packed payload */
/* The bit of file_counts.packed that says that voxels are those of the mesh as it was rounded. */
#define FILE_PACKED_ROUNDED 0x80000000u

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
    uint64_t reserved; /* 0; any value in files that svocl wrote before */
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
    uint32_t packed; /* svo_need bits, and FILE_PACKED_ROUNDED; 0 before version 3 */
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

/* ---- reading a header and chunks: of a built tree, or of a compact one ---- */

/* A file that is read. */
typedef struct svo_i_file_load {
    svo_i_source source;
    svo_i_memory host_memory;
    uint64_t voxels_max; /* 0: by memory */
    uint32_t last_level; /* 0: all */
    file_head head;
} svo_i_file_load;

/* What tells a format's files from others. */
typedef struct svo_i_file_kind {
    const char *name; /* ".svo" */
    const char *magic; /* FILE_MAGIC_BYTES */
    uint32_t oldest_version, version; /* that are read */
    uint32_t chunks_max; /* at most FILE_CHUNKS_MAX */
} svo_i_file_kind;

/* Takes the caller's options and opens the source, which the caller closes after success. function: for messages. */
svo_status svo_i_file_load_open(const char *function, svo_source source, const svo_load_options *options,
                                svo_message *message, svo_i_file_load *state);

/* Reads header and chunk table into state->head and checks the header's values, levels included. */
svo_status svo_i_file_read_head(svo_i_file_load *state, const svo_i_file_kind *kind);
/* Checks a chunk's place, which must be offset, its codec, and that its bytes can hold what it says. array: its name.
   */
svo_status svo_i_file_check_place(const svo_i_file_load *state, const file_chunk *chunk, const char *array,
                                  uint64_t offset);
/* Checks that there are no further chunks or bytes. */
svo_status svo_i_file_check_end(const svo_i_file_load *state, uint32_t chunk_index, uint64_t offset);
/* Reads a chunk whose place was checked into memory for chunk->plain_bytes, and checks its checksum. */
svo_status svo_i_file_read_chunk(const svo_i_file_load *state, const file_chunk *chunk, const char *array, void *plain);

/* Fails where so many voxels, or the bytes of their arrays, are above the limit. */
svo_status svo_i_file_limit(const svo_i_file_load *state, uint64_t voxel_count, uint64_t byte_count);

/* SVO_FILE_DAMAGED, with the file's name before the words. */
svo_status svo_i_file_damaged(const svo_i_file_load *state, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* SVO_OUT_OF_HOST_MEMORY, with the file's name and the array's. */
svo_status svo_i_file_no_memory(const svo_i_file_load *state, const char *array, uint64_t byte_count);

/* ---- writing them ---- */

/* An array of the file. */
typedef struct svo_i_file_array {
    uint32_t kind; /* of its chunk */
    const char *name; /* for messages */
    const void *plain; /* the caller's */
    uint64_t bytes;
} svo_i_file_array;

typedef struct svo_i_file_save {
    svo_i_sink sink;
    const svo_i_memory *memory; /* for compressed chunks; NULL: malloc and free */
    bool compress;
    file_head head; /* the caller fills the header, but for lengths, counts and checksums */
    svo_i_file_array arrays[FILE_CHUNKS_MAX]; /* in the order of their chunks */
    uint32_t array_count;
    void *packed[FILE_CHUNKS_MAX]; /* compressed chunks, in the order of head.chunks; NULL: written as they are */
} svo_i_file_save;

/* Fills the header of a built tree's file, but for lengths, counts and checksums. */
void svo_i_file_fill_header(file_header *header, const svo_tree_info *info);
/* Opens the sink, writes the file and closes it. function: for messages. */
svo_status svo_i_file_write(svo_i_file_save *state, const char *function, svo_sink sink, svo_message *message);

/*
 * ---- files of built trees ----
 *
 * Which chunks the file has, in which order, and which elements of the tree's arrays each of them holds. Saving,
 * loading and stitching go through the same list.
 */

typedef struct file_entry {
    svo_tree_buffer buffer;
    uint32_t level; /* whose nodes or leaves the elements belong to; 0 in files before version 3 */
} file_entry;

/* Lists the chunks of a tree's file. Returns their count. */
uint32_t svo_i_file_list_entries(const svo_tree_info *info, uint32_t version, file_entry entries[FILE_CHUNKS_MAX]);

/* The kind of an entry's chunk. */
static inline uint32_t file_entry_kind(const file_entry *entry)
{
    return (uint32_t)entry->buffer | entry->level << FILE_KIND_BITS;
}

/* How many elements an entry has. */
uint64_t svo_i_file_entry_count(const svo_tree_info *info, uint32_t version, const file_entry *entry);

typedef struct svo_i_tree_file {
    svo_i_file_load *load;
    svo_tree_info info; /* of the whole tree */
    file_entry entries[FILE_CHUNKS_MAX]; /* in the order of the chunks */
} svo_i_tree_file;

/* Names an entry in messages: the array, and its level if it has several. */
typedef struct svo_i_entry_name {
    char text[48];
} svo_i_entry_name;
svo_i_entry_name svo_i_tree_file_name(const svo_i_tree_file *file, uint32_t chunk_index);

/* Reads the header and checks it and the whole table of chunks. load: set, and open. */
svo_status svo_i_tree_file_read_head(svo_i_tree_file *file);

/* Loads the tree of an open file, or its upper levels. */
svo_status svo_i_tree_file_load(svo_i_file_load *state, svo_tree **out);

/* The properties of the tree that ends at a level of a larger one: its nodes are the leaves, and the mesh is gone. */
void svo_i_tree_keep_levels(svo_tree_info *info, uint32_t last_level);

/* ---- what files hold ---- */

/*
 * Checks the arrays of a tree whose counts already agree with its header: node links, lists and geometry.
 * name: the file's, for the message. Returns SVO_FILE_DAMAGED with what is wrong and where.
 */
svo_status svo_i_file_check_structure(const svo_tree *tree, const char *name, svo_message *message);

/* Checks the arrays of a compact tree whose lengths already agree with its info: every word, mask and place is such as
   svo_compact_create makes it. name: the file's. Returns SVO_FILE_DAMAGED with what is wrong and where. */
svo_status svo_i_compact_check(const svo_compact *compact, const char *name, svo_message *message);

/* What records unfold to. */
typedef struct svo_i_record_counts {
    uint64_t inner[SVO_LEVELS_MAX]; /* inner nodes on each level */
    uint64_t leaf[SVO_LEVELS_MAX]; /* leaves on each level */
    uint64_t records;
    uint64_t places; /* 0 without places */
} svo_i_record_counts;

/* The same for nodes and links of SVO_FORM_SHARED and SVO_FORM_MIRRORED alone: that each record lies within the words,
   on the level where those above look for it, in its order, with the numbers that its subtrees have. counts: receives
   what they unfold to. */
svo_status svo_i_records_check(const svo_compact *compact, const char *name, svo_i_record_counts *counts,
                               svo_message *message);

#endif
