/* SPDX-License-Identifier: MIT */
/*
 * svo_gl: one OpenCL device and one OpenGL context as a front end for svo_build, as a builder of trees, and for the
 * views of light.
 */
#include <stdio.h>

#include "commands/frontend.h"
#include "compute/build.h"
#include "compute/compute.h"
#include "compute/decide.h"
#include "core/message.h"
#include "core/struct_size.h"
#include "light/light.h"
#include "plan/arrays.h"
#include "plan/configuration.h"
#include "raster/light_view.h"
#include "raster/raster.h"
#include "raster/rasterize.h"
#include "raster/selftest.h"
#include "share/probe.h"
#include "share/share.h"
#include "stages/voxelize.h"

#define REASON_BYTES SVO_MESSAGE_BYTES /* reasons are messages, with names of drivers in them */
#define RASTERS      4

struct svo_gl {
    svo_device *device;
    svo_gl_context *context;
    bool no_int64;
    svo_gl_raster raster_choice;
    uint32_t most_columns; /* SVO_GL_RASTER_HYBRID: triangles of more are rasterized */
    svo_gl_share share_choice;
    /* "" for a method or path that works. */
    char raster_reasons[RASTERS][REASON_BYTES];
    svo_i_share_reasons share_reasons;
    svo_i_raster *raster;
    svo_frontend frontend;

    /* svo_gl_build. */
    char build_reason[REASON_BYTES]; /* the last answer of svo_gl_build_reason */
    svo_i_compute *compute; /* NULL until the first build */
    svo_frontend build_frontend; /* its list stays in OpenGL */

    svo_i_light_raster *light_raster; /* NULL until the first svo_gl_light_set_sources */
};

/* ---- the choice of a rasterization ---- */

/* Hardware-conservative rasterization where the extension exists and the self-test passes; else NULL and a reason. */
static svo_i_raster *try_hardware(svo_gl *gl)
{
    char *reason = gl->raster_reasons[SVO_GL_RASTER_HW];
    const char *missing = "";
    const svo_i_conservative method = svo_i_raster_hardware(svo_i_gl_context_functions(gl->context), &missing);
    if (method == SVO_I_CONSERVATIVE_EXPAND) {
        (void)snprintf(reason, REASON_BYTES, "%s", missing);
        return NULL;
    }
    svo_i_raster *raster = NULL;
    if (svo_i_raster_create(gl->device, gl->context, method, gl->no_int64, &raster) != SVO_OK) {
        (void)snprintf(reason, REASON_BYTES, "%.*s", REASON_BYTES - 1, gl->device->message.text);
        return NULL;
    }
    svo_i_raster_selftest(gl->device, gl->context, raster, reason, REASON_BYTES);
    if (reason[0] != '\0') {
        svo_i_raster_destroy(&raster);
    }
    return raster;
}

/* Fills the reasons of every method, sets the choice and creates gl->raster. Returns SVO_UNSUPPORTED, with the reason
   in the device's message, when a forced choice does not work, and the statuses of svo_i_raster_create. */
static svo_status choose_raster(svo_gl *gl, svo_gl_raster asked)
{
    svo_i_raster *hardware = try_hardware(gl);
    if (asked == SVO_GL_RASTER_HW && hardware == NULL) {
        return svo_i_device_fail(gl->device, SVO_UNSUPPORTED, "svo_gl_create: gl-hw does not work: %s",
                                 gl->raster_reasons[SVO_GL_RASTER_HW]);
    }
    const bool is_hybrid = asked == SVO_GL_RASTER_HYBRID;
    if (hardware != NULL && asked != SVO_GL_RASTER_EXPAND) {
        gl->raster = hardware;
        gl->raster_choice = is_hybrid ? SVO_GL_RASTER_HYBRID : SVO_GL_RASTER_HW;
        return SVO_OK;
    }
    svo_i_raster_destroy(&hardware);
    gl->raster_choice = is_hybrid ? SVO_GL_RASTER_HYBRID : SVO_GL_RASTER_EXPAND;
    return svo_i_raster_create(gl->device, gl->context, SVO_I_CONSERVATIVE_EXPAND, gl->no_int64, &gl->raster);
}

/* ---- the front end ---- */

const char *svo_gl_raster_reason(const svo_gl *gl, svo_gl_raster raster)
{
    return raster < RASTERS ? gl->raster_reasons[raster] : "unknown";
}

const char *svo_gl_share_reason(const svo_gl *gl, svo_gl_share share)
{
    return share < SVO_I_SHARES ? gl->share_reasons.text[share] : "unknown";
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
    const svo_i_rasterizer rasterizer = {
        .device = gl->device, .context = gl->context, .raster = gl->raster, .share = gl->share_choice};
    return svo_i_rasterize_list(&rasterizer, commands, chunking, list);
}

static void release(void *self, svo_i_fragment_list *list)
{
    (void)self;
    svo_i_rasterize_release(list);
}

/* ---- both front ends, each for the triangles that suit it ---- */

/* Whether triangles of a plan may be rasterized. */
static bool may_rasterize(const svo_gl *gl, const svo_plan *plan)
{
    return gl->most_columns != UINT32_MAX && plan->update == NULL && svo_i_rest_may_exist(plan, gl->most_columns);
}

/* Builds that wait rasterize; others have kernels alone, which issue the build's own commands. */
static svo_status prepare_hybrid(void *self, svo_plan *plan, svo_i_warm_up *warm_up)
{
    const svo_gl *gl = self;
    SVO_I_TRY(svo_i_voxelize_prepare(NULL, plan, warm_up));
    return may_rasterize(gl, plan) ? prepare(self, plan, warm_up) : SVO_OK;
}

/* Rasterizes the rest of the cut, then adds the other triangles. */
static svo_status voxelize_both(const svo_gl *gl, svo_i_commands *commands, const svo_i_chunking *chunking,
                                const svo_i_rest *rest, svo_i_fragment_list *list)
{
    svo_i_chunking others = *chunking;
    const svo_i_rasterizer rasterizer = {
        .device = gl->device, .context = gl->context, .raster = gl->raster, .share = gl->share_choice, .rest = rest};
    others.most_columns = gl->most_columns;
    SVO_I_TRY(svo_i_rasterize_list(&rasterizer, commands, &rest->chunking, list));
    return rest->others > 0 ? svo_i_voxelize_more(commands, &others, list) : SVO_OK;
}

static svo_status voxelize_hybrid(void *self, svo_i_commands *commands, const svo_i_chunking *chunking,
                                  svo_i_fragment_list *list)
{
    const svo_gl *gl = self;
    svo_i_rest rest = {0};
    svo_plan *plan = commands->plan;
    if (commands->mode != SVO_I_MODE_RUN || !may_rasterize(gl, plan)) {
        return svo_i_voxelize(NULL, commands, chunking, list);
    }
    const double start_ms = svo_i_now_ms();
    SVO_I_TRY(svo_i_plan_copy_to_host(plan));
    SVO_I_TRY(svo_i_rest_find(plan, chunking, gl->most_columns, &rest));
    svo_i_report_add(commands->report, SVO_STAGE_TRANSFER, svo_i_now_ms() - start_ms, "wall");
    const svo_status status = rest.item_count > 0 ? voxelize_both(gl, commands, chunking, &rest, list)
                                                  : svo_i_voxelize(NULL, commands, chunking, list);
    svo_i_rest_free(&rest);
    return status;
}

static void release_hybrid(void *self, svo_i_fragment_list *list)
{
    (void)self;
    for (uint32_t i = 0; i < list->chunk_count; ++i) {
        if (list->chunks[i].owner == NULL) {
            svo_i_buffer_release(&list->chunks[i].buffer);
        }
    }
    svo_i_rasterize_release(list);
}

static svo_status check_options(svo_device *device, const svo_gl_options *options)
{
    if ((unsigned)options->raster >= RASTERS || (unsigned)options->share >= SVO_I_SHARES) {
        return svo_i_device_fail(
            device, SVO_INVALID_ARGUMENT,
            "svo_gl_create: options.raster %d is not in 0 .. %d or options.share %d not in 0 .. %d",
            (int)options->raster, RASTERS - 1, (int)options->share, SVO_I_SHARES - 1);
    }
    return options->hybrid_columns == 0 || options->raster == SVO_GL_RASTER_HYBRID
               ? SVO_OK
               : svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                   "svo_gl_create: options.hybrid_columns %u is of SVO_GL_RASTER_HYBRID, and "
                                   "options.raster is %s",
                                   options->hybrid_columns, svo_name(SVO_NAME_GL_RASTER, options->raster));
}

/* Software draws no triangle faster than kernels do. */
static uint32_t hybrid_columns(svo_gl_context *context, const svo_gl_options *asked)
{
    const uint32_t usual =
        svo_i_gl_is_software(svo_i_gl_context_functions(context)) ? UINT32_MAX : (uint32_t)SVO_TILE_COLUMNS;
    return asked->hybrid_columns != 0 ? asked->hybrid_columns : usual;
}

static void fill_frontend(svo_gl *gl)
{
    gl->frontend = (svo_frontend){.name = svo_name(SVO_NAME_GL_RASTER, gl->raster_choice),
                                  .share = svo_name(SVO_NAME_GL_SHARE, gl->share_choice),
                                  .renderer = svo_i_gl_context_functions(gl->context)->renderer,
                                  .self = gl,
                                  .device = gl->device,
                                  .chunk_bytes_max = svo_i_share_limit_bytes(gl->device, gl->context),
                                  .prepare = prepare,
                                  .voxelize = voxelize,
                                  .release = release};
    if (gl->raster_choice == SVO_GL_RASTER_HYBRID) {
        gl->frontend.on_device = true;
        gl->frontend.prepare = prepare_hybrid;
        gl->frontend.voxelize = voxelize_hybrid;
        gl->frontend.release = release_hybrid;
    }
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
    gl->most_columns = hybrid_columns(context, &asked);
    SVO_I_TRY_CLEANUP(
        svo_i_share_choose(device, context, "svo_gl_create", asked.share, &gl->share_reasons, &gl->share_choice));
    SVO_I_TRY_CLEANUP(choose_raster(gl, asked.raster));
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

/* ---- svo_gl_build ---- */

/*
 * svo_gl_build: svo_build with a front end that keeps the list in OpenGL and builds the tree there (compute/build.c).
 */

/* Refuses a plan that the context cannot build, before anything is compiled. */
static svo_status check_limits(svo_gl *gl, const svo_plan *plan)
{
    char reason[REASON_BYTES];
    svo_i_compute_reason(gl->context, gl->no_int64, plan->work.made, reason, sizeof reason);
    if (reason[0] != '\0') {
        return svo_i_device_fail(plan->device, SVO_UNSUPPORTED, SVO_I_GL_BUILD ": %s", reason);
    }
    return svo_i_gl_check_size(gl->compute, plan);
}

static svo_status prepare_build(void *self, svo_plan *plan, svo_i_warm_up *warm_up)
{
    svo_gl *gl = self;
    SVO_I_TRY(prepare(self, plan, warm_up));
    return svo_i_compute_prepare(gl->compute, plan);
}

static svo_status voxelize_build(void *self, svo_i_commands *commands, const svo_i_chunking *chunking,
                                 svo_i_fragment_list *list)
{
    const svo_gl *gl = self;
    svo_i_gl_decider decider;
    const svo_i_rasterizer rasterizer = {.device = gl->device,
                                         .context = gl->context,
                                         .raster = gl->raster,
                                         .share = SVO_GL_SHARE_AUTO,
                                         .decider = svo_i_gl_decider_begin(&decider, gl->compute, commands->plan)};
    const svo_status status = svo_i_rasterize_list(&rasterizer, commands, chunking, list);
    svo_i_gl_decider_end(&decider);
    return status;
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
    gl->build_frontend.on_device = false;
    gl->build_frontend.builder = "gl-compute";
    gl->build_frontend.prepare = prepare_build;
    gl->build_frontend.voxelize = voxelize_build;
    gl->build_frontend.release = release;
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
                                 svo_name(SVO_NAME_BUILDER, plan->options.builder));
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

/* ---- svo_gl_light_set_sources ---- */

#define SET_SOURCES "svo_gl_light_set_sources"

static svo_status check_light(const svo_gl *gl, const svo_light *light)
{
    const svo_tree_info *info = &light->tree->info;
    if (light->device != gl->device) {
        return svo_i_device_fail(gl->device, SVO_INVALID_ARGUMENT, SET_SOURCES ": the light is of another device");
    }
    if ((info->need & SVO_NEED_RAYS) == 0 || info->coverage == SVO_COVERAGE_THIN) {
        return svo_i_device_fail(gl->device, SVO_UNSUPPORTED,
                                 SET_SOURCES
                                 ": the tree has no triangles to draw: it is thin or without SVO_NEED_RAYS");
    }
    return SVO_OK;
}

static svo_status shine(svo_gl *gl, svo_light *light, const svo_light_setup *setup, cl_command_queue queue)
{
    SVO_I_TRY(svo_i_gl_context_make_current(gl->context, &gl->device->message));
    const svo_i_photon_caster caster = svo_i_light_raster_begin(gl->light_raster, light->tree);
    const svo_status status = svo_i_light_set_sources_by(&caster, light, setup, queue);
    svo_i_light_raster_end(gl->light_raster);
    svo_i_gl_context_release_current(gl->context);
    return status;
}

svo_status svo_gl_light_set_sources(svo_gl *gl, svo_light *light, const svo_light_setup *setup, cl_command_queue queue)
{
    if (gl == NULL || light == NULL) {
        return svo_i_device_fail(gl != NULL ? gl->device : NULL, SVO_INVALID_ARGUMENT, SET_SOURCES ": %s is NULL",
                                 gl == NULL ? "gl" : "light");
    }
    SVO_I_TRY(check_light(gl, light));
    if (gl->light_raster == NULL) {
        SVO_I_TRY(svo_i_light_raster_create(gl->device, gl->context, gl->share_choice, &gl->light_raster));
    }
    const svo_status status = shine(gl, light, setup, queue);
    if (status != SVO_OK) {
        svo_i_message_rename(&gl->device->message, SET_SOURCES);
    }
    return status;
}
