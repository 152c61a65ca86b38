/* SPDX-License-Identifier: MIT */
/* The memory that pictures are drawn to by OpenCL and read from by OpenGL. */
#ifndef SVOCL_TOOLS_VIEW_PIXEL_BUFFER_H
#define SVOCL_TOOLS_VIEW_PIXEL_BUFFER_H

#include "support/program.h"
#include "svocl/gl.h"
#include "view/state.h"

typedef struct pixel_buffer {
    program *running;
    svo_gl_context *context; /* the window's, current in all calls */
    svo_gl_buffer *buffer; /* NULL: not made yet */
    svo_gl_buffer_info info; /* of it */
    svo_device *device; /* whose it is */
    cl_command_queue queue; /* of the picture that is being drawn */
} pixel_buffer;

/* Gives the memory to OpenCL, with room for so many bytes. What it is and why goes to the state and its log when it is
   made. Returns the exit code. */
int pixel_buffer_begin(pixel_buffer *which, svo_device *device, cl_command_queue queue, size_t bytes,
                       view_state *state);
/* Waits for the picture, which takes the event, and gives its first bytes to OpenGL. Returns the exit code. */
int pixel_buffer_finish(pixel_buffer *which, size_t used_bytes, cl_event drawn);

/* Before its device goes. */
void pixel_buffer_drop(pixel_buffer *which);

#endif
