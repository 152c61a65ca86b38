/* SPDX-License-Identifier: MIT */
/*
 * Which chunks the file of a built tree has, in which order, and which elements of the tree's arrays each of them holds.
 * file_save.c and tree_load.c go through the same list.
 */
#ifndef SVO_LIB_IO_FILE_TREE_H
#define SVO_LIB_IO_FILE_TREE_H

#include "core/tree.h"
#include "io/file_format.h"

typedef struct file_part {
    svo_tree_buffer buffer;
    uint32_t level; /* whose nodes or leaves the elements belong to; 0 in files before version 3 */
} file_part;

/* Lists the chunks of a tree's file. Returns their count. */
uint32_t file_list_parts(const svo_tree_info *info, uint32_t version, file_part parts[FILE_CHUNKS_MAX]);

/* The kind of a part's chunk. */
uint32_t file_part_kind(const file_part *part);

/* A part's elements: the first of them in the tree's array, and their count. */
uint64_t file_part_begin(const svo_tree_info *info, uint32_t version, const file_part *part);
uint64_t file_part_count(const svo_tree_info *info, uint32_t version, const file_part *part);

#endif
