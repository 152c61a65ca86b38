/* SPDX-License-Identifier: MIT */
/* A mesh with integer coordinates, for comparisons with other libraries: all get the same bits for each vertex. */
#ifndef SVOCL_TOOLS_MEASURE_QUANTIZATION_H
#define SVOCL_TOOLS_MEASURE_QUANTIZATION_H

#include "svocl/mesh.h"

#define QUANTIZATION_MAX 1048575.0 /* 2^20 - 1: grid units are world units then */

/* A coordinate of the mesh, whose positions are float or double. index: 3 * vertex + axis. */
double quantization_source(const svo_mesh *mesh, size_t index);

/* x, y, z of every vertex, translated and scaled to integers 0 .. QUANTIZATION_MAX; coordinates that are not finite
   stay so. By malloc; NULL when out of memory. */
float *quantization_positions(const svo_mesh *mesh);

/* The same triangles with these positions, without attributes. Borrows both. */
svo_mesh quantization_mesh(const svo_mesh *mesh, const float *positions);

#endif
