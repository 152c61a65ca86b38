/* SPDX-License-Identifier: MIT */
/*
 * svo_gl_build: svo_build with a front end that keeps the list in OpenGL and builds the tree there (compute/build.c).
 */
#include "compute/build.h"
#include "compute/builder.h"
#include "compute/program.h"
#include "core/message.h"
#include "frontend/handle.h"
#include "raster/rasterize.h"

/* Refuses a plan that the context cannot build, before anything is compiled. */
static svo_status check_limits(svo_gl *gl, const svo_plan *plan)
{
    char reason[SVO_I_GL_REASON_BYTES];
    svo_i_compute_reason(gl->context, gl->no_int64, plan->work.made, reason, sizeof reason);
    if (reason[0] != '\0') {
        return svo_i_device_fail(plan->device, SVO_UNSUPPORTED, SVO_I_GL_BUILD ": %s", reason);
    }
    return svo_i_gl_check_size(gl->compute, plan);
}

static svo_status prepare(void *self, svo_plan *plan, svo_i_warm_up *warm_up)
{
    svo_gl *gl = self;
    SVO_I_TRY(gl->frontend.prepare(self, plan, warm_up));
    return svo_i_compute_prepare(gl->compute, plan);
}

static svo_status voxelize(void *self, svo_i_commands *commands, const svo_i_chunking *chunking,
                           svo_i_fragment_list *list)
{
    const svo_gl *gl = self;
    const svo_i_rasterizer rasterizer = {gl->device, gl->context, gl->raster, SVO_GL_SHARE_AUTO};
    return svo_i_rasterize_list(&rasterizer, commands, chunking, list);
}

static svo_status make_tree(void *self, svo_i_build *build)
{
    svo_gl *gl = self;
    return svo_i_gl_make_tree(gl->compute, build);
}

static svo_status create_builder(svo_gl *gl)
{
    SVO_I_TRY(svo_i_compute_create(gl->device, gl->context, &gl->compute));
    gl->build_frontend = gl->frontend;
    gl->build_frontend.share = "none";
    gl->build_frontend.builder = "gl-compute";
    gl->build_frontend.prepare = prepare;
    gl->build_frontend.voxelize = voxelize;
    gl->build_frontend.make_tree = make_tree;
    return SVO_OK;
}

const char *svo_gl_build_reason(svo_gl *gl, uint32_t need)
{
    svo_i_compute_reason(gl->context, gl->no_int64, need, gl->build_reason, sizeof gl->build_reason);
    return gl->build_reason;
}

static svo_status build_current(svo_gl *gl, svo_plan *plan, cl_command_queue queue, svo_tree **out,
                                svo_build_report *report)
{
    SVO_I_TRY(svo_i_gl_context_make_current(gl->context, &plan->device->message));
    const svo_status status = svo_build(plan, &gl->build_frontend, queue, out, report);
    svo_i_gl_context_release_current(gl->context);
    return status;
}

svo_status svo_gl_build(svo_gl *gl, svo_plan *plan, cl_command_queue queue, svo_tree **out, svo_build_report *report)
{
    if (gl == NULL || plan == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (plan->options.builder != SVO_BUILDER_CL) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, SVO_I_GL_BUILD ": the plan asks for builder %s",
                                 svo_builder_name(plan->options.builder));
    }
    if (gl->compute == NULL) {
        SVO_I_TRY(create_builder(gl));
    }
    SVO_I_TRY(check_limits(gl, plan));
    const svo_status status = build_current(gl, plan, queue, out, report);
    if (status != SVO_OK) {
        svo_i_message_rename(&plan->device->message, SVO_I_GL_BUILD);
    }
    return status;
}
