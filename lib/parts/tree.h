/* SPDX-License-Identifier: MIT */
/*
 * A folder of parts as a tree: the nodes of a level are numbered over all parts, and elements of arrays are read by
 * these numbers. view.h makes .svo files of it.
 */
#ifndef SVO_LIB_PARTS_TREE_H
#define SVO_LIB_PARTS_TREE_H

#include "parts/chunks.h"
#include "parts/folder.h"
#include "parts/job.h"
#include "svocl/parts_tree.h"

#define TREE_READERS 32 /* part files that are open at one time */
#define TREE_CHECKED 2 /* words of 64 segments each */

static_assert(PART_SEGMENTS_MAX <= TREE_CHECKED * 64, "a bit for each segment");

struct svo_parts_tree {
    svo_parts *parts; /* owned */
    svo_i_part_files files; /* owned */
    svo_i_pieces all;
    svo_message *message; /* of the call in progress */
    /* Nodes of a level before each part, its own and those above it that begin with it not counted: rows of
       piece_count + 1, whose last is the level's count. A part of a deeper level stands for the node above it that it
       is the first below of, if it is. */
    uint64_t *before;
    uint64_t *list_before; /* list entries before each part, and of all */
    uint64_t *checked; /* TREE_CHECKED words for each part: segments whose checksums were compared */
    uint64_t file_bytes;
    uint64_t nodes_max; /* PIECES_NODES_MAX: of nodes and of list entries, what numbers of 32 bits can tell apart */
    svo_i_part_reader readers[TREE_READERS]; /* part i is in reader i % TREE_READERS, if it is open */
    size_t reader_pieces[TREE_READERS]; /* and which it has */
};

/* Opens a folder; see svo_parts_tree_open. function: for messages. */
svo_status svo_i_parts_tree_open(const char *function, const char *folder, svo_parts_tree **out, svo_message *message);
/* The nodes of a level. */
uint64_t svo_i_parts_tree_nodes(const svo_parts_tree *tree, uint32_t level);
/* The deepest level down to which all nodes are at most nodes_max. */
uint32_t svo_i_parts_tree_last_level(const svo_parts_tree *tree);

/* Reads elements of an array of a level, count of them from the first on. Of SVO_TREE_LIST they are counted over all
   parts, too, and SVO_TREE_LIST_BEGIN has places there of 64 bits, one after the last leaf as well. */
svo_status svo_i_parts_tree_read(svo_parts_tree *tree, svo_tree_buffer array, uint32_t level, uint64_t first,
                                 uint64_t count, void *out);
/* Reads bytes of an array of the mesh; SVO_FILE_DAMAGED unless it has array_bytes. */
svo_status svo_i_parts_tree_read_mesh(svo_parts_tree *tree, svo_tree_buffer array, uint64_t array_bytes,
                                      uint64_t offset, size_t byte_count, void *out);
/* The children of the nodes first .. first + count of a level: where they begin on the next one, and how many. */
svo_status svo_i_parts_tree_children(svo_parts_tree *tree, uint32_t level, uint64_t *first, uint64_t *count);

#endif
