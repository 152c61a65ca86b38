/* SPDX-License-Identifier: MIT */
/* The rules by which a front end is chosen; svocl::gl tells them what it knows of the renderer. */
#ifndef SVO_LIB_PLAN_FRONTEND_CHOICE_H
#define SVO_LIB_PLAN_FRONTEND_CHOICE_H

#include "plan/plan_data.h"
#include "svocl/build.h"

typedef struct svo_i_renderer {
    const char *name;
    bool is_software; /* it draws on the CPU */
    bool in_place; /* OpenCL reads the list where OpenGL wrote it */
} svo_i_renderer;

SVO_I_SHARED_BEGIN

/* Whether OpenCL alone is the faster way, and why. reason: NULL allowed. */
bool svo_i_frontend_prefers_cl(const svo_device *device, const svo_i_renderer *renderer, svo_message *reason);

SVO_I_SHARED_END

#endif
