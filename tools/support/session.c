/* SPDX-License-Identifier: MIT */
/* Opens devices by the options, and chooses front ends. */
#include "support/session.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/hybrid.h"
#include "support/info_of.h"
#include "support/kernel_folder.h"
#include "support/options_parse.h"

/* The drivers read their thread counts once, at their first call, so the counts are set before it. */
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

static svo_device_options device_options_of(program *state)
{
    return (svo_device_options){.struct_size = sizeof(svo_device_options),
                                .log = program_log,
                                .log_user = state,
                                .device_name = state->options.device_name,
                                .path = (svo_path)state->options.path,
                                .max_device_bytes = state->options.max_memory};
}

static int open_queue(program *state, session *opened)
{
    const svo_device_info on = info_of_device(opened->device);
    cl_int error = CL_SUCCESS;
    opened->queue = clCreateCommandQueue(on.context, on.device, CL_QUEUE_PROFILING_ENABLE, &error);
    if (error != CL_SUCCESS) {
        return program_fail(state, PROGRAM_FAILED, "%s: clCreateCommandQueue failed (%d)", on.name, error);
    }
    return PROGRAM_DONE;
}

/* --kernels, or the user's folder if there is one. What the folder lacks is compiled. */
static int load_kernels(program *state, svo_device *device)
{
    char own[KERNEL_FOLDER_BYTES];
    const char *folder = state->options.kernels_path;
    if (folder == NULL && kernel_folder_name(own) && kernel_folder_is_own(own)) {
        (void)svo_device_load_kernels(device, own, NULL);
    }
    if (folder != NULL && kernel_folder_is_open(folder)) {
        return program_fail(state, PROGRAM_FAILED,
                            "--kernels %s is no folder that you alone may write to, and kernels are code", folder);
    }
    return folder == NULL || svo_device_load_kernels(device, folder, NULL) == SVO_OK
               ? PROGRAM_DONE
               : program_fail_library(state, svo_device_message(device));
}

int session_open_device(program *state, session *opened)
{
    *opened = (session){0};
    int result = set_threads(state);
    if (result != PROGRAM_DONE) {
        return result;
    }
    const svo_device_options device_options = device_options_of(state);
    svo_message message = {""};
    const program_devices *devices = &state->devices;
    const svo_status status = devices->create != NULL
                                  ? devices->create(devices->user, &device_options, &opened->device, &message)
                                  : svo_device_create_default(&device_options, &opened->device, &message);
    if (status != SVO_OK) {
        return program_fail_library(state, message.text);
    }
    result = open_queue(state, opened);
    if (result == PROGRAM_DONE) {
        result = load_kernels(state, opened->device);
    }
    if (result != PROGRAM_DONE) {
        session_close(opened);
    }
    return result;
}

static int use(session *opened, svo_frontend *frontend)
{
    opened->frontend = frontend;
    return PROGRAM_DONE;
}

static void explain(session *opened, const char *reason)
{
    snprintf(opened->reason.text, sizeof opened->reason.text, "%s", reason);
}

/* Replaces device and queue, from which nothing was created yet, by those of an OpenCL context that shares with
   OpenGL; not where the program has made them for a context of its own. */
static int join_opengl(program *state, session *opened)
{
    if (state->devices.create != NULL) {
        return PROGRAM_DONE;
    }
    const svo_device_options device_options = device_options_of(state);
    svo_device *joined = opengl_join(opened->gl, opened->device, &device_options);
    if (joined == NULL) {
        return PROGRAM_DONE;
    }
    clReleaseCommandQueue(opened->queue);
    opened->queue = NULL;
    svo_device_destroy(&opened->device);
    opened->device = joined;
    const int result = open_queue(state, opened);
    return result == PROGRAM_DONE ? load_kernels(state, joined) : result;
}

/* OpenGL was requested: if it does not work, that is an error. */
static int use_opengl(program *state, session *opened, const char *reason)
{
    opened->gl = opengl_open(&state->options, opened->device, &opened->reason);
    if (opened->gl == NULL) {
        return program_fail(state, PROGRAM_FAILED, "%s", opened->reason.text);
    }
    const int result = join_opengl(state, opened);
    if (result != PROGRAM_DONE) {
        return result;
    }
    if (!opengl_start(opened->gl, &state->options, opened->device, &opened->reason)) {
        return program_fail(state, PROGRAM_FAILED, "%s", opened->reason.text);
    }
    explain(opened, reason);
    return use(opened, opengl_frontend(opened->gl));
}

/* The front end is not chosen yet. But a device from which objects were created can no longer share with OpenGL, so
   where it may share, OpenGL is opened first. */
static int leave_open(program *state, session *opened)
{
    if (state->devices.create == NULL && opengl_may_share(opened->device)) {
        opened->gl = opengl_open(&state->options, opened->device, &opened->reason);
    }
    return opened->gl != NULL ? join_opengl(state, opened) : PROGRAM_DONE;
}

/* OpenGL's front end in addition to that of OpenCL, on the device as it is; if it fails, the reason says why. */
static bool try_opengl(program *state, session *opened)
{
    if (opened->gl == NULL) {
        opened->gl = opengl_open(&state->options, opened->device, &opened->reason);
    }
    return opened->gl != NULL && opengl_start(opened->gl, &state->options, opened->device, &opened->reason);
}

/* The OpenCL front end, used if it was requested. */
static int open_cl(program *state, session *opened)
{
    if (svo_frontend_create_cl(opened->device, &opened->cl) != SVO_OK) {
        return program_fail_library(state, svo_device_message(opened->device));
    }
    if (state->options.frontend == OPTION_FRONTEND_CL) {
        explain(opened, "requested");
        return use(opened, opened->cl);
    }
    return PROGRAM_DONE;
}

int session_open(program *state, session *opened)
{
    int result = session_open_device(state, opened);
    if (result != PROGRAM_DONE) {
        return result;
    }
    if (options_ask_for_gl(&state->options)) {
        result = use_opengl(state, opened, "requested");
    } else {
        result = state->options.frontend == OPTION_FRONTEND_CL ? PROGRAM_DONE : leave_open(state, opened);
        result = result == PROGRAM_DONE ? open_cl(state, opened) : result;
    }
    if (result != PROGRAM_DONE) {
        session_close(opened);
    }
    return result;
}

int session_open_both(program *state, session *opened)
{
    int result = session_open_device(state, opened);
    if (result != PROGRAM_DONE) {
        return result;
    }
    opened->gl = opengl_open(&state->options, opened->device, &opened->reason);
    if (opened->gl != NULL) {
        result = join_opengl(state, opened);
    }
    if (result == PROGRAM_DONE && opened->gl != NULL &&
        !opengl_start(opened->gl, &state->options, opened->device, &opened->reason)) {
        opengl_close(&opened->gl);
    }
    if (result == PROGRAM_DONE && svo_frontend_create_cl(opened->device, &opened->cl) != SVO_OK) {
        result = program_fail_library(state, svo_device_message(opened->device));
    }
    if (result != PROGRAM_DONE) {
        session_close(opened);
    }
    return result;
}

void session_choose(program *state, session *opened, const svo_plan *plan)
{
    if (opened->frontend != NULL) {
        return;
    }
    opened->frontend = opened->cl;
    if (svo_frontend_cl_suffices(plan, &opened->reason)) {
        return;
    }
    if (opened->gl == NULL && opengl_is_software(&state->options)) {
        snprintf(opened->reason.text, sizeof opened->reason.text, "OpenGL draws in software, OpenCL on %s is faster",
                 info_of_device(opened->device).name);
        return;
    }
    if (try_opengl(state, opened)) {
        svo_frontend *measured = hybrid_recall(opened->gl, opened->device, opened->cl, &opened->reason);
        opened->frontend = measured != NULL ? measured : opengl_prefer(opened->gl, opened->cl, &opened->reason);
    }
}

void session_choose_opengl(program *state, session *opened)
{
    if (opened->frontend != NULL) {
        return;
    }
    opened->frontend = opened->cl;
    if (try_opengl(state, opened)) {
        opened->frontend = opengl_frontend(opened->gl);
        explain(opened, "OpenGL if available");
    }
}

const char *session_context(const session *opened)
{
    return opened->gl != NULL && opened->frontend != opened->cl ? opengl_context_name(opened->gl) : "none";
}

const char *session_renderer(const session *opened)
{
    return opened->gl != NULL && opened->frontend != opened->cl ? opengl_renderer(opened->gl) : "none";
}

void session_close(session *opened)
{
    opengl_stop(opened->gl);
    svo_frontend_destroy(&opened->cl);
    if (opened->queue != NULL) {
        clReleaseCommandQueue(opened->queue);
    }
    svo_device_destroy(&opened->device);
    opengl_close(&opened->gl);
    *opened = (session){0};
}
