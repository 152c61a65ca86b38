/* SPDX-License-Identifier: MIT */
/*
 * Part files as structs; parts.h documents them. A file is a head, a table of segments and the segments. Hosts and
 * files are little-endian, so a struct in memory is its bytes in the file.
 */
#ifndef SVO_LIB_PARTS_FORMAT_H
#define SVO_LIB_PARTS_FORMAT_H

#include <assert.h>
#include <stddef.h>
#include <stdint.h>

#include "core/tree.h"

#define PART_MAGIC       "\x89SVP\r\n\x1a\n"
#define PART_MAGIC_BYTES 8
#define PART_VERSION     1
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
    uint64_t whole; /* checksum of the whole's header */
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

static_assert(sizeof(svo_part_header) == 160, "no padding: its bytes are hashed");
static_assert(offsetof(part_head, whole) == PART_HASH_BEGIN, "parts.h: whole");
static_assert(sizeof(part_head) == 200, "parts.h: head");
static_assert(sizeof(part_segment) == 32, "parts.h: segment");
static_assert(offsetof(part_file, segments) == 200, "parts.h: table");

/* Checksum of a header's values, by which part files know their whole. */
uint64_t svo_i_part_header_hash(const svo_part_header *header);

#endif
