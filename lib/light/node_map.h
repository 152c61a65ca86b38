/* SPDX-License-Identifier: MIT */
/*
 * What another way to filter would start: the node map of Crassin et al., "Interactive Indirect Illumination Using
 * Voxel Cone Tracing", 2011. Each pixel of a light view begins with the leaf of its photon; above them, cells of 2 x 2
 * have the lowest common ancestor of theirs. An item per pixel walks up the tree, and leaves the work to the first item
 * of its cell once the cell's ancestor is at or below the level that is filtered. svocl compacts the lit nodes by a
 * scan instead; this counts, on the host, to compare.
 */
#ifndef SVO_LIB_LIGHT_NODE_MAP_H
#define SVO_LIB_LIGHT_NODE_MAP_H

#include <stdint.h>

#include "core/work.h"
#include "shared/light_layout.h"

/* A cell of the pyramid: the ancestor of its leaves. */
typedef struct svo_i_map_cell {
    uint64_t code;
    uint32_t level; /* SVO_I_MAP_EMPTY: no photon met a leaf */
} svo_i_map_cell;
#define SVO_I_MAP_EMPTY UINT32_MAX

typedef struct svo_i_node_map {
    const uint64_t *leaf_codes; /* the caller's */
    uint32_t depth;
    uint64_t items; /* of all views, for all levels above the leaves */
    svo_i_map_cell *cells; /* of a view's pixels, row by row; owned, NULL between views */
} svo_i_node_map;

/* Begins a view, takes the leaves of a launch's photons from a buffer, and ends the view, also after a failure. */
svo_status svo_i_node_map_begin(svo_i_node_map *map, svo_i_device_work *work, const svo_light_view_params *view);
svo_status svo_i_node_map_take(svo_i_node_map *map, svo_i_device_work *work, cl_mem leaves,
                               const svo_light_view_params *view);
void svo_i_node_map_end(svo_i_node_map *map, const svo_light_view_params *view);

/* The items of a picture of cells, which is lost: for each level above the leaves, the largest cells of the pyramid
   whose ancestor is at or below it. */
uint64_t svo_i_node_map_items(svo_i_map_cell *cells, uint32_t columns, uint32_t rows, uint32_t depth);

#endif
