/* SPDX-License-Identifier: MIT */
/* Rays against a tree's leaf lists in a grid of two levels, without the tree, by the kernel of grid_rays.cl. */
#ifndef SVOCL_TOOLS_BENCH_GRID_RAYS_H
#define SVOCL_TOOLS_BENCH_GRID_RAYS_H

#include <stddef.h>

#include "support/session.h"

typedef struct grid_rays grid_rays;

/* The array of bricks is dense: 64 MiB at this depth. */
#define GRID_RAYS_DEPTH_MAX 11

/* tree: downloaded and on the device, with SVO_NEED_RAYS and a depth up to GRID_RAYS_DEPTH_MAX; it must outlive the
   grid, which uses its lists, vertices and indices. NULL on failure. */
grid_rays *grid_rays_create(const session *opened, const svo_tree *tree);
void grid_rays_destroy(grid_rays **grid);

/* Bytes of bricks and cells. */
uint64_t grid_rays_cell_bytes(const grid_rays *grid);
/* The same, and the tree's arrays that the kernel reads. */
uint64_t grid_rays_bytes(const grid_rays *grid);

/* Closest hits, without normals; triangles are counted without refused ones. Returns the milliseconds from the call to
   completion, below 0 on failure. */
double grid_rays_trace(const grid_rays *grid, cl_mem rays, cl_mem hits, size_t ray_count);

#endif
