/* SPDX-License-Identifier: MIT */
/*
 * What commands that compute have open: an OpenCL device with a profiling queue and, for those that build, a GL context
 * with its front end.
 */
#ifndef SVOCL_SESSION_H
#define SVOCL_SESSION_H

#include "program.h"
#include "svocl/gl.h"
#include "svocl/svocl.h"

typedef struct session {
    svo_device *device;
    cl_command_queue queue;
    svo_gl_context *gl_context; /* NULL after session_open_device */
    svo_gl_context_info gl_info;
    svo_gl *gl;
} session;

/* Device and queue by --device and --threads. On failure nothing stays open. */
int session_open_device(program *state, session *opened);
/* The same, and GL by --context, --gl-device, --frontend and --share. */
int session_open(program *state, session *opened);
void session_close(session *opened);

#endif
