/* SPDX-License-Identifier: MIT */
/*
 * A brickmap, as renderers of voxels write it by themselves: a dense grid of bricks of 8^3 voxels, a bit per voxel, and
 * a scalar walk from cell to cell through both (Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing",
 * 1987).
 */
#ifndef SVOCL_TOOLS_MEASURE_BRICKMAP_H
#define SVOCL_TOOLS_MEASURE_BRICKMAP_H

#include <stddef.h>
#include <stdint.h>

#define BRICKMAP_DEPTH_MIN 3

/* A ray in units of voxels, from the grid's corner. */
typedef struct voxel_ray {
    float origin[3], direction[3]; /* direction: of length 1 */
    float range; /* from the origin */
} voxel_ray;

/* Functions of peers that are compiled for the processor that runs them, as OpenCL's kernels are. */
#if defined(__x86_64__) && defined(__GNUC__) && __GNUC__ >= 12 && !defined(__clang__)
#define BRICKMAP_ALL_ISAS __attribute__((flatten, target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#else
#define BRICKMAP_ALL_ISAS
#endif

typedef struct brickmap brickmap;

/* codes: Morton codes of the voxels, ascending. depth: BRICKMAP_DEPTH_MIN at least. NULL: out of memory. */
brickmap *brickmap_create(const uint64_t *codes, size_t code_count, unsigned depth);
void brickmap_destroy(brickmap **map);
uint64_t brickmap_bytes(const brickmap *map);
/* distances: of the first voxel along each ray; infinity: none. */
void brickmap_trace(const brickmap *map, const voxel_ray *rays, float *distances, size_t ray_count);

#endif
