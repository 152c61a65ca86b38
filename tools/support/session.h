/* SPDX-License-Identifier: MIT */
/*
 * What commands that compute have open: an OpenCL device with a profiling queue and, for those that build, a front end.
 * One of OpenGL brings its context along; without one no OpenGL is started.
 */
#ifndef SVOCL_TOOLS_SUPPORT_SESSION_H
#define SVOCL_TOOLS_SUPPORT_SESSION_H

#include "support/opengl.h"
#include "support/program.h"
#include "svocl/svocl.h"

typedef struct session {
    svo_device *device;
    cl_command_queue queue;
    svo_frontend *cl; /* the front end of OpenCL alone; NULL where OpenGL was asked for */
    opengl *gl; /* NULL: not opened */
    svo_frontend *frontend; /* that builds go through; NULL until it is chosen */
    svo_message reason; /* why that one */
} session;

/* Device and queue by --device and --threads. On failure nothing stays open. */
int session_open_device(program *state, session *opened);
/* The same, and the front end where --frontend, --share or --context name one; else it is left to be chosen. */
int session_open(program *state, session *opened);
/* Device, queue and the front end of OpenCL alone, and OpenGL beside it wherever there is one, on an OpenCL context
   that shares with it where the two can; gl is NULL without one, and the reason says why. No front end is chosen. */
int session_open_both(program *state, session *opened);
/* Chooses the front end that should be fastest for the plan, unless there is one. */
void session_choose(program *state, session *opened, const svo_plan *plan);
/* Chooses that of OpenGL wherever there is one. */
void session_choose_opengl(program *state, session *opened);
void session_close(session *opened);

/* Of the context that builds go through: "none" where that is none. */
const char *session_context(const session *opened);
const char *session_renderer(const session *opened);

#endif
