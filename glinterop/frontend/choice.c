/* SPDX-License-Identifier: MIT */
/* Probes methods of rasterization when an svo_gl is created, and chooses one. */
#include "frontend/choice.h"

#include <stdio.h>

#include "core/message.h"
#include "raster/selftest.h"

/* Hardware-conservative rasterization where the extension exists and the self-test passes; else NULL and a reason. */
static svo_i_raster *try_hardware(svo_gl *gl)
{
    char *reason = gl->raster_reasons[SVO_GL_RASTER_HW];
    const char *missing = "";
    const svo_i_conservative method = svo_i_raster_hardware(svo_i_gl_context_functions(gl->context), &missing);
    if (method == SVO_I_CONSERVATIVE_EXPAND) {
        (void)snprintf(reason, SVO_I_GL_REASON_BYTES, "%s", missing);
        return NULL;
    }
    svo_i_raster *raster = NULL;
    if (svo_i_raster_create(gl->device, gl->context, method, gl->no_int64, &raster) != SVO_OK) {
        (void)snprintf(reason, SVO_I_GL_REASON_BYTES, "%.*s", SVO_I_GL_REASON_BYTES - 1, gl->device->message.text);
        return NULL;
    }
    svo_i_raster_selftest(gl->device, gl->context, raster, reason, SVO_I_GL_REASON_BYTES);
    if (reason[0] != '\0') {
        svo_i_raster_destroy(&raster);
    }
    return raster;
}

svo_status svo_i_gl_choose_raster(svo_gl *gl, svo_gl_raster asked)
{
    svo_i_raster *hardware = try_hardware(gl);
    if (asked == SVO_GL_RASTER_HW && hardware == NULL) {
        return svo_i_device_fail(gl->device, SVO_UNSUPPORTED, "svo_gl_create: gl-hw does not work: %s",
                                 gl->raster_reasons[SVO_GL_RASTER_HW]);
    }
    if (hardware != NULL && asked != SVO_GL_RASTER_EXPAND) {
        gl->raster = hardware;
        gl->raster_choice = SVO_GL_RASTER_HW;
        return SVO_OK;
    }
    svo_i_raster_destroy(&hardware);
    gl->raster_choice = SVO_GL_RASTER_EXPAND;
    return svo_i_raster_create(gl->device, gl->context, SVO_I_CONSERVATIVE_EXPAND, gl->no_int64, &gl->raster);
}
