/* SPDX-License-Identifier: MIT */
/* Meshes that get stiffer by one number: thinner triangles, farther from the origin, smaller in their grid. */
#ifndef SVOCL_STIFF_MESHES_H
#define SVOCL_STIFF_MESHES_H

#include <stdbool.h>

#include "stress/stress_mesh.h"

typedef enum stiffness {
    STIFF_ASPECT = 0, /* longest edge over height */
    STIFF_OFFSET, /* distance from the origin of coordinates over the mesh's width */
    STIFF_SCALE, /* width of the grid over that of a triangle; for rays: distance of their origins over the mesh's width */
    STIFFNESS_COUNT
} stiffness;
const char *stiffness_name(stiffness family); /* static string */

/* At least two triangles inside the unit cube (offset: so far from it), for voxelization. false: out of memory. Released by
   stress_mesh_free. */
bool stiff_triangles(stiffness family, double value, size_t triangle_count, stress_mesh *out);

/* A closed mesh's positions as doubles, made so: flattened along y, or moved along all axes. out: vertex_count * 3. */
void stiff_positions(const svo_mesh *mesh, stiffness family, double value, double *out);

#endif
