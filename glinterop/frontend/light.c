/* SPDX-License-Identifier: MIT */
/* svo_gl_light_set_sources: the views of sources by rasterization, the rest by lib/light. */
#include "light/light.h"
#include "core/message.h"
#include "frontend/handle.h"
#include "raster/light_view.h"

#define FUNCTION "svo_gl_light_set_sources"

static svo_status check(const svo_gl *gl, const svo_light *light)
{
    const svo_tree_info *info = &light->tree->info;
    if (light->device != gl->device) {
        return svo_i_device_fail(gl->device, SVO_INVALID_ARGUMENT, FUNCTION ": the light is of another device");
    }
    if ((info->need & SVO_NEED_RAYS) == 0 || info->coverage == SVO_COVERAGE_THIN) {
        return svo_i_device_fail(gl->device, SVO_UNSUPPORTED,
                                 FUNCTION ": the tree has no triangles to draw: it is thin or without SVO_NEED_RAYS");
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
        return svo_i_device_fail(gl != NULL ? gl->device : NULL, SVO_INVALID_ARGUMENT, FUNCTION ": %s is NULL",
                                 gl == NULL ? "gl" : "light");
    }
    SVO_I_TRY(check(gl, light));
    if (gl->light_raster == NULL) {
        SVO_I_TRY(svo_i_light_raster_create(gl->device, gl->context, gl->share_choice, &gl->light_raster));
    }
    const svo_status status = shine(gl, light, setup, queue);
    if (status != SVO_OK) {
        svo_i_message_rename(&gl->device->message, FUNCTION);
    }
    return status;
}
