/* SPDX-License-Identifier: MIT */
/*
 * Regions of a tree of parts as .svo files: their heads, whose bytes are made at once, and bytes of chunks, which are
 * made when they are read. So whatever reads .svo files reads trees of parts.
 */
#ifndef SVO_LIB_PARTS_VIEW_H
#define SVO_LIB_PARTS_VIEW_H

#include "parts/tree.h"

typedef struct svo_i_parts_view {
    svo_parts_tree *tree;
    svo_tree_info info; /* of the region's tree */
    uint32_t level; /* of the region's root */
    uint64_t first[SVO_LEVELS_MAX]; /* of each level of the region: its first node, on the level of the whole tree */
    file_head head;
    file_entry entries[FILE_CHUNKS_MAX];
} svo_i_parts_view;

/* Makes the head of a region's file, for which it reads the region once. The tree's message stays in use. function: for
   messages. */
svo_status svo_i_parts_view_open(const char *function, svo_parts_tree *tree, const svo_parts_region *region,
                                 svo_i_parts_view *view);
/* A svo_i_source_reader of a view: the head, or whole elements of one chunk or more. */
svo_status svo_i_parts_view_read(void *of, uint64_t offset, void *out, size_t byte_count);
/* The file as a source. */
svo_i_source svo_i_parts_view_source(svo_i_parts_view *view);

#endif
