/* SPDX-License-Identifier: MIT */
/*
 * Which chunks the file of a built tree has, in which order, and which elements of the tree's arrays each of them
 * holds. Saving, loading and stitching go through the same list.
 */
#ifndef SVO_LIB_IO_FILE_TREE_H
#define SVO_LIB_IO_FILE_TREE_H

#include "core/tree.h"
#include "io/file_format.h"

typedef struct file_entry {
    svo_tree_buffer buffer;
    uint32_t level; /* whose nodes or leaves the elements belong to; 0 in files before version 3 */
} file_entry;

/* Lists the chunks of a tree's file. Returns their count. */
uint32_t svo_i_file_list_entries(const svo_tree_info *info, uint32_t version, file_entry entries[FILE_CHUNKS_MAX]);

/* The kind of an entry's chunk. */
uint32_t svo_i_file_entry_kind(const file_entry *entry);

/* An entry's elements: the first of them in the tree's array, and their count. */
uint64_t svo_i_file_entry_begin(const svo_tree_info *info, uint32_t version, const file_entry *entry);
uint64_t svo_i_file_entry_count(const svo_tree_info *info, uint32_t version, const file_entry *entry);

#endif
