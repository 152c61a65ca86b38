/* SPDX-License-Identifier: MIT */
/* The OpenGL half of svocl devices: every kind of context, and what works on its pair with each OpenCL device. */
#include "support/opengl_devices.h"

#include <stdio.h>

#include "support/devices.h"
#include "support/info_of.h"
#include "svocl/gl.h"

#define RENDERERS_MAX 32

/* Working contexts, open until the pairs are probed. */
typedef struct open_renderers {
    svo_gl_context *contexts[RENDERERS_MAX];
    size_t count;
} open_renderers;

static void gather_renderer(cJSON *renderers, svo_gl_context_kind kind, uint32_t device_index, open_renderers *opened)
{
    svo_message message = {""};
    svo_gl_context *context = NULL;
    svo_gl_context_info info = SVO_GL_CONTEXT_INFO_INIT;
    const svo_gl_context_options asked = {.struct_size = sizeof asked, .kind = kind, .device_index = device_index};
    if (opened->count < RENDERERS_MAX) {
        if (svo_gl_context_create(&asked, &context, &message) == SVO_OK) {
            svo_gl_context_get_info(context, &info);
            opened->contexts[opened->count++] = context;
        }
    } else {
        snprintf(message.text, sizeof message.text, "not probed: more than %d renderers", RENDERERS_MAX);
    }
    cJSON *object = cJSON_CreateObject();
    json_add_text(object, "context", svo_name(SVO_NAME_GL_CONTEXT_KIND, kind));
    json_add_count(object, "device_index", device_index);
    cJSON_AddBoolToObject(object, "works", context != NULL);
    json_add_text(object, "reason", program_words(message.text));
    json_add_text(object, "vendor", info.vendor);
    json_add_text(object, "renderer", info.renderer);
    json_add_text(object, "version", info.version);
    cJSON_AddItemToArray(renderers, object);
}

static void gather_renderers(cJSON *document, open_renderers *opened)
{
    cJSON *renderers = cJSON_AddArrayToObject(document, "renderers");
    gather_renderer(renderers, SVO_GL_SURFACELESS, 0, opened);
    const uint32_t egl_devices = svo_gl_egl_device_count();
    for (uint32_t i = 0; i < egl_devices || i == 0; ++i) { /* at least once, for the reason */
        gather_renderer(renderers, SVO_GL_EGL_DEVICE, i, opened);
    }
    gather_renderer(renderers, SVO_GL_OSMESA, 0, opened);
}

static cJSON *gather_pair(svo_device *alone, svo_gl_context *renderer)
{
    /* The same device on an OpenCL context that can share with the renderer; NULL if there is none. */
    svo_device *joined = NULL;
    const svo_device_info on = info_of_device(alone);
    const svo_device_options device_options = {.struct_size = sizeof device_options, .path = on.path};
    (void)svo_gl_device_create(renderer, on.device, &device_options, &joined, NULL);
    svo_device *device = joined != NULL ? joined : alone;
    svo_gl_context_info info = SVO_GL_CONTEXT_INFO_INIT;
    svo_gl_context_get_info(renderer, &info);
    cJSON *pair = cJSON_CreateObject();
    json_add_text(pair, "device", info_of_device(device).name);
    json_add_text(pair, "renderer", info.renderer);
    json_add_text(pair, "context", svo_name(SVO_NAME_GL_CONTEXT_KIND, info.kind));
    json_add_count(pair, "device_index", info.device_index);
    cJSON *frontends = cJSON_AddArrayToObject(pair, "frontends");
    cJSON *shares = cJSON_AddArrayToObject(pair, "shares");
    svo_gl *gl = NULL;
    /* Why no method works; NULL if some may. */
    const char *failure = NULL;
    if (svo_gl_create(device, renderer, NULL, &gl) != SVO_OK) {
        failure = program_words(svo_device_message(device));
    }
    for (svo_gl_raster raster = SVO_GL_RASTER_EXPAND; raster <= SVO_GL_RASTER_HW; ++raster) {
        devices_add_method(frontends, svo_name(SVO_NAME_GL_RASTER, raster),
                           failure != NULL ? failure : svo_gl_raster_reason(gl, raster));
    }
    for (svo_gl_share share = SVO_GL_SHARE_INTEROP; share <= SVO_GL_SHARE_COPY; ++share) {
        devices_add_method(shares, svo_name(SVO_NAME_GL_SHARE, share),
                           failure != NULL ? failure : svo_gl_share_reason(gl, share));
    }
    cJSON *builders = cJSON_AddArrayToObject(pair, "builders");
    devices_add_method(builders, "cl", ""); /* these two do not depend on OpenGL */
    devices_add_method(builders, "sorted", "");
    devices_add_method(builders, "gl-compute", failure != NULL ? failure : svo_gl_build_reason(gl, SVO_NEED_ALL));
    svo_gl_destroy(&gl);
    svo_device_destroy(&joined);
    return pair;
}

void opengl_describe(cJSON *document, svo_device *const *devices, size_t device_count)
{
    open_renderers opened = {.count = 0};
    gather_renderers(document, &opened);
    cJSON *pairs = cJSON_AddArrayToObject(document, "pairs");
    for (size_t d = 0; d < device_count; ++d) {
        for (size_t r = 0; r < opened.count; ++r) {
            cJSON_AddItemToArray(pairs, gather_pair(devices[d], opened.contexts[r]));
        }
    }
    for (size_t i = 0; i < opened.count; ++i) {
        svo_gl_context_destroy(&opened.contexts[i]);
    }
}
