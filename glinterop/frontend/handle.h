/* SPDX-License-Identifier: MIT */
/* The insides of svo_gl: a device, a context, and what rasterizes and builds with them. */
#ifndef SVO_GLINTEROP_FRONTEND_HANDLE_H
#define SVO_GLINTEROP_FRONTEND_HANDLE_H

#include "commands/frontend.h"
#include "compute/compute.h"
#include "raster/light_view.h"
#include "raster/raster.h"
#include "share/probe.h"

#define SVO_I_GL_REASON_BYTES SVO_MESSAGE_BYTES /* reasons are messages, with names of drivers in them */
#define SVO_I_GL_RASTERS      3

struct svo_gl {
    svo_device *device;
    svo_gl_context *context;
    bool no_int64;
    svo_gl_raster raster_choice;
    svo_gl_share share_choice;
    /* "" for a method or path that works. */
    char raster_reasons[SVO_I_GL_RASTERS][SVO_I_GL_REASON_BYTES];
    svo_i_share_reasons share_reasons;
    svo_i_raster *raster;
    svo_frontend frontend;

    /* svo_gl_build. */
    char build_reason[SVO_I_GL_REASON_BYTES]; /* the last answer of svo_gl_build_reason */
    svo_i_compute *compute; /* NULL until the first build */
    svo_frontend build_frontend; /* its list stays in OpenGL */

    svo_i_light_raster *light_raster; /* NULL until the first svo_gl_light_set_sources */
};

#endif
