/* SPDX-License-Identifier: MIT */
/* Takes the place of nanovdb.cpp where libnanovdb-dev is not installed. */
#include "bench/nanovdb.h"

bool nanovdb_is_there(void)
{
    return false;
}

const char *nanovdb_version(void)
{
    return "";
}

nanovdb_voxels *nanovdb_create(const uint32_t (*cells)[3], size_t cell_count)
{
    (void)cells;
    (void)cell_count;
    return NULL;
}

void nanovdb_destroy(nanovdb_voxels **voxels)
{
    (void)voxels;
}

uint64_t nanovdb_bytes(const nanovdb_voxels *voxels)
{
    (void)voxels;
    return 0;
}

void nanovdb_trace(const nanovdb_voxels *voxels, const voxel_ray *rays, float *distances, size_t ray_count)
{
    (void)voxels;
    (void)rays;
    for (size_t i = 0; i < ray_count; ++i) {
        distances[i] = 0.0F;
    }
}
