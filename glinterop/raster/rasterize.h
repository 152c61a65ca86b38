/* SPDX-License-Identifier: MIT */
/* Creates the fragment list by rasterization, in buffers that OpenGL and OpenCL share. */
#ifndef SVO_GLINTEROP_RASTER_RASTERIZE_H
#define SVO_GLINTEROP_RASTER_RASTERIZE_H

#include "commands/frontend.h"
#include "plan/chunking.h"
#include "raster/raster.h"
#include "share/share.h"

/* Who decides undecided fragments. */
typedef struct svo_i_decider {
    void *self;
    /* Moves those of a chunk that touch behind its decided ones; *kept: how many. The chunk holds all of count. NULL:
       the host does it. */
    svo_status (*decide)(void *self, const svo_plan *plan, const svo_i_share_buffer *fragments, uint32_t capacity,
                         svo_i_raster_count count, uint32_t *kept);
} svo_i_decider;

typedef struct svo_i_rasterizer {
    svo_device *device;
    svo_gl_context *context;
    svo_i_raster *raster;
    svo_gl_share share; /* how the list gets to OpenCL; AUTO: it stays in OpenGL */
    svo_i_decider decider;
    const svo_i_rest *rest; /* its triangles alone, in chunks of their own; NULL: the plan's */
} svo_i_rasterizer;

/* Implements svo_frontend.voxelize. The owner of each chunk is an svo_i_share_buffer. Makes the context current. */
svo_status svo_i_rasterize_list(const svo_i_rasterizer *rasterizer, svo_i_commands *commands,
                                const svo_i_chunking *chunking, svo_i_fragment_list *list);
/* Implements svo_frontend.release. */
void svo_i_rasterize_release(svo_i_fragment_list *list);

#endif
