/* SPDX-License-Identifier: MIT */
/* Which rasterization and which share path a pair of device and context uses. */
#ifndef SVO_GLINTEROP_FRONTEND_CHOICE_H
#define SVO_GLINTEROP_FRONTEND_CHOICE_H

#include "frontend/handle.h"

/* Both fill the reasons of every method or path, and set the choice. They return SVO_UNSUPPORTED, with the reason in
   the device's message, when a forced choice does not work or nothing does. */
svo_status svo_i_gl_choose_share(svo_gl *gl, svo_gl_share asked);
/* Also creates gl->raster. Returns the statuses of svo_i_raster_create as well. */
svo_status svo_i_gl_choose_raster(svo_gl *gl, svo_gl_raster asked);

#endif
