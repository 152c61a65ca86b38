/* SPDX-License-Identifier: MIT */
/* The points of commands that ask for light: --points. */
#ifndef SVOCL_TOOLS_SUPPORT_LIGHT_POINTS_H
#define SVOCL_TOOLS_SUPPORT_LIGHT_POINTS_H

#include "support/query_table.h"
#include "svocl/mesh.h"

/* --points is missing, or reads standard input as INPUT does. Returns the exit code. */
int light_points_check(program *state);

/* Whether --points names a file, and not a number of points. */
bool light_points_are_read(const program *state);

/* Reads the file, or spreads so many points over the mesh by --seed. mesh: NULL for none. Returns the exit code. */
int light_points_make(program *state, const svo_mesh *mesh, point_table *out);

#endif
