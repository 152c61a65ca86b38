/* SPDX-License-Identifier: MIT */
/* Errors of colors and normals of leaves, against the means over the surface in them. */
#ifndef SVOCL_TOOLS_TUNE_PAYLOAD_ERRORS_H
#define SVOCL_TOOLS_TUNE_PAYLOAD_ERRORS_H

#include "svocl/svocl.h"
#include "tune/measures.h"

/* tree: downloaded, with colors and normals as the mesh has them. lists: of the same depth, with leaf lists; may be the
   same tree. Colors are means of linear light, weighed by area and alpha, each part of a triangle in an eighth of a
   voxel sampled at its centroid; normals are means of unit normals, weighed by area. */
void payload_errors_add(const svo_mesh *mesh, const svo_tree *tree, const svo_tree *lists, size_t count, uint32_t seed,
                        tune_errors *errors);

#endif
