/* SPDX-License-Identifier: MIT */
/* Which rasterization a pair of device and context uses. */
#ifndef SVO_GLINTEROP_FRONTEND_CHOICE_H
#define SVO_GLINTEROP_FRONTEND_CHOICE_H

#include "frontend/handle.h"

/* Fills the reasons of every method, sets the choice and creates gl->raster. Returns SVO_UNSUPPORTED, with the reason in
   the device's message, when a forced choice does not work, and the statuses of svo_i_raster_create. */
svo_status svo_i_gl_choose_raster(svo_gl *gl, svo_gl_raster asked);

#endif
