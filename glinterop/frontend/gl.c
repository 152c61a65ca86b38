/* SPDX-License-Identifier: MIT */
/* svo_gl: one OpenCL device and one OpenGL context as a front end for svo_build. */
#include "frontend/handle.h"

#include "compute/builder.h"
#include "core/message.h"
#include "core/struct_size.h"
#include "frontend/choice.h"
#include "plan/configuration.h"
#include "raster/rasterize.h"
#include "share/share.h"

const char *svo_gl_raster_name(svo_gl_raster raster)
{
    static const char *const names[SVO_I_GL_RASTERS] = {"auto", "gl-expand", "gl-hw"};
    return raster < SVO_I_GL_RASTERS ? names[raster] : "unknown";
}

const char *svo_gl_share_name(svo_gl_share share)
{
    static const char *const names[SVO_I_SHARES] = {"auto", "interop", "host", "copy"};
    return share < SVO_I_SHARES ? names[share] : "unknown";
}

const char *svo_gl_raster_reason(const svo_gl *gl, svo_gl_raster raster)
{
    return raster < SVO_I_GL_RASTERS ? gl->raster_reasons[raster] : "unknown";
}

const char *svo_gl_share_reason(const svo_gl *gl, svo_gl_share share)
{
    return share < SVO_I_SHARES ? gl->share_reasons.text[share] : "unknown";
}

svo_gl_raster svo_gl_chosen_raster(const svo_gl *gl)
{
    return gl->raster_choice;
}

svo_gl_share svo_gl_chosen_share(const svo_gl *gl)
{
    return gl->share_choice;
}

svo_frontend *svo_gl_frontend(svo_gl *gl)
{
    return &gl->frontend;
}

svo_frontend *svo_gl_prefer(svo_gl *gl, svo_frontend *cl, svo_message *reason)
{
    const svo_i_gl_functions *functions = svo_i_gl_context_functions(gl->context);
    const svo_i_renderer renderer = {.name = functions->renderer,
                                     .is_software = svo_i_gl_is_software(functions),
                                     .in_place = gl->share_choice != SVO_GL_SHARE_COPY};
    return svo_i_frontend_prefers_cl(gl->device, &renderer, reason) ? cl : &gl->frontend;
}

static svo_status prepare(void *self, svo_plan *plan, svo_i_warm_up *warm_up)
{
    (void)warm_up; /* shaders are compiled at once */
    svo_gl *gl = self;
    SVO_I_TRY(svo_i_gl_context_make_current(gl->context, &gl->device->message));
    const svo_status status = svo_i_raster_prepare(gl->raster, plan);
    svo_i_gl_context_release_current(gl->context);
    return status;
}

static svo_status voxelize(void *self, svo_i_commands *commands, const svo_i_chunking *chunking,
                           svo_i_fragment_list *list)
{
    const svo_gl *gl = self;
    const svo_i_rasterizer rasterizer = {gl->device, gl->context, gl->raster, gl->share_choice};
    return svo_i_rasterize_list(&rasterizer, commands, chunking, list);
}

static void release(void *self, svo_i_fragment_list *list)
{
    (void)self;
    svo_i_rasterize_release(list);
}

static svo_status check_options(svo_device *device, const svo_gl_options *options)
{
    if ((unsigned)options->raster >= SVO_I_GL_RASTERS || (unsigned)options->share >= SVO_I_SHARES) {
        return svo_i_device_fail(
            device, SVO_INVALID_ARGUMENT,
            "svo_gl_create: options.raster %d is not in 0 .. %d or options.share %d not in 0 .. %d",
            (int)options->raster, SVO_I_GL_RASTERS - 1, (int)options->share, SVO_I_SHARES - 1);
    }
    return SVO_OK;
}

static void fill_frontend(svo_gl *gl)
{
    gl->frontend = (svo_frontend){.name = svo_gl_raster_name(gl->raster_choice),
                                  .share = svo_gl_share_name(gl->share_choice),
                                  .renderer = svo_i_gl_context_functions(gl->context)->renderer,
                                  .self = gl,
                                  .device = gl->device,
                                  .chunk_bytes_max = svo_i_share_limit_bytes(gl->device, gl->context),
                                  .prepare = prepare,
                                  .voxelize = voxelize,
                                  .release = release};
}

svo_status svo_gl_create(svo_device *device, svo_gl_context *context, const svo_gl_options *options, svo_gl **out)
{
    if (device == NULL || context == NULL || out == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "svo_gl_create: %s is NULL",
                                 device == NULL    ? "device"
                                 : context == NULL ? "context"
                                                   : "out");
    }
    svo_gl_options asked;
    SVO_I_TRY(svo_i_struct_read(&device->message, "svo_gl_create", "options", options, &asked,
                                SVO_I_STRUCT_SIZES(svo_gl_options, share)));
    SVO_I_TRY(check_options(device, &asked));
    svo_gl *gl = svo_i_alloc_zeroed(&device->memory, 1, sizeof *gl);
    if (gl == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "svo_gl_create: no memory for the handle");
    }
    svo_status status = SVO_OK;
    gl->device = device;
    gl->context = context;
    gl->no_int64 = asked.no_int64 != 0;
    SVO_I_TRY_CLEANUP(
        svo_i_share_choose(device, context, "svo_gl_create", asked.share, &gl->share_reasons, &gl->share_choice));
    SVO_I_TRY_CLEANUP(svo_i_gl_choose_raster(gl, asked.raster));
    fill_frontend(gl);
    *out = gl;
    gl = NULL;
cleanup:
    svo_gl_destroy(&gl);
    return status;
}

void svo_gl_destroy(svo_gl **gl)
{
    if (gl == NULL || *gl == NULL) {
        return;
    }
    svo_i_raster_destroy(&(*gl)->raster);
    svo_i_compute_destroy(&(*gl)->compute);
    svo_i_light_raster_destroy(&(*gl)->light_raster);
    svo_i_free(*gl);
    *gl = NULL;
}
