/* SPDX-License-Identifier: MIT */
/* .nvdb files by NanoVDB's own reader, validator and builder. */
#ifndef SVOCL_TESTS_NVDB_PEER_H
#define SVOCL_TESTS_NVDB_PEER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct nvdb_voxel {
    int32_t at[3];
    uint8_t rgba[4];
    uint32_t material;
    double center[3]; /* in the world */
} nvdb_voxel;

/* What NanoVDB makes. */
typedef enum nvdb_kind {
    NVDB_SPHERE_FLOAT, /* level sets of a sphere that fills tiles, by type of value */
    NVDB_SPHERE_DOUBLE,
    NVDB_SPHERE_FP8,
    NVDB_SPHERE_FP16,
    NVDB_FOG, /* a fog volume of a sphere with active tiles */
    NVDB_COLORS, /* "density" and "Cd", in linear light, and a third grid */
    NVDB_KINDS
} nvdb_kind;

/* The active voxels of the first grid of a file, by malloc, with the values of its grids "color" and "material", white
   and 0 without them. Returns NULL if all grids are valid, else why not. */
const char *nvdb_peer_read(const char *path, nvdb_voxel **voxels, size_t *count);

/* What a level set "surface" has at a place. */
typedef struct nvdb_distance {
    float value;
    int is_active;
} nvdb_distance;

/* The values of a level set of floats at all places from 0 to side - 1 along each axis, x + side (y + side z), and
   where place 0, 0, 0 is in the world. Returns NULL if the grid is valid, else why not. */
const char *nvdb_peer_read_surface(const char *path, int side, nvdb_distance *values, double center[3]);

/* Writes a file of a kind. voxels: those that a reader should find, by malloc, by a search with NanoVDB's accessors. */
void nvdb_peer_write(const char *path, nvdb_kind kind, nvdb_voxel **voxels, size_t *count);

#ifdef __cplusplus
}
#endif

#endif
