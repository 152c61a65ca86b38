/* SPDX-License-Identifier: MIT */
/* Turns an implicit surface into a closed triangle mesh. */
#ifndef SVOCL_TOOLS_SCENES_POLYGONIZE_H
#define SVOCL_TOOLS_SCENES_POLYGONIZE_H

#include "builder.h"

/* A solid: negative inside, and the surface stays clear of the box [low, high]. */
typedef struct implicit_solid {
    double (*field)(const void *context, vector3 position);
    vector3 (*color)(const void *context, vector3 position);
    const void *context;
    vector3 low, high;
    double steepness; /* Lipschitz bound of the field: its change per unit of length */
} implicit_solid;

/*
 * Adds the surface, polygonized on a lattice of the given cell width. The mesh is closed, every edge has exactly two
 * triangles, and normals are the field's gradient.
 */
void polygonize(scene_builder *builder, const implicit_solid *solid, double cell_width);
/* The same with a cell width that comes close to the requested triangle count. */
void polygonize_to_count(scene_builder *builder, const implicit_solid *solid, uint32_t triangles);

#endif
