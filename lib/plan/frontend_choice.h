/* SPDX-License-Identifier: MIT */
/* The rules for choosing a front end. svocl::gl passes what it knows of the renderer. */
#ifndef SVO_LIB_PLAN_FRONTEND_CHOICE_H
#define SVO_LIB_PLAN_FRONTEND_CHOICE_H

#include "plan/plan_data.h"
#include "svocl/build.h"

typedef struct svo_i_renderer {
    const char *name;
    bool is_software; /* draws on the CPU */
    bool in_place; /* OpenCL reads the list from OpenGL's memory */
} svo_i_renderer;

SVO_I_SHARED_BEGIN

/* Whether OpenCL alone should be faster than OpenGL, and why. reason: NULL allowed. */
bool svo_i_frontend_prefers_cl(const svo_device *device, const svo_i_renderer *renderer, svo_message *reason);

SVO_I_SHARED_END

#endif
