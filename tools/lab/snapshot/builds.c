/* SPDX-License-Identifier: MIT */
/* Opens the devices of builds, and runs one build by one method. */
#include "builds.h"

#include "support/info_of.h"

#define SCRATCH_OFFSET_UNITS 3 /* how far into its buffer the caller's scratch begins, in alignments */

/* Any context renders the same. */
static void open_opengl(opened *out)
{
    for (int kind = 0; kind < SVO_GL_CONTEXT_KINDS && out->context == NULL; ++kind) {
        const svo_gl_context_options asked = {.struct_size = sizeof asked, .kind = (svo_gl_context_kind)kind};
        (void)svo_gl_context_create(&asked, &out->context, NULL);
    }
    if (out->context == NULL) {
        return;
    }
    svo_gl_options options = {.struct_size = sizeof options, .raster = SVO_GL_RASTER_EXPAND};
    options.share = SVO_GL_SHARE_HOST;
    (void)svo_gl_create(out->device, out->context, &options, &out->host);
    options.share = SVO_GL_SHARE_COPY;
    (void)svo_gl_create(out->device, out->context, &options, &out->copy);
}

svo_status opened_create(opened *out, svo_message *message)
{
    *out = (opened){0};
    svo_status status = svo_device_create_default(NULL, &out->device, message);
    if (status != SVO_OK) {
        return status;
    }
    const svo_device_info on = info_of_device(out->device);
    cl_int error = CL_SUCCESS;
    out->queue = clCreateCommandQueue(on.context, on.device, CL_QUEUE_PROFILING_ENABLE, &error);
    if (error != CL_SUCCESS) {
        status = SVO_CL_ERROR;
        goto cleanup;
    }
    status = svo_frontend_create_cl(out->device, &out->cl);
    if (status != SVO_OK) {
        goto cleanup;
    }
    open_opengl(out);
cleanup:
    if (status != SVO_OK) {
        opened_release(out);
    }
    return status;
}

void opened_release(opened *released)
{
    svo_gl_destroy(&released->copy);
    svo_gl_destroy(&released->host);
    svo_frontend_destroy(&released->cl);
    if (released->queue != NULL) {
        clReleaseCommandQueue(released->queue);
    }
    svo_device_destroy(&released->device);
    svo_gl_context_destroy(&released->context);
    *released = (opened){0};
}

static svo_frontend *frontend_of(const opened *session, method_front front)
{
    if (front == FRONT_CL) {
        return session->cl;
    }
    svo_gl *gl = front == FRONT_GL_HOST ? session->host : session->copy;
    return gl != NULL ? svo_gl_frontend(gl) : NULL;
}

/* The caller's scratch, larger than needed and used from an offset on. */
static svo_status make_scratch(const opened *session, svo_frontend *frontend, build *out,
                               svo_workspace_options *options)
{
    const svo_status status = svo_workspace_measure(out->plan, frontend, &out->room);
    if (status != SVO_OK) {
        return status;
    }
    cl_int error = CL_SUCCESS;
    options->offset_bytes = out->room.scratch_alignment * SCRATCH_OFFSET_UNITS;
    out->scratch = clCreateBuffer(info_of_device(session->device).context, CL_MEM_READ_WRITE,
                                  (size_t)(options->offset_bytes + out->room.scratch_bytes), NULL, &error);
    options->scratch = out->scratch;
    return error == CL_SUCCESS ? SVO_OK : SVO_OUT_OF_DEVICE_MEMORY;
}

static svo_status make_workspace(const opened *session, svo_frontend *frontend, method_mode mode, build *out)
{
    svo_workspace_options options = {.struct_size = sizeof options};
    svo_status status = mode == MODE_TWICE ? make_scratch(session, frontend, out, &options) : SVO_OK;
    if (status != SVO_OK) {
        return status;
    }
    status = svo_workspace_create(out->plan, frontend, session->queue, &options, &out->workspace);
    if (status != SVO_OK) {
        return status;
    }
    svo_workspace_get_info(out->workspace, &out->room);
    status = svo_workspace_make_tree(out->workspace, &out->tree);
    out->counts[PART_WORKSPACE] = count_calls_take();
    return status;
}

static svo_status run_enqueued(const opened *session, svo_frontend *frontend, method_mode mode, build *out)
{
    svo_status status = make_workspace(session, frontend, mode, out);
    if (status != SVO_OK) {
        return status;
    }
    if (mode == MODE_TWICE) {
        status = svo_build_enqueue(out->workspace, out->tree, &(svo_submit){.queue = session->queue});
        if (status != SVO_OK) {
            return status;
        }
        status = svo_tree_finish(out->tree, session->queue, 0, &out->report);
        if (status != SVO_OK) {
            return status;
        }
    }
    status = svo_build_enqueue(out->workspace, out->tree, &(svo_submit){.queue = session->queue});
    if (status != SVO_OK) {
        return status;
    }
    out->counts[PART_ENQUEUE] = count_calls_take();
    return svo_tree_finish(out->tree, session->queue, mode != MODE_ENQUEUED, &out->report);
}

static svo_status run_mode(const opened *session, svo_frontend *frontend, const method *by, build *out)
{
    switch (by->mode) {
    case MODE_BLOCKING:
    case MODE_COUNTED:
        return svo_build(out->plan, frontend, session->queue, &out->tree, &out->report);
    case MODE_GL_COMPUTE:
        return svo_gl_build(session->host, out->plan, session->queue, &out->tree, &out->report);
    case MODE_ENQUEUED:
    case MODE_TRIMMED:
    case MODE_TWICE:
        break;
    }
    return run_enqueued(session, frontend, by->mode, out);
}

svo_status build_run(const opened *session, const svo_mesh *mesh, const request *wanted, const method *by, build *out)
{
    *out = (build){.room = SVO_WORKSPACE_INFO_INIT, .report = SVO_BUILD_REPORT_INIT};
    svo_frontend *frontend = frontend_of(session, by->front);
    if (frontend == NULL) {
        return SVO_UNSUPPORTED;
    }
    (void)count_calls_take();
    const svo_plan_options options = request_options(wanted, by->builder);
    svo_status status = svo_plan_create(session->device, mesh, wanted->depth, &options, &out->plan);
    if (status != SVO_OK) {
        return status;
    }
    if (by->mode == MODE_COUNTED) {
        status = svo_plan_count(out->plan, frontend, session->queue);
        if (status != SVO_OK) {
            return status;
        }
    }
    out->counts[PART_PLAN] = count_calls_take();
    status = run_mode(session, frontend, by, out);
    out->counts[PART_BUILD] = count_calls_take();
    return status;
}

/* A tree of a build in flight must be finished before its workspace goes; build_run has finished or failed. */
void build_release(build *finished)
{
    svo_tree_destroy(&finished->tree);
    svo_workspace_destroy(&finished->workspace);
    svo_plan_destroy(&finished->plan);
    if (finished->scratch != NULL) {
        clReleaseMemObject(finished->scratch);
    }
    *finished = (build){0};
}
