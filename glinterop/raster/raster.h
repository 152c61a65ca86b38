/* SPDX-License-Identifier: MIT */
/*
 * The rasterizer: the shaders and objects of one context, which draw a plan's triangles into chunks of fragments.
 * rasterize.c makes the fragment list with it; selftest.c compares it with a walk over the voxels.
 *
 * The files of this room:
 *
 *   raster      programs that rasterize conservatively
 *   rasterize   the fragment list, by them
 *   selftest    whether hardware rasterizes as it promises
 *   light_view  views of light by rasterization
 */
#ifndef SVO_GLINTEROP_RASTER_RASTER_H
#define SVO_GLINTEROP_RASTER_RASTER_H

#include "context/context.h"
#include "plan/plan_data.h"

/* The method that makes rasterization conservative. The vertex shader adds a margin to each. */
typedef enum svo_i_conservative {
    SVO_I_CONSERVATIVE_EXPAND = 0, /* the vertex shader */
    SVO_I_CONSERVATIVE_NV, /* GL_NV_conservative_raster_pre_snap_triangles */
    SVO_I_CONSERVATIVE_INTEL /* GL_INTEL_conservative_rasterization */
} svo_i_conservative;

/* The hardware's method, or SVO_I_CONSERVATIVE_EXPAND and the reason (a static string) why it has none. */
svo_i_conservative svo_i_raster_hardware(const svo_i_gl_functions *gl, const char **reason);

typedef struct svo_i_raster svo_i_raster;

/* Compiles nothing yet. The context must outlive the rasterizer. no_int64: the shaders use two-word integers even where
   the context has 64-bit ones. Returns SVO_UNSUPPORTED naming a limit of the context, SVO_GL_ERROR or
   SVO_OUT_OF_HOST_MEMORY. */
svo_status svo_i_raster_create(svo_device *device, svo_gl_context *context, svo_i_conservative conservative,
                               bool no_int64, svo_i_raster **out);
void svo_i_raster_destroy(svo_i_raster **raster);

/* The calls below expect the context current. */

/* Compiles the programs that the plan's draws need. SVO_COMPILE_FAILED with the first line of the log. */
svo_status svo_i_raster_prepare(svo_i_raster *raster, const svo_plan *plan);
/* Uploads the snapped mesh and the items that draws name, and zero counters. */
svo_status svo_i_raster_upload(svo_i_raster *raster, const svo_plan *plan, const svo_draw_item *items,
                               uint32_t item_count, uint32_t chunk_count);
/* Draws one chunk into the storage block that the caller has bound to SVO_I_RASTER_FRAGMENTS. */
svo_status svo_i_raster_draw(svo_i_raster *raster, const svo_plan *plan, const svo_i_chunking *layout, uint32_t chunk);
/* The fragments of a chunk: those that touch, at its start, and undecided ones, at its end. It holds both if their sum
   is at most the capacity. */
typedef struct svo_i_raster_count {
    uint32_t decided, undecided;
} svo_i_raster_count;

/* Waits, and reads the counts of each chunk. */
svo_status svo_i_raster_finish(svo_i_raster *raster, uint32_t chunk_count, svo_i_raster_count *counts);
/* Frees the OpenGL memory of the mesh. */
void svo_i_raster_drop(svo_i_raster *raster);

/* The binding of the fragments' storage block. */
#define SVO_I_RASTER_FRAGMENTS 4

#endif
