/* SPDX-License-Identifier: MIT */
/*
 * The view of a light source by rasterization: for each pixel the nearest triangle, and where the ray through the
 * pixel's center meets it. Floats alone, and pixels on edges belong to either triangle: not the same on every driver.
 */
#ifndef SVO_GLINTEROP_RASTER_LIGHT_VIEW_H
#define SVO_GLINTEROP_RASTER_LIGHT_VIEW_H

#include "context/context.h"
#include "core/tree.h"
#include "light/photons.h"
#include "share/share.h"

typedef struct svo_i_light_raster svo_i_light_raster;

/* Compiles the program. The context must outlive the result. share: a path that works. Returns SVO_UNSUPPORTED naming a
   limit of the context, SVO_COMPILE_FAILED, SVO_GL_ERROR, SVO_NO_GL or SVO_OUT_OF_HOST_MEMORY. */
svo_status svo_i_light_raster_create(svo_device *device, svo_gl_context *context, svo_gl_share share,
                                     svo_i_light_raster **out);
void svo_i_light_raster_destroy(svo_i_light_raster **raster);

/* Makes a caster of photons into a tree on the device, with triangles; valid until the end. Expects the context current
   until then; the first view that is drawn uploads the triangles. */
svo_i_photon_caster svo_i_light_raster_begin(svo_i_light_raster *raster, const svo_tree *tree);
/* Releases the memory of triangles and hits. */
void svo_i_light_raster_end(svo_i_light_raster *raster);

#endif
