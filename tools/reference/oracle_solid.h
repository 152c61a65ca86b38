/* SPDX-License-Identifier: MIT */
/*
 * The exact reference for solids: which voxel centers lie inside a snapped mesh, for every voxel of a dense grid, along
 * each axis by itself. It shares no code and no method with the library: a point on the projection of an edge is moved
 * by an infinitesimal amount, and heights are divided, in 128-bit integers.
 *
 * Thread-safety: as oracle.h.
 */
#ifndef SVOCL_TOOLS_REFERENCE_ORACLE_SOLID_H
#define SVOCL_TOOLS_REFERENCE_ORACLE_SOLID_H

#include "oracle.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum oracle_rule {
    ORACLE_WINDING = 0, /* inside where the sum of signed crossings above is not 0 */
    ORACLE_PARITY = 1 /* inside where it is odd */
} oracle_rule;

/* Every voxel of the grid. Release it by oracle_solid_free. */
typedef struct oracle_solid {
    unsigned depth;
    uint64_t *inside[3]; /* along x, y, z: a bit per voxel, index x + N y + N^2 z, N = 2^depth */
    uint64_t open_columns[3]; /* columns of voxels in which the crossings do not cancel */
} oracle_solid;

/*
 * depth: 1 .. 10; snap_bits: depth + 1 .. 24. Vertices may lie outside the grid, less than 2^29 units away. Returns
 * false, with *out empty, if memory runs out or the request is out of range; method and coverage are not read.
 */
bool oracle_solid_make(const oracle_mesh *mesh, const oracle_request *request, oracle_rule rule, oracle_solid *out);
void oracle_solid_free(oracle_solid *solid);

/* For how many of the three axes a voxel is inside. */
unsigned oracle_solid_votes(const oracle_solid *solid, uint32_t x, uint32_t y, uint32_t z);

#ifdef __cplusplus
}
#endif

#endif
