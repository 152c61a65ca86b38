/* SPDX-License-Identifier: MIT */
/* Meshes as files of the program. */
#ifndef SVOCL_TOOLS_SUPPORT_MESH_OUTPUT_H
#define SVOCL_TOOLS_SUPPORT_MESH_OUTPUT_H

#include "support/program.h"
#include "svocl/mesh.h"

/* Writes a mesh as scenes.h describes, by the suffix in any case: .obj or PLY. An .obj file of a mesh with materials gets an .mtl file of the same name beside
   it. Returns the exit code; after a failure there is no new file. */
int mesh_output_write(program *state, const svo_mesh *mesh, const char *path);

#endif
