/* SPDX-License-Identifier: MIT */
/* The cut of the fragment list: into chunks, and of what a large triangle covers into tiles. */
#ifndef SVO_LIB_PLAN_CHUNKING_H
#define SVO_LIB_PLAN_CHUNKING_H

#include "plan/plan_data.h"

SVO_I_SHARED_BEGIN

/* Cuts the list into chunks of at most chunk_bytes, by the fragment estimate. */
svo_status svo_i_chunking_create(const svo_plan *plan, uint64_t chunk_bytes, svo_i_chunking *chunking);
void svo_i_chunking_destroy(svo_i_chunking *chunking);

SVO_I_SHARED_END

/* The limit on chunks: the least of the front end's, the device's and the request's. frontend_bytes: UINT64_MAX where
   no front end is known. */
uint64_t svo_i_chunk_bytes_max(const svo_plan *plan, uint64_t frontend_bytes);
/* Replaces a chunking with chunks that were too small. needed: number of fragments of each chunk. */
svo_status svo_i_chunking_grow(const svo_plan *plan, uint64_t chunk_bytes, const uint64_t *needed,
                               svo_i_chunking *chunking);

/* Tiles of columns of large triangles, for the front end "cl". */

typedef struct svo_i_tiles {
    const svo_i_memory *memory; /* where the items come from */
    svo_tile_item *items;
    size_t count, capacity;
} svo_i_tiles;

/* The tiles of all draws of a list of one chunk. Repeated draws of the list reuse them. */
typedef struct svo_i_tile_cache {
    svo_i_tiles tiles;
    size_t *begin; /* index of each draw's first tile, and the end; NULL: empty cache */
} svo_i_tile_cache;

/* Adds the tiles inside the draw that its triangles of more than SVO_TILE_COLUMNS columns can touch, but not those of
   more than most_columns, unless that is 0. Returns false when out of memory. */
bool svo_i_tiles_of_draw(const svo_plan *plan, const svo_i_draw *draw, uint32_t most_columns, svo_i_tiles *tiles);
/* An estimate of their number. */
double svo_i_tiles_expected(const svo_plan *plan, const svo_i_draw *draw);
/* Frees the tiles; a struct that is all zero is allowed. */
void svo_i_tiles_free(svo_i_tiles *tiles);

/* What is left of a cut with most_columns: the triangles of more columns in their draw. */
typedef struct svo_i_rest {
    svo_draw_item *items; /* owned */
    uint32_t item_count;
    uint64_t others; /* triangles of all draws that are not among them */
    svo_i_chunking chunking; /* the cut's chunks, whose draws are of these items */
} svo_i_rest;

SVO_I_SHARED_BEGIN

/* Whether there may be such triangles; from SVO_TILE_COLUMNS on that is known without the plan's arrays. */
bool svo_i_rest_may_exist(const svo_plan *plan, uint32_t most_columns);
/* plan: its arrays are on the host. most_columns: not 0. */
svo_status svo_i_rest_find(const svo_plan *plan, const svo_i_chunking *cut, uint32_t most_columns, svo_i_rest *out);
/* Accepts one that is all zero. */
void svo_i_rest_free(svo_i_rest *rest);

SVO_I_SHARED_END

#endif
