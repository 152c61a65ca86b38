/* SPDX-License-Identifier: MIT */
/* Creates the fragment list by rasterization, in buffers that OpenGL and OpenCL share. */
#ifndef SVO_GLINTEROP_RASTER_RASTERIZE_H
#define SVO_GLINTEROP_RASTER_RASTERIZE_H

#include "commands/frontend.h"
#include "raster/raster.h"

typedef struct svo_i_rasterizer {
    svo_device *device;
    svo_gl_context *context;
    svo_i_raster *raster;
    svo_gl_share share; /* how the list gets to OpenCL; AUTO: it stays in OpenGL */
} svo_i_rasterizer;

/* Implements svo_frontend.voxelize. The owner of each chunk is an svo_i_share_buffer. Makes the context current. */
svo_status svo_i_rasterize_list(const svo_i_rasterizer *rasterizer, svo_i_commands *commands,
                                const svo_i_chunking *chunking, svo_i_fragment_list *list);
/* Implements svo_frontend.release. */
void svo_i_rasterize_release(svo_i_fragment_list *list);

#endif
