/* SPDX-License-Identifier: MIT */
/* Tiles of columns of large triangles, for the front end "cl". */
#ifndef SVO_LIB_PLAN_TILES_H
#define SVO_LIB_PLAN_TILES_H

#include "plan/plan_data.h"

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

/* Adds the tiles inside the draw that its triangles of more than SVO_TILE_COLUMNS columns can touch. Returns false when
   out of memory. */
bool svo_i_tiles_of_draw(const svo_plan *plan, const svo_i_draw *draw, svo_i_tiles *tiles);
/* An estimate of their number. */
double svo_i_tiles_expected(const svo_plan *plan, const svo_i_draw *draw);
/* Frees the tiles; a struct that is all zero is allowed. */
void svo_i_tiles_free(svo_i_tiles *tiles);

#endif
