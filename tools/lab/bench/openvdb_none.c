/* SPDX-License-Identifier: MIT */
/* Takes the place of openvdb.cpp where libopenvdb-dev is not installed. */
#include "bench/openvdb.h"

bool openvdb_is_there(void)
{
    return false;
}

const char *openvdb_version(void)
{
    return "";
}

double openvdb_voxelize(const float *points, size_t point_count, const uint32_t *indices, size_t triangle_count,
                        uint64_t *active_voxels, uint64_t *memory_bytes)
{
    (void)points;
    (void)point_count;
    (void)indices;
    (void)triangle_count;
    *active_voxels = 0;
    *memory_bytes = 0;
    return -1.0;
}

double openvdb_fill(const float *points, size_t point_count, const uint32_t *indices, size_t triangle_count,
                    unsigned depth, uint64_t *inside)
{
    (void)points;
    (void)point_count;
    (void)indices;
    (void)triangle_count;
    (void)depth;
    *inside = 0;
    return -1.0;
}
