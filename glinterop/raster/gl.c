/* SPDX-License-Identifier: MIT */
/*
 * svo_gl: one OpenCL device and one OpenGL context as a front end. Decides which way of rasterizing and which share
 * path are used, and hands the fragment list over.
 */
#include <stdlib.h>
#include <string.h>

#include "commands/frontend.h"
#include "plan/frontend_choice.h"
#include "compute/gl_build.h"
#include "core/struct_size.h"
#include "raster/gl_list.h"
#include "raster/raster.h"
#include "raster/selftest.h"
#include "share/share.h"
#include "plan/estimate.h"
#include "commands/timing.h"

#define REASON_BYTES 512
#define RASTERS      3
#define SHARES       4

struct svo_gl {
    svo_device *device;
    svo_gl_context *context;
    svo_gl_raster raster_choice;
    svo_gl_share share_choice;
    char raster_reasons[RASTERS][REASON_BYTES];
    char share_reasons[SHARES][REASON_BYTES];
    svo_i_raster *raster;
    svo_frontend frontend;
    bool no_int64;
    char build_reason[REASON_BYTES]; /* what svo_gl_build_reason last said */
    svo_i_compute *compute; /* NULL until svo_gl_build is first called */
    svo_frontend list_frontend; /* of svo_gl_build */
};

const char *svo_gl_raster_name(svo_gl_raster raster)
{
    static const char *const names[RASTERS] = {"auto", "gl-expand", "gl-hw"};
    return raster < RASTERS ? names[raster] : "unknown";
}

const char *svo_gl_share_name(svo_gl_share share)
{
    static const char *const names[SHARES] = {"auto", "interop", "host", "copy"};
    return share < SHARES ? names[share] : "unknown";
}

const char *svo_gl_raster_reason(const svo_gl *gl, svo_gl_raster raster)
{
    return raster < RASTERS ? gl->raster_reasons[raster] : "unknown";
}

const char *svo_gl_share_reason(const svo_gl *gl, svo_gl_share share)
{
    return share < SHARES ? gl->share_reasons[share] : "unknown";
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

/* Whether a renderer of that name draws on the CPU: Mesa's and SwiftShader say so in their names. */
static bool is_software(const char *renderer)
{
    static const char *const names[] = {"llvmpipe", "softpipe", "swrast", "SWR", "SwiftShader", "Software"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        if (strstr(renderer, names[i]) != NULL) {
            return true;
        }
    }
    return false;
}

svo_frontend *svo_gl_prefer(svo_gl *gl, svo_frontend *cl, svo_message *reason)
{
    const char *name = svo_i_gl_context_functions(gl->context)->renderer;
    const svo_i_renderer renderer = {
        .name = name, .is_software = is_software(name), .in_place = gl->share_choice != SVO_GL_SHARE_COPY};
    return svo_i_frontend_prefers_cl(gl->device, &renderer, reason) ? cl : &gl->frontend;
}

/* Hardware-conservative rasterization, where the extension exists and the self-test passes; NULL and a reason if
   not. */
static svo_i_raster *try_hardware(svo_gl *gl, bool no_int64)
{
    char *reason = gl->raster_reasons[SVO_GL_RASTER_HW];
    const char *missing = "";
    const svo_i_conservative method = svo_i_raster_hardware(svo_i_gl_context_functions(gl->context), &missing);
    if (method == SVO_I_CONSERVATIVE_EXPAND) {
        memcpy(reason, missing, strlen(missing) + 1);
        return NULL;
    }
    svo_i_raster *raster = NULL;
    if (svo_i_raster_create(gl->device, gl->context, method, no_int64, &raster) != SVO_OK) {
        memcpy(reason, gl->device->message.text, REASON_BYTES - 1);
        return NULL;
    }
    svo_i_raster_selftest(gl->device, gl->context, raster, reason, REASON_BYTES);
    if (reason[0] != '\0') {
        svo_i_raster_destroy(&raster);
    }
    return raster;
}

static svo_status choose_raster(svo_gl *gl, const svo_gl_options *options)
{
    const bool no_int64 = options->no_int64 != 0;
    svo_i_raster *hardware = try_hardware(gl, no_int64);
    if (options->raster == SVO_GL_RASTER_HW && hardware == NULL) {
        return svo_i_device_fail(gl->device, SVO_UNSUPPORTED, "svo_gl_create: gl-hw does not work: %s",
                                 gl->raster_reasons[SVO_GL_RASTER_HW]);
    }
    if (hardware != NULL && options->raster != SVO_GL_RASTER_EXPAND) {
        gl->raster = hardware;
        gl->raster_choice = SVO_GL_RASTER_HW;
        return SVO_OK;
    }
    svo_i_raster_destroy(&hardware);
    gl->raster_choice = SVO_GL_RASTER_EXPAND;
    return svo_i_raster_create(gl->device, gl->context, SVO_I_CONSERVATIVE_EXPAND, no_int64, &gl->raster);
}

static svo_status choose_share(svo_gl *gl, svo_gl_share asked)
{
    for (svo_gl_share share = SVO_GL_SHARE_INTEROP; share <= SVO_GL_SHARE_COPY; ++share) {
        svo_i_share_probe(gl->device, gl->context, share, gl->share_reasons[share], REASON_BYTES);
    }
    for (svo_gl_share share = SVO_GL_SHARE_INTEROP; share <= SVO_GL_SHARE_COPY; ++share) {
        const bool works = gl->share_reasons[share][0] == '\0';
        if (asked == share && !works) {
            return svo_i_device_fail(gl->device, SVO_UNSUPPORTED, "svo_gl_create: share %s does not work: %s",
                                     svo_gl_share_name(share), gl->share_reasons[share]);
        }
        if (works && (asked == share || asked == SVO_GL_SHARE_AUTO)) {
            gl->share_choice = share;
            return SVO_OK;
        }
    }
    return svo_i_device_fail(gl->device, SVO_UNSUPPORTED, "svo_gl_create: no share path works: %s",
                             gl->share_reasons[SVO_GL_SHARE_COPY]);
}

static svo_status prepare(void *self, svo_plan *plan, cl_command_queue queue)
{
    (void)queue;
    svo_gl *gl = self;
    svo_status status = svo_i_gl_context_make_current(gl->context, &gl->device->message);
    if (status == SVO_OK) {
        status = svo_i_raster_prepare(gl->raster, plan);
        svo_i_gl_context_release_current(gl->context);
    }
    return status;
}

/* A buffer for each chunk, given to GL. share: AUTO for a list that stays there. */
static svo_status make_chunks(svo_gl *gl, svo_gl_share share, const svo_plan *plan, const svo_i_chunking *layout,
                              cl_command_queue queue, svo_i_fragment_list *list)
{
    for (uint32_t i = 0; i < layout->chunk_count; ++i) {
        svo_i_fragments *chunk = &list->chunks[i];
        svo_i_share_buffer *shared = calloc(1, sizeof *shared);
        if (shared == NULL) {
            return svo_i_device_fail(gl->device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for %u chunks",
                                     layout->chunk_count);
        }
        chunk->owner = shared;
        chunk->capacity = layout->chunks[i].capacity;
        const size_t bytes = (size_t)chunk->capacity * svo_i_plan_fragment_bytes(plan);
        svo_status status = svo_i_share_buffer_create(gl->device, gl->context, share, bytes > 0 ? bytes : 4, shared);
        if (status == SVO_OK) {
            chunk->buffer = shared->memory;
            status = svo_i_share_buffer_to_gl(shared, queue);
        }
        if (status != SVO_OK) {
            return status;
        }
    }
    return SVO_OK;
}

/* Voxels of the bounding box of a triangle, with one to spare on every side. */
static double box_voxels(const svo_plan *plan, uint32_t triangle)
{
    const uint32_t *corners = plan->indices + (size_t)triangle * 3;
    const int32_t width = 1 << plan->info.depth;
    double voxels = 1.0;
    for (unsigned axis = 0; axis < 3; ++axis) {
        int32_t low = width, high = -1;
        for (unsigned corner = 0; corner < 3; ++corner) {
            const int32_t voxel = plan->vertices[(size_t)corners[corner] * 3 + axis] >> plan->voxel_log2;
            low = voxel < low ? voxel : low;
            high = voxel > high ? voxel : high;
        }
        low = low > 0 ? low : 0;
        high = high < width ? high : width;
        voxels *= high >= low ? (double)(high - low) + 3.0 : 3.0;
    }
    return voxels;
}

/* A list that was too small is made as large as the driver counted, so the count must be one that geometry allows. */
static svo_status check_count(svo_gl *gl, const svo_plan *plan, const svo_i_chunking *layout, uint32_t chunk,
                              uint32_t needed)
{
    const svo_i_chunk *target = &layout->chunks[chunk];
    double most = 0.0;
    for (uint32_t i = 0; needed > target->capacity && i < target->draw_count; ++i) {
        const svo_i_draw *draw = &layout->draws[target->first_draw + i];
        for (uint32_t item = 0; item < draw->item_count; ++item) {
            most += box_voxels(plan, plan->items[draw->first_item + item].triangle);
        }
    }
    if (needed > target->capacity && (double)needed > most) {
        return svo_i_device_fail(gl->device, SVO_GL_ERROR,
                                 "svo_build: %s counted %u fragments where at most %.0f are possible",
                                 svo_i_gl_context_functions(gl->context)->renderer, needed, most);
    }
    return SVO_OK;
}

static svo_status draw_chunks(svo_gl *gl, const svo_plan *plan, const svo_i_chunking *layout, svo_i_fragment_list *list)
{
    uint32_t *needed = calloc(layout->chunk_count + 1u, sizeof *needed);
    if (needed == NULL) {
        return svo_i_device_fail(gl->device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for %u counters",
                                 layout->chunk_count);
    }
    svo_status status = SVO_OK;
    for (uint32_t i = 0; i < layout->chunk_count && status == SVO_OK; ++i) {
        svo_i_share_buffer_bind(list->chunks[i].owner, SVO_I_RASTER_FRAGMENTS);
        status = svo_i_raster_draw(gl->raster, plan, layout, i);
    }
    if (status == SVO_OK) {
        status = svo_i_raster_finish(gl->raster, layout->chunk_count, needed);
    }
    for (uint32_t i = 0; i < layout->chunk_count && status == SVO_OK; ++i) {
        list->chunks[i].needed = needed[i];
        status = check_count(gl, plan, layout, i, needed[i]);
    }
    free(needed);
    return status;
}

/* Gives the written part of each chunk to OpenCL. */
static svo_status hand_over(const svo_plan *plan, cl_command_queue queue, svo_i_fragment_list *list)
{
    svo_status status = SVO_OK;
    for (uint32_t i = 0; i < list->chunk_count && status == SVO_OK; ++i) {
        const svo_i_fragments *chunk = &list->chunks[i];
        const uint64_t held = chunk->needed < chunk->capacity ? chunk->needed : chunk->capacity;
        status = svo_i_share_buffer_to_cl(chunk->owner, (size_t)held * svo_i_plan_fragment_bytes(plan), queue);
    }
    return status;
}

/* Draws the list by buffers of a share path, and hands it over; share AUTO: it stays in OpenGL. */
static svo_status voxelize_by(svo_gl *gl, svo_gl_share share, const svo_plan *plan, const svo_i_chunking *layout,
                              cl_command_queue queue, svo_i_fragment_list *list, svo_build_report *report)
{
    svo_status status = svo_i_gl_context_make_current(gl->context, &gl->device->message);
    if (status != SVO_OK) {
        return status;
    }
    double start_ms = svo_i_now_ms();
    status = make_chunks(gl, share, plan, layout, queue, list);
    if (status == SVO_OK) {
        status = svo_i_raster_upload(gl->raster, plan, layout->chunk_count);
    }
    svo_i_report_add(report, SVO_STAGE_TRANSFER, svo_i_now_ms() - start_ms, "wall");
    start_ms = svo_i_now_ms();
    if (status == SVO_OK) {
        status = draw_chunks(gl, plan, layout, list);
    }
    svo_i_report_add(report, SVO_STAGE_VOXELIZE, svo_i_now_ms() - start_ms, "wall");
    start_ms = svo_i_now_ms();
    if (status == SVO_OK && share != SVO_GL_SHARE_AUTO) {
        status = hand_over(plan, queue, list);
    }
    svo_i_report_add(report, SVO_STAGE_TRANSFER, svo_i_now_ms() - start_ms, "wall");
    svo_i_raster_drop(gl->raster);
    svo_i_gl_context_release_current(gl->context);
    return status;
}

static svo_status voxelize(void *self, svo_plan *plan, const svo_i_chunking *layout, cl_command_queue queue,
                           svo_i_fragment_list *list, svo_build_report *report)
{
    svo_gl *gl = self;
    return voxelize_by(gl, gl->share_choice, plan, layout, queue, list, report);
}

static void release(void *self, svo_i_fragment_list *list)
{
    (void)self;
    for (uint32_t i = 0; i < list->chunk_count; ++i) {
        if (list->chunks[i].owner != NULL) {
            svo_i_share_buffer_destroy(list->chunks[i].owner);
            free(list->chunks[i].owner);
        }
    }
    list->chunk_count = 0;
}

/* The front end of svo_gl_build: the list stays in OpenGL, and so does what is made of it until the tree is whole. */

static svo_status prepare_tree(void *self, svo_plan *plan, cl_command_queue queue)
{
    svo_gl *gl = self;
    char reason[REASON_BYTES];
    svo_i_compute_reason(gl->context, gl->no_int64, plan->work.made, reason, sizeof reason);
    if (reason[0] != '\0') {
        return svo_i_device_fail(gl->device, SVO_UNSUPPORTED, SVO_I_GL_BUILD ": %s", reason);
    }
    svo_status status = svo_i_gl_check_size(gl->compute, plan);
    if (status == SVO_OK) {
        status = prepare(self, plan, queue);
    }
    return status == SVO_OK ? svo_i_compute_prepare(gl->compute, plan) : status;
}

static svo_status voxelize_in_gl(void *self, svo_plan *plan, const svo_i_chunking *layout, cl_command_queue queue,
                                 svo_i_fragment_list *list, svo_build_report *report)
{
    return voxelize_by(self, SVO_GL_SHARE_AUTO, plan, layout, queue, list, report);
}

static svo_status make_tree(void *self, svo_i_build *build)
{
    svo_gl *gl = self;
    return svo_i_gl_make_tree(gl->compute, build);
}

svo_gl_context *svo_i_gl_context_of(svo_gl *gl)
{
    return gl->context;
}

svo_status svo_i_gl_list_frontend(svo_gl *gl, svo_frontend **out)
{
    if (gl->compute == NULL) {
        const svo_status status = svo_i_compute_create(gl->device, gl->context, gl->no_int64, &gl->compute);
        if (status != SVO_OK) {
            return status;
        }
        gl->list_frontend = gl->frontend;
        gl->list_frontend.share = "none";
        gl->list_frontend.builder = "gl-compute";
        gl->list_frontend.prepare = prepare_tree;
        gl->list_frontend.voxelize = voxelize_in_gl;
        gl->list_frontend.make_tree = make_tree;
    }
    *out = &gl->list_frontend;
    return SVO_OK;
}

const char *svo_gl_build_reason(svo_gl *gl, uint32_t need)
{
    svo_i_compute_reason(gl->context, gl->no_int64, need, gl->build_reason, REASON_BYTES);
    return gl->build_reason;
}

static svo_status check_options(svo_device *device, const svo_gl_options *options)
{
    if ((unsigned)options->raster >= RASTERS || (unsigned)options->share >= SHARES) {
        return svo_i_device_fail(
            device, SVO_INVALID_ARGUMENT,
            "svo_gl_create: options.raster %d is not in 0 .. %d or options.share %d not in 0 .. %d",
            (int)options->raster, RASTERS - 1, (int)options->share, SHARES - 1);
    }
    return SVO_OK;
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
    svo_status status = check_options(device, &asked);
    if (status != SVO_OK) {
        return status;
    }
    svo_gl *gl = calloc(1, sizeof *gl);
    if (gl == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "svo_gl_create: no memory for the handle");
    }
    gl->device = device;
    gl->context = context;
    gl->no_int64 = asked.no_int64 != 0;
    status = choose_share(gl, asked.share);
    if (status == SVO_OK) {
        status = choose_raster(gl, &asked);
    }
    if (status != SVO_OK) {
        svo_gl_destroy(&gl);
        return status;
    }
    gl->frontend = (svo_frontend){.name = svo_gl_raster_name(gl->raster_choice),
                                  .share = svo_gl_share_name(gl->share_choice),
                                  .renderer = svo_i_gl_context_functions(context)->renderer,
                                  .self = gl,
                                  .device = device,
                                  .chunk_bytes_max = svo_i_share_limit_bytes(device, context),
                                  .prepare = prepare,
                                  .voxelize = voxelize,
                                  .release = release};
    *out = gl;
    return SVO_OK;
}

void svo_gl_destroy(svo_gl **gl)
{
    if (gl == NULL || *gl == NULL) {
        return;
    }
    svo_i_raster_destroy(&(*gl)->raster);
    svo_i_compute_destroy(&(*gl)->compute);
    free(*gl);
    *gl = NULL;
}
