/* SPDX-License-Identifier: MIT */
/*
 * Open objects of commands that compute: an OpenCL device with a profiling queue and, for those that build, a front
 * end. An OpenGL front end opens a context; otherwise no OpenGL is started.
 */
#ifndef SVOCL_TOOLS_SUPPORT_SESSION_H
#define SVOCL_TOOLS_SUPPORT_SESSION_H

#include <stdbool.h>

#include "support/opengl.h"
#include "support/program.h"
#include "svocl/svocl.h"

typedef struct session {
    svo_device *device;
    cl_command_queue queue;
    svo_frontend *cl; /* the OpenCL front end; NULL if OpenGL was requested */
    opengl *gl; /* NULL: not opened */
    svo_frontend *frontend; /* the front end of the builds; NULL until it is chosen */
    svo_message reason; /* why that one */
} session;

/* Opens device and queue by --device and --threads. On failure nothing stays open. */
int session_open_device(program *state, session *opened);
/* The same, and the front end if --frontend, --share or --context name one; otherwise it is chosen later. */
int session_open(program *state, session *opened);
/* Opens device, queue, the OpenCL front end and, if available, OpenGL, on an OpenCL context that shares with it if
   the two can. gl is NULL without OpenGL, and the reason says why. No front end is chosen. */
int session_open_both(program *state, session *opened);
/* Chooses the fastest front end for the plan, unless one is chosen already. */
void session_choose(program *state, session *opened, const svo_plan *plan);
/* Chooses the OpenGL front end if available. */
void session_choose_opengl(program *state, session *opened);
void session_close(session *opened);

/* Of the OpenGL context of the builds; "none" without one. */
const char *session_context(const session *opened);
const char *session_renderer(const session *opened);

#endif
