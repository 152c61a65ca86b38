/* SPDX-License-Identifier: MIT */
/* The file of a built tree that is read in pieces: its header, and which chunk holds what. */
#ifndef SVO_LIB_IO_TREE_LOAD_H
#define SVO_LIB_IO_TREE_LOAD_H

#include "io/file_load.h"
#include "io/file_tree.h"

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

#endif
