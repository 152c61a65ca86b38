/* SPDX-License-Identifier: MIT */
/* The parts of a tree in Morton order, and the nodes above them. */
#ifndef SVO_LIB_PARTS_PIECES_H
#define SVO_LIB_PARTS_PIECES_H

#include "core/tree.h"
#include "parts/part_file.h"

/* The sums of a node, and its materials with their weights, ascending. */
typedef struct svo_i_part_root {
    svo_i_node_sums sums;
    uint64_t *runs; /* owned */
    uint32_t run_count;
} svo_i_part_root;

/* The payload of a node, as it lies in the arrays of trees. */
typedef struct svo_i_part_payload {
    uint8_t color[4];
    int16_t normal[3];
    uint16_t material;
    uint16_t fill;
} svo_i_part_payload;

/* A part with nodes, as its file's head describes it. */
typedef struct svo_i_piece {
    const char *path; /* the caller's */
    uint32_t level;
    uint64_t code;
    uint64_t head_hash; /* of the file, with the checksums of its arrays */
    uint64_t fragments;
    uint64_t list_count;
    uint64_t file_bytes; /* where the file was read */
    svo_i_part_root root;
    uint32_t level_begin[SVO_LEVELS_MAX];
} svo_i_piece;

/* A node above the parts. */
typedef struct svo_i_upper_node {
    uint64_t code;
    svo_i_part_root root;
    svo_i_part_payload payload;
    uint8_t mask;
} svo_i_upper_node;

/* A tree's nodes and list entries are numbered in 32 bits, and the last number is none. */
#define PIECES_NODES_MAX (UINT32_MAX - 1u)

typedef struct svo_i_pieces {
    svo_part_header header;
    svo_message *message;
    svo_i_piece *pieces; /* in Morton order, without overlap */
    size_t piece_count;
    svo_i_upper_node *uppers; /* level by level */
    size_t upper_begin[SVO_PARTS_LEVELS_MAX];
} svo_i_pieces;

/* Reads the heads of part files and makes the nodes above them. To be freed also after a failure. header and message
   are set. */
svo_status svo_i_pieces_read(svo_i_pieces *all, const char *const *paths, size_t count);
void svo_i_pieces_free(svo_i_pieces *all);

/* Counts nodes and fragments into the info of the whole tree. Fails with SVO_CAPACITY_EXCEEDED. */
svo_status svo_i_pieces_count(const svo_i_pieces *all, svo_tree_info *info);

/* Nodes of a level, of all parts and above them. */
uint64_t svo_i_pieces_count_level(const svo_i_pieces *all, uint32_t level);
/* Whether the i-th part is the first below its node of a level above it. */
bool svo_i_pieces_begins_upper(const svo_i_pieces *all, size_t i, uint32_t level);

/* Called with a node above the parts, or with a part. The other is NULL. */
typedef svo_status (*svo_i_piece_visitor)(void *user, uint32_t level, const svo_i_upper_node *upper,
                                          const svo_i_piece *piece);
/* Calls for all nodes above the parts and all parts, each with its level: before a part come the nodes above it that it
   is the first below of. So a level's nodes come in their order. */
svo_status svo_i_pieces_visit_all(const svo_i_pieces *all, svo_i_piece_visitor visit, void *user);

#endif
