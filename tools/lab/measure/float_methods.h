/* SPDX-License-Identifier: MIT */
/*
 * Common float32 voxelization methods, compared with the exact one. They take the caller's own vertices, doubles
 * rounded to float, and are compared with the exact voxels of those (mesh_list_pairs). The rasterizing methods apply
 * the rules of the hardware on the host (pixel centers or the standard four samples, positions snapped to 1/256 pixel,
 * top-left rule): the rule is measured, not a GPU.
 */
#ifndef SVOCL_TOOLS_MEASURE_FLOAT_METHODS_H
#define SVOCL_TOOLS_MEASURE_FLOAT_METHODS_H

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

/* A list of pairs that grows. */
typedef struct float_list {
    oracle_pair *pairs;
    size_t count, capacity;
    bool failed; /* out of memory */
} float_list;

const char *float_method_name(float_method method); /* static string */
/* The coverage that the method targets: separating axes test closed boxes, pixels own half of their border. */
oracle_coverage float_method_coverage(float_method method);

/* Appends the pairs of triangles begin .. end - 1 of a tree, unordered, some of them twice. info, arrays: of a
   downloaded tree with lists. */
void float_method_list(float_method method, const svo_tree_info *info, const svo_tree_arrays *arrays, uint64_t begin,
                       uint64_t end, float_list *list);
/* Sorts the list and removes duplicates. out takes over its array, to be released by oracle_pairs_free. Returns
   false, with both empty, if memory runs out. */
bool float_method_sort(float_list *list, oracle_pairs *out);

/* Both steps for all triangles. */
bool float_method_run(float_method method, const svo_tree_info *info, const svo_tree_arrays *arrays, oracle_pairs *out);

#endif
