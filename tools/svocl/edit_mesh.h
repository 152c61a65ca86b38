/* SPDX-License-Identifier: MIT */
/* Closed meshes in scripts of svocl edit: placed, filled by the rules of svo_solid, and turned into voxels. */
#ifndef SVOCL_TOOLS_SVOCL_EDIT_MESH_H
#define SVOCL_TOOLS_SVOCL_EDIT_MESH_H

#include "support/session.h"
#include "svocl/edit_script.h"

/*
 * Makes the voxels of a step's mesh, in the coordinates of the edit. Without a color in the step those that the surface
 * passes through have the mesh's colors, and the others are white.
 *
 * opened: is opened here where it is not yet; the caller closes it. Returns the exit code.
 */
int edit_mesh_make(program *state, const edit_script *script, const script_step *step, session *opened,
                   svo_voxels **out);

#endif
