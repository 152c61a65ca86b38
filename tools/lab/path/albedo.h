/* SPDX-License-Identifier: MIT */
/* What a mesh's surface does with light, by its own colors. */
#ifndef SVOCL_TOOLS_PATH_ALBEDO_H
#define SVOCL_TOOLS_PATH_ALBEDO_H

#include <stdbool.h>
#include <stdint.h>

#include "svocl/light.h"
#include "svocl/mesh.h"

#define PATH_CLAY 0.6 /* albedo of meshes without colors */

/* Linear red, green and blue of the triangle at barycentric weights u and v: vertex color, base color and texel, each
   decoded from sRGB after they are multiplied. Returns alpha, 0 .. 1. */
double path_albedo(const svo_mesh *mesh, uint32_t triangle, double u, double v, double albedo[3]);

/* Radiance that the triangle emits. */
void path_emission(const svo_mesh *mesh, const svo_light_setup *setup, uint32_t triangle, double emission[3]);

/* Whether something of the mesh may show in part. */
bool path_is_clear(const svo_mesh *mesh);

#endif
