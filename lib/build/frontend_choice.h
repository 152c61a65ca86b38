/* SPDX-License-Identifier: MIT */
/* Which front end to use: the default one, and the rules for a choice between OpenCL and OpenGL. */
#ifndef SVO_LIB_BUILD_FRONTEND_CHOICE_H
#define SVO_LIB_BUILD_FRONTEND_CHOICE_H

#include "plan/plan.h"
#include "svocl/build.h"

typedef struct svo_i_renderer {
    const char *name;
    bool is_software; /* it draws on the CPU */
    bool in_place; /* OpenCL reads the list where OpenGL wrote it */
} svo_i_renderer;

/* The front end that is given, or for NULL the device's own of OpenCL alone, made on first use and owned by the
   device. */
svo_status svo_i_default_frontend(svo_device *device, svo_frontend *given, svo_frontend **out);

SVO_I_SHARED_BEGIN

/* Whether OpenCL alone is the faster way, and why. reason: NULL allowed. */
bool svo_i_frontend_prefers_cl(const svo_device *device, const svo_i_renderer *renderer, svo_message *reason);

SVO_I_SHARED_END

#endif
