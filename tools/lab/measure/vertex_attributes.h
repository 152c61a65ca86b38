/* SPDX-License-Identifier: MIT */
/*
 * A mesh with a color and a normal per vertex, whatever it was given with: what is missing is made. Colors are
 * positions within the bounds; normals are the sums of the triangles' normals, weighted by area.
 */
#ifndef SVOCL_TOOLS_MEASURE_VERTEX_ATTRIBUTES_H
#define SVOCL_TOOLS_MEASURE_VERTEX_ATTRIBUTES_H

#include <stdbool.h>

#include "svocl/mesh.h"

typedef struct vertex_attributes {
    svo_mesh mesh; /* positions and indices are the source's, which must outlive it; without materials */
    uint8_t *colors; /* NULL: the source's */
    float *normals; /* NULL: the source's */
} vertex_attributes;

/* Returns false, with nothing to release, when memory runs out. */
bool vertex_attributes_create(const svo_mesh *mesh, vertex_attributes *out);
void vertex_attributes_free(vertex_attributes *made);

#endif
