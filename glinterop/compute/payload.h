/* SPDX-License-Identifier: MIT */
/* The payload of a tree by compute shaders: materials, projected areas, colors, normals and fills of nodes. */
#ifndef SVO_GLINTEROP_COMPUTE_PAYLOAD_H
#define SVO_GLINTEROP_COMPUTE_PAYLOAD_H

#include "compute/compute.h"

/* The mesh's attributes in storage blocks. 0 for an attribute that the plan does not have. */
typedef struct svo_i_gl_surface {
    GLuint vertices, indices, records, attributes, materials, texels;
} svo_i_gl_surface;

/* Call svo_i_gl_surface_free after a failure too. */
svo_status svo_i_gl_surface_upload(svo_i_gl_build *gl_build, svo_i_gl_surface *out);
void svo_i_gl_surface_free(svo_i_gl_build *gl_build, svo_i_gl_surface *surface);

/* Creates the materials of the nodes. Needs list_begin, at least one leaf, and materials that are not constant. */
svo_status svo_i_gl_material(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface);

/* Creates the projected areas of the leaves. Sums up what the triangles of each leaf show, and rounds the sums. */
svo_status svo_i_gl_areas(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface);

/* Creates colors, normals and fills of the nodes. Links the leaves' fragments and sums up their contributions, level by
   level. */
svo_status svo_i_gl_filter(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface);

#endif
