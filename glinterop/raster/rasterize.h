/* SPDX-License-Identifier: MIT */
/* Creates the fragment list by rasterization, in buffers that OpenGL and OpenCL share. */
#ifndef SVO_GLINTEROP_RASTER_RASTERIZE_H
#define SVO_GLINTEROP_RASTER_RASTERIZE_H

#include "build/frontend.h"
#include "raster/raster.h"

typedef struct svo_i_rasterizer {
    svo_device *device;
    svo_gl_context *context;
    svo_i_raster *raster;
    svo_gl_share share; /* how the list gets to OpenCL; AUTO: it stays in OpenGL */
} svo_i_rasterizer;

/* Implements svo_frontend.voxelize. The owner of each chunk is an svo_i_share_buffer. Makes the context current. */
svo_status svo_i_rasterize_list(const svo_i_rasterizer *rasterizer, const svo_plan *plan, const svo_i_layout *chunking,
                                cl_command_queue queue, svo_i_fragment_list *list, svo_build_report *report);
/* Implements svo_frontend.release. */
void svo_i_rasterize_release(svo_i_fragment_list *list);

#endif
