/* SPDX-License-Identifier: MIT */
/* Meshes whose condition worsens with one number: thinner triangles, farther from the origin, smaller in their grid. */
#ifndef SVOCL_TOOLS_ERRORS_ILL_CONDITIONED_MESHES_H
#define SVOCL_TOOLS_ERRORS_ILL_CONDITIONED_MESHES_H

#include <stdbool.h>

#include "measure/triangle_sets.h"

typedef enum conditioning {
    CONDITIONING_ASPECT = 0, /* longest edge over height */
    CONDITIONING_OFFSET, /* distance from the origin of coordinates over the mesh's width */
    /* width of the grid over that of a triangle; for rays: distance of their origins over the mesh's width */
    CONDITIONING_SCALE,
    CONDITIONING_COUNT
} conditioning;
const char *conditioning_name(conditioning family); /* static string */

/* Triangles for voxelization, inside the unit cube or, for an offset, that far from it. triangle_count: at least 2.
   Returns false when out of memory. Released by triangle_set_free. */
bool ill_conditioned_triangles(conditioning family, double value, size_t triangle_count, triangle_set *out);

/* A closed mesh's positions in double, flattened along y or moved along all axes. out: vertex_count * 3. */
void ill_conditioned_positions(const svo_mesh *mesh, conditioning family, double value, double *out);

#endif
