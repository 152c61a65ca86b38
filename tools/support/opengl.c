/* SPDX-License-Identifier: MIT */
/* An OpenGL context by the options, and the front end in it. */
#include "support/opengl.h"

#include <CL/cl_gl.h>
#include <stdio.h>
#include <stdlib.h>

#include "support/info_of.h"
#include "svocl/gl.h"

#define FURTHER_MAX 16

struct opengl {
    svo_device *device;
    svo_gl_context *context;
    svo_gl_context_info info;
    svo_gl *gl;
    svo_gl *hybrid; /* of opengl_hybrid_frontend */
    uint32_t hybrid_columns; /* as asked for; of hybrid, its own */
    svo_gl_share share; /* as asked for */
    struct {
        int frontend, share; /* as asked for */
        svo_gl *gl;
    } further[FURTHER_MAX];
    size_t further_count;
};

/* --gl-device, --context, or what suits the device best. */
static svo_status create_context(const options *given, const svo_device *device, svo_gl_context **out,
                                 svo_message *message)
{
    svo_gl_context_options asked = {.struct_size = sizeof asked, .device_name = given->gl_device};
    if (given->gl_device == NULL && given->context != OPTION_CONTEXT_AUTO) {
        asked.kind = (svo_gl_context_kind)given->context;
    } else if (given->gl_device == NULL) {
        asked.device = device;
    }
    return svo_gl_context_create(&asked, out, message);
}

/* A forced kind that does not work is an error. */
static bool open_context(const options *given, const svo_device *device, opengl *out, svo_message *reason)
{
    svo_message message = {""};
    if (create_context(given, device, &out->context, &message) != SVO_OK) {
        const bool forced = given->context != OPTION_CONTEXT_AUTO;
        snprintf(reason->text, sizeof reason->text, "%s%s%s%.900s", forced ? "--context " : "",
                 forced ? svo_name(SVO_NAME_GL_CONTEXT_KIND, (svo_gl_context_kind)given->context) : "",
                 forced ? ": " : "", program_words(message.text));
        return false;
    }
    out->info = (svo_gl_context_info)SVO_GL_CONTEXT_INFO_INIT;
    svo_gl_context_get_info(out->context, &out->info);
    return true;
}

static svo_gl_raster raster_of(int frontend)
{
    return frontend == OPTION_FRONTEND_GL_EXPAND   ? SVO_GL_RASTER_EXPAND
           : frontend == OPTION_FRONTEND_GL_HW     ? SVO_GL_RASTER_HW
           : frontend == OPTION_FRONTEND_GL_HYBRID ? SVO_GL_RASTER_HYBRID
                                                   : SVO_GL_RASTER_AUTO;
}

static svo_gl *create(opengl *opened, svo_gl_raster raster, svo_gl_share share, svo_message *reason)
{
    const svo_gl_options gl_options = {.struct_size = sizeof gl_options,
                                       .raster = raster,
                                       .share = share,
                                       .hybrid_columns = raster == SVO_GL_RASTER_HYBRID ? opened->hybrid_columns : 0};
    svo_gl *gl = NULL;
    if (svo_gl_create(opened->device, opened->context, &gl_options, &gl) != SVO_OK) {
        snprintf(reason->text, sizeof reason->text, "%s", program_words(svo_device_message(opened->device)));
    }
    return gl;
}

bool opengl_may_share(const svo_device *device)
{
    return svo_gl_device_may_share(device) != 0;
}

bool opengl_is_software(const options *given)
{
    return given->gl_device == NULL && given->context == OPTION_CONTEXT_AUTO && svo_gl_egl_is_software() != 0;
}

/* Whether the device's OpenCL context was created against one of OpenGL. */
static bool is_joined(const svo_device *device)
{
    enum { PROPERTIES_MAX = 64 };
    cl_context_properties properties[PROPERTIES_MAX] = {0};
    size_t bytes = 0;
    if (clGetContextInfo(info_of_device(device).context, CL_CONTEXT_PROPERTIES, sizeof properties, properties,
                         &bytes) != CL_SUCCESS) {
        return false;
    }
    bool found = false;
    for (size_t i = 0; i + 1 < bytes / sizeof properties[0] && properties[i] != 0; i += 2) {
        found = found || properties[i] == CL_GL_CONTEXT_KHR;
    }
    return found;
}

svo_device *opengl_join(const opengl *opened, const svo_device *device, const svo_device_options *device_options)
{
    svo_device *joined = NULL;
    if (!opengl_may_share(device)) {
        return NULL;
    }
    (void)svo_gl_device_create(opened->context, info_of_device(device).device, device_options, &joined, NULL);
    if (joined != NULL && !is_joined(joined)) {
        svo_device_destroy(&joined); /* a second handle of what there is */
    }
    return joined;
}

opengl *opengl_open(const options *given, const svo_device *device, svo_message *reason)
{
    opengl *opened = calloc(1, sizeof *opened);
    if (opened == NULL) {
        snprintf(reason->text, sizeof reason->text, "out of memory");
        return NULL;
    }
    if (!open_context(given, device, opened, reason)) {
        opengl_close(&opened);
    }
    return opened;
}

bool opengl_start(opengl *opened, const options *given, svo_device *device, svo_message *reason)
{
    opened->device = device;
    opened->hybrid_columns = given->hybrid_columns;
    opened->share = (svo_gl_share)given->share;
    opened->gl = create(opened, raster_of(given->frontend), (svo_gl_share)given->share, reason);
    return opened->gl != NULL;
}

void opengl_stop(opengl *opened)
{
    if (opened != NULL) {
        for (size_t i = 0; i < opened->further_count; ++i) {
            svo_gl_destroy(&opened->further[i].gl);
        }
        svo_gl_destroy(&opened->hybrid);
        svo_gl_destroy(&opened->gl);
    }
}

void opengl_close(opengl **opened)
{
    if (*opened == NULL) {
        return;
    }
    opengl_stop(*opened);
    svo_gl_context_destroy(&(*opened)->context);
    free(*opened);
    *opened = NULL;
}

const char *opengl_context_name(const opengl *opened)
{
    return svo_name(SVO_NAME_GL_CONTEXT_KIND, opened->info.kind);
}

const svo_device *opengl_device(const opengl *opened)
{
    return opened->device;
}

const char *opengl_renderer(const opengl *opened)
{
    return opened->info.renderer;
}

svo_status opengl_build(opengl *opened, svo_plan *plan, cl_command_queue queue, svo_tree **out,
                        svo_build_report *report)
{
    return svo_gl_build(opened->gl, plan, queue, out, report);
}

svo_frontend *opengl_frontend(opengl *opened)
{
    return svo_gl_frontend(opened->gl);
}

svo_frontend *opengl_prefer(opengl *opened, svo_frontend *cl, svo_message *reason)
{
    return svo_gl_prefer(opened->gl, cl, reason);
}

/* Made at the first call and kept. NULL with the reason on failure. */
static svo_gl *find_further(opengl *opened, int frontend, int share, svo_message *reason)
{
    for (size_t i = 0; i < opened->further_count; ++i) {
        if (opened->further[i].frontend == frontend && opened->further[i].share == share) {
            return opened->further[i].gl;
        }
    }
    if (opened->further_count == FURTHER_MAX) {
        snprintf(reason->text, sizeof reason->text, "more than %d front ends on one context", FURTHER_MAX);
        return NULL;
    }
    svo_gl *gl = create(opened, raster_of(frontend), (svo_gl_share)share, reason);
    if (gl != NULL) {
        opened->further[opened->further_count].frontend = frontend;
        opened->further[opened->further_count].share = share;
        opened->further[opened->further_count++].gl = gl;
    }
    return gl;
}

svo_frontend *opengl_further_frontend(opengl *opened, int frontend, int share, svo_message *reason)
{
    svo_gl *gl = find_further(opened, frontend, share, reason);
    return gl != NULL ? svo_gl_frontend(gl) : NULL;
}

svo_status opengl_further_build(opengl *opened, int frontend, int share, svo_plan *plan, cl_command_queue queue,
                                svo_tree **out, svo_build_report *report)
{
    svo_message reason;
    svo_gl *gl = find_further(opened, frontend, share, &reason);
    return gl != NULL ? svo_gl_build(gl, plan, queue, out, report) : SVO_NO_GL;
}

svo_frontend *opengl_hybrid_frontend(opengl *opened, uint32_t columns, svo_message *reason)
{
    svo_gl_destroy(&opened->hybrid);
    opened->hybrid_columns = columns;
    opened->hybrid = create(opened, SVO_GL_RASTER_HYBRID, opened->share, reason);
    return opened->hybrid != NULL ? svo_gl_frontend(opened->hybrid) : NULL;
}
