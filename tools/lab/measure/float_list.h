/* SPDX-License-Identifier: MIT */
/* Input and output of the float32 methods: a triangle in world coordinates, and a list of pairs. */
#ifndef SVOCL_TOOLS_MEASURE_FLOAT_LIST_H
#define SVOCL_TOOLS_MEASURE_FLOAT_LIST_H

#include "reference/oracle.h"

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

/* One triangle in world coordinates, the grid as floats, and the voxels to test: the exact bounds and one more voxel
   on each side. */
typedef struct float_triangle {
    float vertex[3][3];
    float origin[3];
    float voxel; /* edge of a voxel */
    int first[3], last[3];
    unsigned depth;
    uint32_t id;
} float_triangle;

void float_list_add(float_list *list, const float_triangle *triangle, int x, int y, int z);

#endif
