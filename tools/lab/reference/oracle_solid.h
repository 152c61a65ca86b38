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

/* The sum of signed crossings of the line from a point, in grid units, in direction +axis: by all triangles, without a
   grid. The point lies on no triangle. */
int64_t oracle_point_winding(const oracle_mesh *mesh, unsigned axis, const int64_t at[3]);

/* The level of the leaf that holds each voxel, index as in oracle_solid; this where there is none. */
#define ORACLE_NO_LEAF 255

/*
 * Decodes the words of a descriptor form: svocl/compact.h. levels: 8^depth bytes, set throughout. Returns false where a
 * word leads outside, an inner node lies on level depth, or cells overlap.
 */
bool oracle_descriptor_levels(const uint32_t *words, size_t word_count, unsigned depth, uint8_t *levels);

/* A solid beside the reference. */
typedef struct oracle_solid_difference {
    uint64_t surface_voxels; /* leaves of the built tree */
    uint64_t inside_leaves, inside_voxels; /* empty cells of the built tree that are inside, and their voxels */
    uint64_t ambiguous_cells, ambiguous_voxels; /* empty cells whose axes disagree */
    uint64_t wrong_voxels; /* not held by the leaf that the reference says, if by any */
    uint64_t split_voxels; /* of empty cells: voxels that lie on the other side than the one that decides */
} oracle_solid_difference;

/*
 * Compares a solid, by the levels of its leaves, with the reference: the leaves of the built tree, and each of its
 * empty cells that is inside by two of three axes, as one leaf. The voxel in the middle of a cell, or after its
 * middle, decides.
 *
 * child_mask, first_child: of the built tree.
 */
void oracle_solid_compare(const oracle_solid *reference, const uint8_t *child_mask, const uint32_t *first_child,
                          const uint8_t *levels, oracle_solid_difference *out);

#ifdef __cplusplus
}
#endif

#endif
