/* SPDX-License-Identifier: MIT */
/*
 * The usual ways to voxelize, in float32, to show beside the exact one: the same snapped triangles, brought back to
 * world coordinates and rounded to float. The rasterized ways follow the rules of the hardware (pixel centers or the
 * standard four samples, positions snapped to 1/256 pixel, top-left rule) on the host: it is the rule that is measured,
 * no GPU.
 */
#ifndef SVOCL_TOOLS_STRESS_FLOAT_METHODS_H
#define SVOCL_TOOLS_STRESS_FLOAT_METHODS_H

#include "reference/oracle.h"
#include "svocl/tree.h"

typedef enum float_method {
    FLOAT_PLANES = 0, /* Schwarz and Seidel, planes and projected edges in world coordinates */
    FLOAT_CENTERED, /* Akenine-Moller, separating axes around the box's center */
    FLOAT_PIXELS, /* rasterization, one sample per pixel */
    FLOAT_SAMPLES, /* rasterization, four samples per pixel */
    FLOAT_EXPANDED, /* rasterization of the expanded triangle, every voxel of the depth range */
    FLOAT_METHOD_COUNT
} float_method;

const char *float_method_name(float_method method); /* static string */
/* The voxels the way aims at: the separating axes see closed boxes, pixels own half of their border. */
oracle_coverage float_method_coverage(float_method method);

/* A list of pairs that grows. */
typedef struct float_list {
    oracle_pair *pairs;
    size_t count, capacity;
    bool failed; /* out of memory */
} float_list;

/* One triangle in world coordinates, the grid as floats, and the voxels that are worth asking (the exact bounds and one
   voxel more on either side). */
typedef struct float_triangle {
    float vertex[3][3];
    float origin[3];
    float voxel; /* edge of a voxel */
    int first[3], last[3];
    unsigned depth;
    uint32_t id;
} float_triangle;

void float_list_add(float_list *list, const float_triangle *triangle, int x, int y, int z);

/* Appends the pairs of triangles begin .. end - 1 of a tree, in no order, some of them twice; info, arrays: of a
   downloaded tree with lists. */
void float_method_list(float_method method, const svo_tree_info *info, const svo_tree_arrays *arrays, uint64_t begin,
                       uint64_t end, float_list *list);
/* The list in order, without doubles: its array becomes that of out and is released by oracle_pairs_free. Returns
   false, with both empty, when memory runs out. */
bool float_method_sort(float_list *list, oracle_pairs *out);

/* Both, for all triangles. */
bool float_method_run(float_method method, const svo_tree_info *info, const svo_tree_arrays *arrays, oracle_pairs *out);

#endif
