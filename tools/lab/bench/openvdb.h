/* SPDX-License-Identifier: MIT */
/* OpenVDB (https://www.openvdb.org): the same triangles at the same resolution as svocl, through
   tools::meshToVolume. */
#ifndef SVOCL_TOOLS_BENCH_OPENVDB_H
#define SVOCL_TOOLS_BENCH_OPENVDB_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Whether this program was built with OpenVDB. */
bool openvdb_is_there(void);
/* "10.0.1"; "" without it. */
const char *openvdb_version(void);

/*
 * The narrow band of unsigned distances, one voxel wide, around the triangles.
 *
 * points: three floats each, in voxels. indices: three per triangle. active_voxels: receives the number of voxels with
 * a distance; memory_bytes: the size of the grid. Returns the milliseconds it took, on all cores, below 0 on failure.
 */
double openvdb_voxelize(const float *points, size_t point_count, const uint32_t *indices, size_t triangle_count,
                        uint64_t *active_voxels, uint64_t *memory_bytes);

/*
 * The level set of a closed mesh, signed distances three voxels to each side, with everything else marked inside or
 * outside.
 *
 * points, indices: as above. depth: of the grid of 2^depth voxels per axis. inside: receives a bit per voxel, index
 * x + N y + N^2 z, which is not timed. Returns the milliseconds it took, on all cores, below 0 on failure.
 */
double openvdb_fill(const float *points, size_t point_count, const uint32_t *indices, size_t triangle_count,
                    unsigned depth, uint64_t *inside);

#ifdef __cplusplus
}
#endif

#endif
