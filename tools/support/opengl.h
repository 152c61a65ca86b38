/* SPDX-License-Identifier: MIT */
/*
 * The program's OpenGL: a context and the front ends of svocl::gl on it. opengl.c implements it; opengl_none.c replaces
 * opengl.c and opengl_devices.c in a build without svocl::gl.
 */
#ifndef SVOCL_TOOLS_SUPPORT_OPENGL_H
#define SVOCL_TOOLS_SUPPORT_OPENGL_H

#include "support/json.h"
#include "support/program.h"
#include "svocl/svocl.h"

typedef struct opengl opengl;

/* Whether the device may share with OpenGL, whose context must then be opened first. Starts no OpenGL. */
bool opengl_may_share(const svo_device *device);
/* Whether OpenGL would draw on the CPU, as far as that is known without a context. False for a forced context. */
bool opengl_is_software(const options *given);
/* Opens a context by --context and --gl-device, without them the one that suits the device. NULL if that fails; the
   reason names the option that forced it. */
opengl *opengl_open(const options *given, const svo_device *device, svo_message *reason);
/* The same device on an OpenCL context that shares with the context if the two can; NULL otherwise. Destroy it
   before opengl_close. */
svo_device *opengl_join(const opengl *opened, const svo_device *device, const svo_device_options *device_options);
/* The front end by --frontend and --share, for a device that outlives opengl_stop. Returns false, with the reason,
   if it does not work. */
bool opengl_start(opengl *opened, const options *given, svo_device *device, svo_message *reason);
void opengl_stop(opengl *opened); /* NULL is allowed, and a context without a front end */
void opengl_close(opengl **opened); /* a pointer to NULL is allowed */

const char *opengl_context_name(const opengl *opened); /* "surfaceless", ... */
const char *opengl_renderer(const opengl *opened);
const svo_device *opengl_device(const opengl *opened); /* of opengl_start */

svo_frontend *opengl_frontend(opengl *opened);
/* The faster of OpenGL's front end and cl, and why. */
svo_frontend *opengl_prefer(opengl *opened, svo_frontend *cl, svo_message *reason);
/* A build by OpenGL's compute shaders. */
svo_status opengl_build(opengl *opened, svo_plan *plan, cl_command_queue queue, svo_tree **out,
                        svo_build_report *report);
/* Another front end on the same context, created at the first call for its raster and share (option_frontend,
   svo_gl_share) and kept. NULL with the reason on failure. */
svo_frontend *opengl_further_frontend(opengl *opened, int frontend, int share, svo_message *reason);
/* A build by OpenGL's compute shaders whose list is by the front end of those choices. SVO_NO_GL where
   opengl_further_frontend has none. */
svo_status opengl_further_build(opengl *opened, int frontend, int share, svo_plan *plan, cl_command_queue queue,
                                svo_tree **out, svo_build_report *report);
/* gl-hybrid with a threshold; one at a time is kept. NULL with the reason on failure. */
svo_frontend *opengl_hybrid_frontend(opengl *opened, uint32_t columns, svo_message *reason);

#endif
