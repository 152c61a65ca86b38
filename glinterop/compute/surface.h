/* SPDX-License-Identifier: MIT */
/* The mesh's attributes in storage blocks, and launches over the fragments that read them. */
#ifndef SVO_GLINTEROP_COMPUTE_SURFACE_H
#define SVO_GLINTEROP_COMPUTE_SURFACE_H

#include "compute/compute.h"

/* Storage blocks that texels may fill, and how many these hold. */
#define SVO_I_TEXEL_BLOCKS 7u
uint64_t svo_i_gl_texels_max(const svo_i_compute *compute);

/* Triangles in storage blocks. 0 for an attribute that the plan does not have. */
typedef struct svo_i_gl_part {
    svo_i_launch_mesh mesh;
    GLuint vertices, indices, records, attributes;
} svo_i_gl_part;

typedef struct svo_i_gl_surface {
    svo_i_gl_part *parts;
    uint32_t part_count;
    GLuint materials;
    GLuint texels[SVO_I_TEXEL_BLOCKS];
    uint32_t texel_blocks;
} svo_i_gl_surface;

/* Call svo_i_gl_surface_free after a failure too. */
svo_status svo_i_gl_surface_upload(svo_i_gl_build *gl_build, svo_i_gl_surface *out);
void svo_i_gl_surface_free(svo_i_gl_build *gl_build, svo_i_gl_surface *surface);

/* Launches an entry point on the fragments of all chunks, with each part of the mesh. The launch lacks the parameters
   and the buffers 0 to 5: fragments, cursors, vertices, indices, records, attributes. */
svo_status svo_i_gl_launch_fragments(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface,
                                     svo_filter_params params, svo_i_launch launch);

#endif
