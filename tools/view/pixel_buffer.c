/* SPDX-License-Identifier: MIT */
/* Pictures from OpenCL to OpenGL by svo_gl_buffer. */
#include "view/pixel_buffer.h"

static int fail_device(const pixel_buffer *which, const svo_device *device)
{
    return program_fail_library(which->running, svo_device_message(device));
}

/* How pictures travel, and why not by cl_khr_gl_sharing. */
static void describe(const pixel_buffer *which, view_state *state)
{
    static const char *const ways[] = {"", "shared by both", "OpenCL draws into OpenGL's memory", "copied"};
    const svo_gl_share share = which->info.share;
    const char *reason = svo_gl_buffer_share_reason(which->buffer, SVO_GL_SHARE_INTEROP);
    state->share = svo_gl_share_name(share);
    view_set_text(&state->share_reason, "%s%s%s", ways[share], reason[0] != '\0' ? "; " : "", reason);
    view_log(state, "pictures: %s, %s%s%s", state->share, ways[share], reason[0] != '\0' ? "; " : "", reason);
}

static int make(pixel_buffer *which, svo_device *device, size_t bytes, view_state *state)
{
    pixel_buffer_drop(which);
    which->info = (svo_gl_buffer_info)SVO_GL_BUFFER_INFO_INIT;
    if (svo_gl_buffer_create(device, which->context, bytes, SVO_GL_SHARE_AUTO, &which->buffer) != SVO_OK ||
        svo_gl_buffer_get_info(which->buffer, &which->info) != SVO_OK) {
        return fail_device(which, device);
    }
    if (which->device != device) {
        describe(which, state);
    }
    which->device = device;
    return PROGRAM_DONE;
}

int pixel_buffer_begin(pixel_buffer *which, svo_device *device, cl_command_queue queue, size_t bytes, view_state *state)
{
    const bool fits = which->buffer != NULL && which->device == device && which->info.bytes >= bytes;
    const int exit_code = fits ? PROGRAM_DONE : make(which, device, bytes, state);
    which->queue = queue;
    return exit_code != PROGRAM_DONE || svo_gl_buffer_to_cl(which->buffer, queue) == SVO_OK
               ? exit_code
               : fail_device(which, device);
}

int pixel_buffer_finish(pixel_buffer *which, size_t used_bytes, cl_event drawn)
{
    const svo_status status = svo_gl_buffer_to_gl(which->buffer, used_bytes, which->queue, 1, &drawn);
    clReleaseEvent(drawn);
    return status == SVO_OK ? PROGRAM_DONE : fail_device(which, which->device);
}

void pixel_buffer_drop(pixel_buffer *which)
{
    svo_gl_buffer_destroy(&which->buffer);
}
