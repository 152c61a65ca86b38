/* SPDX-License-Identifier: MIT */
/* Opens devices and contexts by the options. */
#include "session.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The drivers read their thread counts once, at their first call, which must therefore come later. */
static int set_threads(program *state)
{
    if (state->options.threads == 0) {
        return PROGRAM_DONE;
    }
    char text[24];
    snprintf(text, sizeof text, "%u", (unsigned)state->options.threads);
    if (setenv("POCL_MAX_PTHREAD_COUNT", text, 1) != 0 || setenv("LP_NUM_THREADS", text, 1) != 0) {
        return program_fail(state, PROGRAM_FAILED, "--threads %s: out of memory", text);
    }
    return PROGRAM_DONE;
}

/* The device, on an OpenCL context made against the OpenGL one where there is one and the two can share; and a queue. */
static int open_device(program *state, session *opened)
{
    const svo_device_options device_options = {.struct_size = sizeof device_options,
                                               .log = program_log,
                                               .log_user = state,
                                               .device_name = state->options.device_name};
    svo_message message = {""};
    const svo_status status =
        opened->gl_context != NULL
            ? svo_gl_device_create(opened->gl_context, NULL, &device_options, &opened->device, &message)
            : svo_device_create_default(&device_options, &opened->device, &message);
    if (status != SVO_OK) {
        return program_fail_library(state, message.text);
    }
    cl_int error = CL_SUCCESS;
    opened->queue = clCreateCommandQueue(svo_device_cl_context(opened->device), svo_device_cl_device(opened->device),
                                         CL_QUEUE_PROFILING_ENABLE, &error);
    if (error != CL_SUCCESS) {
        program_fail(state, PROGRAM_FAILED, "%s: clCreateCommandQueue failed (%d)", svo_device_name(opened->device),
                     error);
        return PROGRAM_FAILED;
    }
    return PROGRAM_DONE;
}

int session_open_device(program *state, session *opened)
{
    *opened = (session){0};
    int result = set_threads(state);
    if (result == PROGRAM_DONE) {
        result = open_device(state, opened);
    }
    if (result != PROGRAM_DONE) {
        session_close(opened);
    }
    return result;
}

static svo_status create_gl_context(const program *state, svo_gl_context_kind kind, svo_gl_context **out,
                                    svo_message *message)
{
    const char *name = state->options.gl_device;
    return name != NULL ? svo_gl_context_create_named(name, out, message)
                        : svo_gl_context_create(kind, 0, out, message);
}

/* --context auto: the first kind that works. A forced kind that does not work is an error. */
static int open_gl_context(program *state, session *opened)
{
    const int forced = state->options.context;
    svo_message message = {""};
    char reasons[SVO_GL_CONTEXT_KINDS * (SVO_MESSAGE_BYTES + 32)] = "";
    size_t used = 0;
    for (int kind = 0; kind < SVO_GL_CONTEXT_KINDS; ++kind) {
        if (forced != OPTION_CONTEXT_AUTO && forced != kind) {
            continue;
        }
        if (create_gl_context(state, (svo_gl_context_kind)kind, &opened->gl_context, &message) == SVO_OK) {
            svo_gl_context_get_info(opened->gl_context, &opened->gl_info);
            return PROGRAM_DONE;
        }
        if (forced != OPTION_CONTEXT_AUTO) {
            return program_fail(state, PROGRAM_FAILED, "--context %s: %s",
                                svo_gl_context_kind_name((svo_gl_context_kind)kind), program_words(message.text));
        }
        used += (size_t)snprintf(reasons + used, sizeof reasons - used, "%s%s: %s", used == 0 ? "" : "; ",
                                 svo_gl_context_kind_name((svo_gl_context_kind)kind), program_words(message.text));
    }
    return program_fail(state, PROGRAM_FAILED, "no OpenGL context: %s", reasons);
}

int session_open(program *state, session *opened)
{
    *opened = (session){0};
    int result = set_threads(state);
    if (result == PROGRAM_DONE) {
        result = open_gl_context(state, opened);
    }
    if (result == PROGRAM_DONE) {
        result = open_device(state, opened);
    }
    if (result == PROGRAM_DONE) {
        const svo_gl_options gl_options = {.struct_size = sizeof gl_options,
                                           .raster = (svo_gl_raster)state->options.frontend,
                                           .share = (svo_gl_share)state->options.share};
        if (svo_gl_create(opened->device, opened->gl_context, &gl_options, &opened->gl) != SVO_OK) {
            result = program_fail_library(state, svo_device_message(opened->device));
        }
    }
    if (result != PROGRAM_DONE) {
        session_close(opened);
    }
    return result;
}

void session_close(session *opened)
{
    svo_gl_destroy(&opened->gl);
    if (opened->queue != NULL) {
        clReleaseCommandQueue(opened->queue);
    }
    svo_device_destroy(&opened->device);
    svo_gl_context_destroy(&opened->gl_context); /* after the OpenCL context, which may have been made against it */
    *opened = (session){0};
}
