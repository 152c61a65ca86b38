/* SPDX-License-Identifier: MIT */
/* A mesh on whole numbers, for comparing with other libraries: every side gets the same bits for every vertex. */
#ifndef SVOCL_TOOLS_MEASURE_QUANTIZATION_H
#define SVOCL_TOOLS_MEASURE_QUANTIZATION_H

#include "svocl/mesh.h"

#define QUANTIZATION_MAX 1048575.0 /* 2^20 - 1: grid units are world units then */

/* A coordinate of the mesh, in whichever precision it has them; index: 3 * vertex + axis. */
double quantization_source(const svo_mesh *mesh, size_t index);

/* x, y, z of every vertex, moved and scaled to whole numbers 0 .. QUANTIZATION_MAX; what is not finite stays so. By
   malloc; NULL when out of memory. */
float *quantization_positions(const svo_mesh *mesh);

/* The same triangles on such positions, without attributes. Borrows both. */
svo_mesh quantization_mesh(const svo_mesh *mesh, const float *positions);

#endif
