/* SPDX-License-Identifier: MIT */
/* NanoVDB (https://www.openvdb.org): the same voxels, and its hierarchical walk through them (HDDA). */
#ifndef SVOCL_TOOLS_BENCH_NANOVDB_H
#define SVOCL_TOOLS_BENCH_NANOVDB_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "measure/brickmap.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct nanovdb_voxels nanovdb_voxels;

/* Whether this program was built with NanoVDB. */
bool nanovdb_is_there(void);
/* "32.4.2"; "" without it. */
const char *nanovdb_version(void);

/* A grid of voxels: cells of three coordinates each. NULL on failure. */
nanovdb_voxels *nanovdb_create(const uint32_t (*cells)[3], size_t cell_count);
void nanovdb_destroy(nanovdb_voxels **voxels);
uint64_t nanovdb_bytes(const nanovdb_voxels *voxels);
/* distances: of the first voxel along each ray; infinity: none. */
void nanovdb_trace(const nanovdb_voxels *voxels, const voxel_ray *rays, float *distances, size_t ray_count);

#ifdef __cplusplus
}
#endif

#endif
