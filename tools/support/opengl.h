/* SPDX-License-Identifier: MIT */
/*
 * All that the program has to do with OpenGL: a context with svocl::gl's front end in it, and what `svocl devices` says
 * of renderers. opengl.c and opengl_devices.c have it; opengl_none.c takes their place where svocl is built without
 * svocl::gl.
 */
#ifndef SVOCL_TOOLS_SUPPORT_OPENGL_H
#define SVOCL_TOOLS_SUPPORT_OPENGL_H

#include "support/json.h"
#include "support/program.h"
#include "svocl/svocl.h"

typedef struct opengl opengl;

/* Whether the device might share with OpenGL, which then has to be opened first. Starts no OpenGL. */
bool opengl_may_share(const svo_device *device);
/* Opens a context by --context and --gl-device. NULL where that does not work, with the reason, which names the option
   that was forced. */
opengl *opengl_open(const options *given, svo_message *reason);
/* The same device on an OpenCL context that shares with the context where the two can; NULL when there is none. It is
   to be destroyed before opengl_close. */
svo_device *opengl_join(const opengl *opened, const svo_device *device, const svo_device_options *device_options);
/* The front end by --frontend and --share, for a device that outlives opengl_stop. False with the reason where it does
   not work. */
bool opengl_start(opengl *opened, const options *given, svo_device *device, svo_message *reason);
void opengl_stop(opengl *opened); /* NULL and one that was not started are allowed */
void opengl_close(opengl **opened); /* a pointer to NULL is allowed */

const char *opengl_context_name(const opengl *opened); /* "surfaceless", ... */
const char *opengl_renderer(const opengl *opened);

svo_frontend *opengl_frontend(opengl *opened);
/* The faster of that and cl, and why. */
svo_frontend *opengl_prefer(opengl *opened, svo_frontend *cl, svo_message *reason);
/* A build by OpenGL's compute shaders. */
svo_status opengl_build(opengl *opened, svo_plan *plan, cl_command_queue queue, svo_tree **out,
                        svo_build_report *report);
/* One more front end on the same context, made at the first call for its raster and share (option_frontend,
   svo_gl_share) and kept. NULL with the reason. */
svo_frontend *opengl_further_frontend(opengl *opened, int frontend, int share, svo_message *reason);

#endif
