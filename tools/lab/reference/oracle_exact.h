/* SPDX-License-Identifier: MIT */
/*
 * The exact reference of meshes as they were given: which voxels a triangle covers when its vertices are exactly the
 * doubles of the caller, and so are the numbers of the grid. oracle.h decides the same of snapped meshes.
 *
 * Again two unrelated methods: separating axes in integers (oracle_exact.c), and clipping in fractions
 * (oracle_exact_clip.c). Numbers are of any size, by GMP, which ends the process when memory runs out.
 *
 * Thread-safety: no state; every function may run on several threads at once.
 */
#ifndef SVOCL_TOOLS_REFERENCE_ORACLE_EXACT_H
#define SVOCL_TOOLS_REFERENCE_ORACLE_EXACT_H

#include "oracle.h"
#include "oracle_solid.h"

#ifdef __cplusplus
extern "C" {
#endif

#define ORACLE_OFFSET_BITS     74
#define ORACLE_EXACT_DEPTH_MAX 20

/*
 * A grid of 2^depth voxels per axis. Plane i of an axis is where v - origin = i * edge / 2^depth, in real arithmetic.
 * An offset v - origin is exact down to 2^-ORACLE_OFFSET_BITS of the power of two above the edge; what lies below is
 * rounded to odd (Boldo and Melquiond, 2008), so that no vertex reaches, crosses or leaves a plane. All values are
 * finite, edge above 0. depth: 0 .. ORACLE_EXACT_DEPTH_MAX.
 */
typedef struct oracle_space {
    double origin[3];
    double edge;
    unsigned depth;
} oracle_space;

/* Vertex, then axis; finite. Segments and points are triangles too. */
typedef struct oracle_exact_triangle {
    double vertices[3][3];
} oracle_exact_triangle;

/* Whether the closed triangle meets the voxel of the given cell, of any integers below 2^30. The two agree. */
bool oracle_exact_touches(const oracle_exact_triangle *triangle, const oracle_space *space, const int32_t cell[3],
                          oracle_coverage coverage);
bool oracle_exact_clip_touches(const oracle_exact_triangle *triangle, const oracle_space *space, const int32_t cell[3],
                               oracle_coverage coverage);

/* (vertex - origin) * 2^bits / edge, in real arithmetic, rounded to the nearest integer, ties to the even one. That
   integer is below 2^63. */
int64_t oracle_exact_rounded(double vertex, double origin, double edge, unsigned bits);

/*
 * Every (voxel, triangle) pair of the accepted triangles of a mesh, sorted; triangles are known by their index. Decides
 * what doubles cannot get wrong in doubles, and the rest as oracle_exact_touches does. Returns false, with *out empty,
 * if memory runs out or the space is out of range. Release the pairs by oracle_pairs_free.
 */
bool oracle_exact_enumerate(const oracle_positions *mesh, const oracle_space *space, oracle_coverage coverage,
                            oracle_pairs *out);

/* Those whose voxels are below one node of the octree: its level, at most the depth, and its code, below 8^level. */
bool oracle_exact_enumerate_below(const oracle_positions *mesh, const oracle_space *space, oracle_coverage coverage,
                                  unsigned level, uint64_t code, oracle_pairs *out);

/*
 * The line along an axis through the center of a cell, moved as in oracle_solid.c: the sense in which it crosses a
 * triangle, 1 from behind to the front, -1 the other way, 0 not at all. *half_voxels: unless 0, the height of the
 * crossing above the grid's first plane in halves of voxels, rounded down and clamped to 2^40.
 */
int oracle_exact_crossing(const oracle_exact_triangle *triangle, const oracle_space *space, unsigned axis,
                          const int32_t cell[3], int64_t *half_voxels);

/*
 * Every voxel of the grid, as oracle_solid_make does it for a snapped mesh, by the accepted triangles. depth: 1 .. 10.
 * Returns false, with *out empty, if memory runs out or the depth is out of range. Release it by oracle_solid_free.
 */
bool oracle_exact_solid_make(const oracle_positions *mesh, const oracle_space *space, oracle_rule rule,
                             oracle_solid *out);

#ifdef __cplusplus
}
#endif

#endif
