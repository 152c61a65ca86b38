/* SPDX-License-Identifier: MIT */
/*
 * A histogram of triangles over the coarse cells of the grid: how many triangles meet each cell, of each level down to
 * one, and what they add to the fragment estimate there. So the parts of a tree are known before a triangle is written.
 * Histograms of the runs of a mesh add up to that of the mesh, as those of a sample sort do (Blelloch et al., "A
 * Comparison of Sorting Algorithms for the Connection Machine CM-2", 1991).
 */
#ifndef SVO_LIB_PARTS_CELLS_H
#define SVO_LIB_PARTS_CELLS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "svocl/part_types.h"

/* The deepest level of a histogram, and how many cells one may have: with more it loses its deepest level. */
#define CELLS_LEVEL_MAX 7u
#define CELLS_MAX       ((size_t)1 << 17)

/* Sums over triangles: their number, and the terms of the fragment estimate (plan/estimate.h). The last stops at the
   largest value, so that the order of sums does not matter. */
typedef struct svo_i_cell_sums {
    uint64_t count, widths, doubled_areas;
} svo_i_cell_sums;

typedef struct svo_i_cell {
    uint64_t key; /* code | 1 << 3 level: cells of a level lie side by side, after those above */
    svo_i_cell_sums inside; /* of triangles that lie in this cell, and in no smaller one */
    svo_i_cell_sums across; /* of triangles that meet it and others */
} svo_i_cell;

/* A triangle's place in the grid. */
typedef struct svo_i_placing {
    int32_t corners[3][3]; /* grid units */
    uint32_t first[3], last[3]; /* cells of `level` that its bounds meet */
    uint32_t level;
    uint32_t inside_level; /* of the smallest cell that has all of these */
    bool has_plane;
    double normal[3], plane; /* of its plane: normal . x = plane */
} svo_i_placing;

/* header: snap_bits and coverage. The triangle meets the grid. */
void svo_i_placing_make(const svo_part_header *header, uint32_t level, const int32_t corners[3][3],
                        svo_i_placing *placing);
/* Whether the triangle may meet a cell, none of `level` below; the same answer for whoever asks. It meets the cell
   above. Such as does may be told to; none that does is missed. */
bool svo_i_placing_meets(svo_i_placing *placing, uint32_t snap_bits, uint32_t level, const uint32_t cell[3]);

typedef struct svo_i_cells {
    svo_i_cell *slots; /* a hash table; key 0: free */
    size_t capacity, count;
    uint32_t level; /* the deepest */
} svo_i_cells;

/* false: out of memory. */
bool svo_i_cells_add(svo_i_cells *cells, uint32_t snap_bits, svo_i_placing *placing);
void svo_i_cells_free(svo_i_cells *cells);

/* A histogram as a list, sorted by key; each cell with all above it. */
typedef struct svo_i_cell_list {
    svo_i_cell *cells;
    size_t count;
    uint32_t level;
} svo_i_cell_list;

/* Takes the cells; cells is empty then. */
void svo_i_cell_list_take(svo_i_cells *cells, svo_i_cell_list *list);
/* Adds a list to another, which owns its cells. false: out of memory. */
bool svo_i_cell_list_add(svo_i_cell_list *to, const svo_i_cell_list *from);
/* Makes `inside` of each cell that of all triangles which lie in it. */
void svo_i_cell_list_total(svo_i_cell_list *list);
/* What meets a cell, of a list with totals. */
svo_i_cell_sums svo_i_cell_list_find(const svo_i_cell_list *list, uint32_t level, uint64_t code);
/* Whether the list may be one that was taken: sorted, with all cells above. */
bool svo_i_cell_list_is_whole(const svo_i_cell_list *list);

#endif
