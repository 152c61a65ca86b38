/* SPDX-License-Identifier: MIT */
/* The part of the grid that a tree occupies, as far as its upper levels show it. */
#ifndef SVO_LIB_RAYS_BOUNDS_H
#define SVO_LIB_RAYS_BOUNDS_H

#include "svocl/tree.h"

/* A box of cells on one level, of which the grid has so many along each axis. */
typedef struct svo_i_cell_bounds {
    uint32_t cells;
    uint32_t low[3], high[3]; /* high: one past the last cell */
} svo_i_cell_bounds;

/* How many inner nodes svo_i_occupied_cells reads, the first ones. */
uint64_t svo_i_bounds_nodes(const svo_tree_info *info);

/* The occupied cells of that level; all of them without arrays or leaves. */
void svo_i_occupied_cells(const svo_tree_info *info, const uint8_t *child_mask, const uint32_t *first_child,
                          svo_i_cell_bounds *out);

#endif
