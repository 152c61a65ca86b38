/* SPDX-License-Identifier: MIT */
/*
 * One build by compute shaders: what its stages (subdivide.c, pack.c, material.c, filter.c) share.
 * build.c runs them in order. Each stage is the twin of the OpenCL one of the same name in lib/, shader by shader.
 */
#ifndef SVO_GLINTEROP_COMPUTE_BUILD_H
#define SVO_GLINTEROP_COMPUTE_BUILD_H

#include "compute/compute.h"

typedef struct svo_i_gl_build {
    svo_i_build *build;
    svo_i_compute *compute;
    /* Scratch. */
    GLuint *cursors; /* one per chunk */
    GLuint state, partials;
    /* The tree in the making; 0 where it does not hold the array. */
    GLuint arrays[SVO_TREE_BUFFER_COUNT];
} svo_i_gl_build;

/* The mesh's attributes; 0 where the plan does not have them. */
typedef struct svo_i_gl_surface {
    GLuint vertices, indices, records, attributes, materials, texels;
} svo_i_gl_surface;

/* build.c: the tree of a list that is in OpenGL, for svo_frontend.make_tree. Expects the context current. */
svo_status svo_i_gl_make_tree(svo_i_compute *compute, svo_i_build *build);
/* build.c: refuses what is sure not to fit the context's storage blocks, before anything is drawn. */
svo_status svo_i_gl_check_size(svo_i_compute *compute, const svo_plan *plan);
/* A chunk of the list. */
GLuint svo_i_gl_chunk(const svo_i_gl_build *gl_build, uint32_t chunk);

/* build.c: SVO_UNSUPPORTED when a launch since the last look was cut short by the driver. */
svo_status svo_i_gl_check_loops(svo_i_gl_build *gl_build, const char *what);

/* subdivide.c: masks, first children and level counts; cursors end up at the leaves. *fits is false when the inner
   nodes did not fit the build's inner_capacity. */
svo_status svo_i_gl_subdivide(svo_i_gl_build *gl_build, bool *fits);
/* pack.c: list_begin; and list, if asked for. */
svo_status svo_i_gl_pack(svo_i_gl_build *gl_build, bool with_lists);
/* surface.c. Free also after a failure. */
svo_status svo_i_gl_surface_upload(svo_i_gl_build *gl_build, svo_i_gl_surface *out);
void svo_i_gl_surface_free(svo_i_gl_build *gl_build, svo_i_gl_surface *surface);
/* material.c: the nodes' materials. Needs list_begin, and materials that vary. */
svo_status svo_i_gl_material(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface);
/* filter.c: links the leaves, and makes colors, normals and fills. */
svo_status svo_i_gl_filter(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface);

#endif
