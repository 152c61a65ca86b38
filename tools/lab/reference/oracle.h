/* SPDX-License-Identifier: MIT */
/*
 * The exact references: which voxels a snapped triangle covers, the resulting octree, and how positions snap.
 *
 * Nothing here is part of the library or shares code with it: the tests and `svocl verify` compare the library with
 * these functions. The triangle-box test exists twice, by two unrelated methods (oracle_sat.c: no separating plane
 * exists; oracle_clip.c: the clipped polygon has points), so that a mistake in one shows against the other. All
 * arithmetic is on integers wide enough to be exact.
 *
 * Thread-safety: no state; every function may run on several threads at once.
 */
#ifndef SVOCL_TOOLS_REFERENCE_ORACLE_H
#define SVOCL_TOOLS_REFERENCE_ORACLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Which of its faces a voxel owns. */
typedef enum oracle_coverage {
    ORACLE_HALF_OPEN = 0, /* [x, x+1)^3: the far faces belong to the neighbors */
    ORACLE_CLOSED = 1, /* [x, x+1]^3 */
    ORACLE_THIN = 2 /* 6-separating, a subset of half-open; upper levels are the ancestors of the voxels */
} oracle_coverage;

/* Vertex, then axis; in snapped units, absolute value below 2^30. Segments and points are triangles too. */
typedef struct oracle_triangle {
    int32_t vertex[3][3];
} oracle_triangle;

/* The cube from corner to corner + width, in snapped units: |corner| below 2^30, width 1 .. 2^30. */
typedef struct oracle_box {
    int64_t corner[3];
    int64_t width;
} oracle_box;

/* Whether the closed triangle meets the box. The two agree for all input within the ranges above. */
bool oracle_sat_touches(const oracle_triangle *triangle, const oracle_box *box, oracle_coverage coverage);
bool oracle_clip_touches(const oracle_triangle *triangle, const oracle_box *box, oracle_coverage coverage);

/* In double precision: the area of the triangle inside a box of the given width, in box faces, and the centroid of that
   part; without area, the center of the box. Positions are from the corner of the box, in any unit. */
double oracle_part(const double triangle[3][3], double width, double centroid[3]);
/* The barycentric weights of a point of the triangle, projected along the dominant axis. Points beside the projected
   triangle are clamped to its border; without area the weights are thirds. */
void oracle_corner_weights(const double triangle[3][3], const double at[3], double weights[3]);

/* A snapped mesh: borrowed arrays. A triangle with a coordinate of 2^29 and more touches nothing (it is refused). */
typedef struct oracle_mesh {
    const int32_t *vertices; /* x, y, z per vertex */
    const uint32_t *indices; /* three per triangle, all valid; NULL: vertices 3t, 3t + 1, 3t + 2 */
    const uint32_t *triangle_ids; /* the id of triangle t in pairs; NULL: t */
    size_t triangle_count;
} oracle_mesh;

/* Morton codes: bit 0 of each 3-bit digit is x, bit 1 y, bit 2 z; the most significant digit is the root's octant. */
typedef struct oracle_pair {
    uint64_t code;
    uint32_t triangle;
} oracle_pair;

/* An array allocated by malloc, sorted by code, then triangle. Release it by oracle_pairs_free. */
typedef struct oracle_pairs {
    oracle_pair *pairs;
    size_t count;
} oracle_pairs;

typedef enum oracle_method { ORACLE_SAT = 0, ORACLE_CLIP = 1 } oracle_method;

#define ORACLE_DEPTH_MAX  16
#define ORACLE_LEVELS_MAX (ORACLE_DEPTH_MAX + 2)

/* The grid is the cube [0, 2^snap_bits) of 2^depth voxels per axis. depth 0 .. 16, snap_bits depth .. 24. */
typedef struct oracle_request {
    unsigned depth;
    unsigned snap_bits;
    oracle_coverage coverage;
    oracle_method method;
} oracle_request;

/* The box of the voxel with the given code, and the code of the voxel (x, y, z). */
void oracle_voxel_box(uint64_t code, unsigned depth, unsigned snap_bits, oracle_box *box);
uint64_t oracle_voxel_code(uint32_t x, uint32_t y, uint32_t z, unsigned depth);

/*
 * Every (voxel, triangle) pair of the mesh. Traverses the octree from the root, which is exact because a covered voxel
 * has a covered parent. Returns false, with *out empty, if memory runs out or the request is out of range.
 */
bool oracle_enumerate(const oracle_mesh *mesh, const oracle_request *request, oracle_pairs *out);
void oracle_pairs_free(oracle_pairs *pairs);

/* Sorts by code, then triangle, in linear time. Returns false, and changes nothing, when memory runs out. */
bool oracle_pairs_sort(oracle_pair *pairs, size_t count);

/* Distinct codes of a sorted list. */
uint64_t oracle_pairs_voxel_count(const oracle_pairs *pairs);

typedef struct oracle_difference {
    uint64_t missed_voxels; /* expected, but missing */
    uint64_t surplus_voxels; /* present, but not expected */
    uint64_t missed_pairs;
    uint64_t surplus_pairs; /* a duplicated pair is surplus once */
} oracle_difference;

/* Compares two sorted lists. */
void oracle_compare(const oracle_pairs *expected, const oracle_pairs *actual, oracle_difference *difference);

/* The canonical tree: breadth-first, in Morton order inside each level, element by element what the library builds. */
typedef struct oracle_tree {
    unsigned depth;
    uint32_t level_begin[ORACLE_LEVELS_MAX]; /* nodes of level l: level_begin[l] .. level_begin[l + 1]; then zeros */
    uint32_t node_count;
    uint32_t inner_count;
    uint8_t *child_mask; /* inner_count */
    uint32_t *first_child; /* inner_count; counted on where the mask is 0 */
} oracle_tree;

/* Builds the tree of a sorted list; an empty list gives a root with mask 0 and no leaves. Release it by
   oracle_tree_free. Returns false, with *out empty, if memory runs out or the nodes do not fit 32 bits. */
bool oracle_tree_make(const oracle_pairs *pairs, unsigned depth, oracle_tree *out);
void oracle_tree_free(oracle_tree *tree);

/*
 * The inverse: the Morton codes of the leaves of a tree in canonical order, in that order.
 *
 * child_mask: inner_count masks. codes: room for leaf_count codes, may be NULL without leaves. Returns false if the
 * masks do not describe a tree of that depth with that many inner nodes and leaves.
 */
bool oracle_leaf_codes(const uint8_t *child_mask, uint64_t inner_count, unsigned depth, uint64_t leaf_count,
                       uint64_t *codes);

/* World to grid: s = (v - origin) * 2^snap_bits / edge, in real arithmetic, rounded to odd: a whole s is kept, any
   other becomes the odd one of the two whole numbers around it. */
typedef struct oracle_grid {
    double origin[3];
    double edge;
    double scale; /* 2^snap_bits / edge, rounded to double */
    unsigned snap_bits;
} oracle_grid;

/* Unsnapped triangles: borrowed arrays. */
typedef struct oracle_positions {
    const double *positions; /* x, y, z per vertex; any values */
    size_t vertex_count;
    const uint32_t *indices; /* three per triangle; NULL: vertices 3t, 3t + 1, 3t + 2 */
    size_t triangle_count;
} oracle_positions;

/* The vertex indices of triangle t, and whether it is accepted: its indices are in range and its vertices finite. */
bool oracle_triangle_accepted(const oracle_positions *mesh, size_t triangle_index, uint32_t vertex_indices[3]);

/* The default grid of the accepted triangles. Returns false if there are none, or if edge or scale leave the range
   of normal doubles. snap_bits: 1 .. 24. */
bool oracle_grid_fit(const oracle_positions *mesh, unsigned snap_bits, oracle_grid *grid);

/* The caller's grid. Returns false if origin, edge or scale leave the range of normal doubles. */
bool oracle_grid_given(const double origin[3], double edge, unsigned snap_bits, oracle_grid *grid);

/* Snaps one finite position, exactly. Returns false, without writing snapped, if a coordinate is 2^29 or more. */
bool oracle_snap(const oracle_grid *grid, const double position[3], int32_t snapped[3]);

#ifdef __cplusplus
}
#endif

#endif
