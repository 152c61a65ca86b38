/* SPDX-License-Identifier: MIT */
/* Distance, area and volume of a set of voxels, and of the closed mesh that they represent. */
#ifndef SVOCL_TOOLS_ERRORS_DETAIL_MEASURES_H
#define SVOCL_TOOLS_ERRORS_DETAIL_MEASURES_H

#include <stdbool.h>

#include "support/session.h"

typedef struct detail_reference {
    svo_tree *tree; /* with lists, at the ray depth */
    double area, volume; /* of the snapped mesh, in double: world units */
} detail_reference;

/* mesh: closed, its triangles facing outwards. Returns false with nothing to release. */
bool detail_reference_create(const session *opened, const svo_mesh *mesh, detail_reference *out);
void detail_reference_free(detail_reference *made);

typedef struct detail_measures {
    double distance; /* the largest from a voxel's center to the surface: world units */
    double area_by_fill, area_by_faces, volume; /* world units */
} detail_measures;

/* tree: of the same mesh, downloaded, with fill. */
bool detail_measure(const detail_reference *reference, const svo_tree *tree, cl_command_queue queue,
                    detail_measures *out);

#endif
