/* SPDX-License-Identifier: MIT */
/* What the readers of blocks share: a window that moves over the file, and the block that is being filled. */
#ifndef SVO_LIB_IO_BLOCKS_FILE_H
#define SVO_LIB_IO_BLOCKS_FILE_H

#include "io/blocks.h"
#include "io/import_gather.h"

#define WINDOW_BYTES ((size_t)256 << 10)

typedef struct blocks_ply blocks_ply;

struct svo_i_blocks {
    const char *path; /* a copy */
    svo_message *message;
    int file;
    uint64_t file_bytes;
    char *window;
    uint64_t window_begin; /* its place in the file */
    size_t window_count, window_at; /* bytes in it, and those that have been read */

    float *positions, *normals; /* of the block */
    uint8_t *colors;
    size_t filled; /* triangles */
    bool has_normals, has_colors;

    blocks_ply *ply; /* NULL: STL */
    uint64_t facet_count, facets_read;
    bool is_magics, any_color;
    uint8_t no_color[4];
};

svo_status svo_i_blocks_no_memory(const svo_i_blocks *blocks);
/* Fails with the path and words. */
svo_status svo_i_blocks_fail(const svo_i_blocks *blocks, svo_status status, const char *words);
/* Reads bytes of any place. */
svo_status svo_i_blocks_read_at(const svo_i_blocks *blocks, uint64_t offset, void *out, size_t byte_count);
/* Moves the window on until it has so many bytes ahead, at most WINDOW_BYTES, or the rest of the file. */
svo_status svo_i_blocks_need(svo_i_blocks *blocks, size_t byte_count);
/* Sets where the window is. */
void svo_i_blocks_seek(svo_i_blocks *blocks, uint64_t offset);
/* Adds a corner to the block: the triangle filled, corner 0 .. 2. */
void svo_i_blocks_put(svo_i_blocks *blocks, unsigned corner, const gather_vertex *vertex);

/* The readers: each fills the block. */
svo_status svo_i_blocks_open_stl(svo_i_blocks *blocks);
svo_status svo_i_blocks_fill_stl(svo_i_blocks *blocks);
svo_status svo_i_blocks_open_ply(svo_i_blocks *blocks);
svo_status svo_i_blocks_fill_ply(svo_i_blocks *blocks);
void svo_i_blocks_rewind_ply(svo_i_blocks *blocks);
void svo_i_blocks_close_ply(svo_i_blocks *blocks);

#endif
