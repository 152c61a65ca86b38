/* SPDX-License-Identifier: MIT */
/* Points that are summed up by the voxel they are in: blocks of them are sorted, and what they sum up to is merged. */
#ifndef SVO_LIB_IO_POINTS_CELLS_H
#define SVO_LIB_IO_POINTS_CELLS_H

#include "core/memory.h"

#define CELL_RUNS_MAX 64

/* A voxel with points. */
typedef struct point_cell {
    uint64_t code; /* Morton code of its place */
    uint64_t sums[3]; /* of the channels of its points, each below 2^16 */
    uint64_t count; /* of its points, at most SVO_POINTS_MAX: no sum overflows */
} point_cell;

/* A point in its voxel. */
typedef struct placed_point {
    uint64_t code;
    uint16_t channels[3];
    uint16_t unused;
} placed_point;

/* Cells in the order of their codes, each once. */
typedef struct cell_run {
    point_cell *cells; /* by svo_i_alloc */
    size_t count;
} cell_run;

/* What a voxel takes while it is read: its cell in three runs at most, and in what they are merged to. */
#define CELL_BYTES (4 * sizeof(point_cell))
/* What a point of a block takes: twice in the block, and as a cell. */
#define BLOCK_POINT_BYTES (2 * sizeof(placed_point) + sizeof(point_cell))

typedef struct cell_set {
    const svo_i_memory *memory;
    uint32_t bits; /* codes are below 2^bits */
    size_t cells_max; /* more are refused */
    cell_run runs[CELL_RUNS_MAX]; /* each at least twice as long as the next */
    size_t run_count;
    placed_point *block, *spare; /* block_points each */
    size_t block_points, filled;
    bool too_many; /* why a call failed: more than cells_max; else memory ran out */
} cell_set;

/* Begins an empty set, of which memory, bits, cells_max and block_points are filled in. The functions return false on
   failure; svo_i_point_cells_end releases what the set holds, also then. */
bool svo_i_point_cells_begin(cell_set *set);
bool svo_i_point_cells_add(cell_set *set, const placed_point *point);
/* After the last point: all cells are in runs[0], or run_count is 0. */
bool svo_i_point_cells_finish(cell_set *set);
void svo_i_point_cells_end(cell_set *set);

#endif
