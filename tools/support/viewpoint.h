/* SPDX-License-Identifier: MIT */
/* The camera of a picture, as --eye, --at, --up and --fov place it. */
#ifndef SVOCL_TOOLS_SUPPORT_VIEWPOINT_H
#define SVOCL_TOOLS_SUPPORT_VIEWPOINT_H

#include "support/program.h"
#include "svocl/trace.h"

/* Moves a camera to where the options want it; what they leave open stays. frames: the camera frames its subject, and
   its angle suits that alone. Returns the exit code. */
int viewpoint_apply(program *state, bool frames, svo_camera *camera);

/* A camera on its way round its target, about its up axis: frame 0 is where it stands, and frame_count would be there
   again. */
void viewpoint_turn(const svo_camera *start, unsigned frame, unsigned frame_count, svo_camera *out);

#endif
