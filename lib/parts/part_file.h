/* SPDX-License-Identifier: MIT */
/*
 * Part files as structs, and how they are written and read; parts.h documents them. A file is a head, a table of
 * segments and the segments. Hosts and files are little-endian, so a struct in memory is its bytes in the file. Files
 * are not trusted: every byte that is used is covered by a checksum that has been compared.
 */
#ifndef SVO_LIB_PARTS_PART_FILE_H
#define SVO_LIB_PARTS_PART_FILE_H

#include <assert.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/tree.h"
#include "svocl/parts.h"
#include "svocl/plan.h"

#define PART_MAGIC       "\x89SVP\r\n\x1a\n"
#define PART_MAGIC_BYTES 8
#define PART_VERSION     4 /* 1: voxels of the rounded mesh; 2: colors that alpha does not weigh; 3: a short identity */
#define PART_HASH_BEGIN  32 /* the head's checksum covers everything from here to the end of the table */

/* Kinds of segments: a svo_tree_buffer, or the root's materials and weights. */
#define PART_RUNS ((uint32_t)SVO_TREE_BUFFER_COUNT)

/* A level has one of each array at most; leaves have three more, the root has its runs, a mesh has four. */
#define PART_SEGMENTS_MAX (SVO_DEPTH_LEVELS * 5 + 4)
#define SVO_DEPTH_LEVELS  17

typedef struct part_head {
    uint8_t magic[PART_MAGIC_BYTES];
    uint32_t version;
    uint32_t segment_count;
    uint64_t file_bytes;
    uint64_t head_hash;
    uint64_t whole[2]; /* svo_i_part_identity */
    uint64_t code;
    uint32_t level;
    uint32_t is_mesh; /* 1: what rays meet of the whole; 0: a part */
    uint64_t fragments;
    svo_i_node_sums root;
    uint32_t level_begin[SVO_LEVELS_MAX]; /* of the part's own levels, its root is level 0 */
} part_head;

typedef struct part_segment {
    uint32_t kind;
    uint32_t level; /* of the part's own levels */
    uint64_t offset;
    uint64_t bytes;
    uint64_t hash;
} part_segment;

typedef struct part_file {
    part_head head;
    part_segment segments[PART_SEGMENTS_MAX];
} part_file;

static_assert(sizeof(svo_part_header) == 168, "no padding: its bytes are hashed");
static_assert(offsetof(part_head, whole) == PART_HASH_BEGIN, "parts.h: whole");
static_assert(sizeof(part_head) == 208, "parts.h: head");
static_assert(sizeof(part_segment) == 32, "parts.h: segment");
static_assert(offsetof(part_file, segments) == 208, "parts.h: table");

/* ---- identities ---- */

#define IDENTITY_BYTES SVO_PARTS_IDENTITY_BYTES
typedef char svo_i_identity_text[IDENTITY_BYTES];

/* Which tree a file is of: an XXH3-128 of the header's values, whose input_hash is of the triangles and materials, and
   of the versions of the library and of part files. */
void svo_i_part_identity(const svo_part_header *header, uint64_t identity[2]);
void svo_i_identity_write(const uint64_t identity[2], svo_i_identity_text text);
/* Refuses a file by its name and both identities, with SVO_FILE_DAMAGED. then: what helps, from ";" on. */
svo_status svo_i_part_is_foreign(const char *path, const uint64_t found[2], const uint64_t own[2], const char *then,
                                 svo_message *message);

/* SVO_UNAVAILABLE for an errno that may pass, such as that of a full disk; SVO_FILE_ERROR for others. */
svo_status svo_i_file_status(int error);

/* svo_part_save_mesh for a header that has more than the plan knows. */
svo_status svo_i_part_save_mesh(svo_plan *plan, const svo_part_header *header, const char *path, svo_message *message);

/* ---- reading ---- */

typedef struct svo_i_part_reader {
    const char *path;
    svo_message *message;
    int file;
    part_file content; /* head and table */
} svo_i_part_reader;

/* Opens a file of the whole that the header describes. To be closed also after a failure. */
svo_status svo_i_part_open(const svo_part_header *header, const char *path, bool is_mesh, svo_message *message,
                           svo_i_part_reader *reader);
void svo_i_part_close(svo_i_part_reader *reader);

/* The segment of a kind and level; NULL: the file has none. */
const part_segment *svo_i_part_find(const svo_i_part_reader *reader, uint32_t kind, uint32_t level);

/* Called with the bytes of a segment, a piece at a time; pieces but the last are multiples of 65536 bytes. */
typedef svo_status (*svo_i_part_visitor)(void *user, const void *bytes, size_t byte_count);
/* Reads a segment and compares its checksum after the last piece, so what came from it is void after a failure. visit:
   NULL allowed. */
svo_status svo_i_part_stream(const svo_i_part_reader *reader, const part_segment *segment, svo_i_part_visitor visit,
                             void *user);
/* Reads bytes of the file, which are not checked. */
svo_status svo_i_part_read(const svo_i_part_reader *reader, uint64_t offset, void *out, size_t byte_count);
/* Fails for a file whose contents contradict each other. */
svo_status svo_i_part_damaged(const svo_i_part_reader *reader, const char *why);

/* Checks a part file: its head, and on request every byte. */
svo_status svo_i_part_check(const svo_part_header *header, const char *path, bool reads_all, svo_part_info *info,
                            svo_message *message);

/* Takes a caller's header. */
svo_status svo_i_part_header_read(const char *function, const svo_part_header *given, svo_message *message,
                                  svo_part_header *header);

#endif
