/* SPDX-License-Identifier: MIT */
/* Large triangles cut into tiles of columns, for the OpenCL front end. */
#ifndef SVO_LIB_PLAN_TILES_H
#define SVO_LIB_PLAN_TILES_H

#include "plan/plan_data.h"

typedef struct svo_i_tiles {
    svo_tile_item *items;
    size_t count, capacity;
} svo_i_tiles;

/* The tiles of all draws of one chunk. A list that is drawn many times finds them once. */
typedef struct svo_i_tile_cache {
    svo_i_tiles tiles;
    size_t *begin; /* per draw, and the end; NULL: not found yet */
} svo_i_tile_cache;

/* Adds the tiles that the draw's triangles of more than SVO_TILE_COLUMNS columns can touch, those inside the draw.
   False: out of memory. */
bool svo_i_tiles_of_draw(const svo_plan *plan, const svo_i_draw *draw, svo_i_tiles *tiles);
void svo_i_tiles_free(svo_i_tiles *tiles); /* one that is all zero is allowed */

#endif
