/* SPDX-License-Identifier: MIT */
/*
 * The chunks of a .svo file that is put together from parts. They are levels of arrays, and each is made of the parts
 * in Morton order: the counts in the parts' heads give the place of every chunk, and of every part in it. So one
 * process may append part by part (stitch.c), or many may write runs of parts side by side (shares.c).
 */
#ifndef SVO_LIB_PARTS_CHUNKS_H
#define SVO_LIB_PARTS_CHUNKS_H

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "io/file_format.h"
#include "output/output.h"
#include "parts/pieces.h"

/* A chunk of the file. Parts append to all chunks in turn, each in its place. */
typedef struct svo_i_filling {
    XXH3_state_t hash; /* of its bytes so far */
    file_entry entry;
    file_chunk *chunk; /* plain_bytes: so far */
    uint64_t next; /* the children of its nodes, or its lists' entries, so far */
    bool is_left_out; /* nothing is done about it */
} svo_i_filling;

typedef struct svo_i_stitcher {
    svo_i_pieces all;
    svo_tree_info info; /* of the whole tree */
    const char *mesh_path;
    const char *path; /* of the file, for messages */
    svo_message *message;
    svo_i_output output;
    bool writes, hashes; /* what is done with bytes */
    size_t first, end; /* of the parts whose bytes are taken, with the nodes above that come before them */
    size_t passed; /* parts so far */
    file_head head;
    void *memory; /* of the fillings */
    svo_i_filling *fillings;
    uint32_t filling_count;
} svo_i_stitcher;

/* Counts the nodes of all parts, which are set, and places the chunks. Fails with SVO_CAPACITY_EXCEEDED. */
svo_status svo_i_chunks_begin(svo_i_stitcher *s);
/* Begins every chunk at its first byte. */
void svo_i_chunks_restart(svo_i_stitcher *s);
/* Appends the parts first .. end and the nodes above them; the others are passed over. */
svo_status svo_i_chunks_put_parts(svo_i_stitcher *s);
/* Appends what follows the parts' elements, or stands in their place, and completes the chunks, which have all parts
   and their checksums. */
svo_status svo_i_chunks_finish(svo_i_stitcher *s);
/* Writes the head of the file; the chunks are complete. */
svo_status svo_i_chunks_put_head(svo_i_stitcher *s);
void svo_i_chunks_free(svo_i_stitcher *s);

/* What the header says of the whole tree: all but counts. */
svo_tree_info svo_i_chunks_info(const svo_part_header *header);
/* Fills the head of a tree's file, but for checksums, and lists its chunks. Returns their number. */
uint32_t svo_i_chunks_place(const svo_tree_info *info, file_head *head, file_entry entries[FILE_CHUNKS_MAX]);
/* The element of payload that is the same in every node; zero in a tree without leaves. */
const void *svo_i_chunks_constant(const svo_part_header *header, const svo_tree_info *info, svo_tree_buffer array);
/* The element of a node above the parts; NULL: it has none. */
const void *svo_i_chunks_upper(const svo_i_upper_node *upper, svo_tree_buffer array);
/* Bytes that a part's segment must have, of one of its own levels; lists have any number of entries. */
uint64_t svo_i_chunks_segment_bytes(const svo_i_piece *piece, uint32_t kind, uint32_t level);

/* Whether parts and the nodes above them have elements of an array. */
bool svo_i_chunks_are_of_parts(const svo_i_stitcher *s, svo_tree_buffer array);
/* Bytes of a part in all chunks. */
uint64_t svo_i_chunks_part_bytes(const svo_i_stitcher *s, const svo_i_piece *piece);

#endif
