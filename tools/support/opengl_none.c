/* SPDX-License-Identifier: MIT */
/* Replaces opengl.c and opengl_devices.c in a build without svocl::gl: no OpenGL is available. */
#include <stdio.h>

#include "support/opengl.h"
#include "support/opengl_devices.h"

#define WITHOUT "this svocl was built without OpenGL"

bool opengl_is_software(const options *given)
{
    (void)given;
    return false;
}

bool opengl_may_share(const svo_device *device)
{
    (void)device;
    return false;
}

opengl *opengl_open(const options *given, const svo_device *device, svo_message *reason)
{
    (void)given;
    (void)device;
    snprintf(reason->text, sizeof reason->text, WITHOUT);
    return NULL;
}

void opengl_stop(opengl *opened)
{
    (void)opened;
}

void opengl_close(opengl **opened)
{
    *opened = NULL;
}

/* No context ever opens, so nothing below is called with one. */

svo_device *opengl_join(const opengl *opened, const svo_device *device, const svo_device_options *device_options)
{
    (void)opened;
    (void)device;
    (void)device_options;
    return NULL;
}

bool opengl_start(opengl *opened, const options *given, svo_device *device, svo_message *reason)
{
    (void)opened;
    (void)given;
    (void)device;
    snprintf(reason->text, sizeof reason->text, WITHOUT);
    return false;
}

const char *opengl_context_name(const opengl *opened)
{
    (void)opened;
    return "none";
}

const svo_device *opengl_device(const opengl *opened)
{
    (void)opened;
    return NULL;
}

const char *opengl_renderer(const opengl *opened)
{
    (void)opened;
    return "none";
}

svo_frontend *opengl_frontend(opengl *opened)
{
    (void)opened;
    return NULL;
}

svo_status opengl_build(opengl *opened, svo_plan *plan, cl_command_queue queue, svo_tree **out,
                        svo_build_report *report)
{
    (void)opened;
    (void)plan;
    (void)queue;
    (void)out;
    (void)report;
    return SVO_NO_GL;
}

svo_frontend *opengl_prefer(opengl *opened, svo_frontend *cl, svo_message *reason)
{
    (void)opened;
    snprintf(reason->text, sizeof reason->text, WITHOUT);
    return cl;
}

svo_frontend *opengl_further_frontend(opengl *opened, int frontend, int share, svo_message *reason)
{
    (void)opened;
    (void)frontend;
    (void)share;
    snprintf(reason->text, sizeof reason->text, WITHOUT);
    return NULL;
}

svo_status opengl_further_build(opengl *opened, int frontend, int share, svo_plan *plan, cl_command_queue queue,
                                svo_tree **out, svo_build_report *report)
{
    (void)frontend;
    (void)share;
    return opengl_build(opened, plan, queue, out, report);
}

svo_frontend *opengl_hybrid_frontend(opengl *opened, uint32_t columns, svo_message *reason)
{
    (void)opened;
    (void)columns;
    snprintf(reason->text, sizeof reason->text, WITHOUT);
    return NULL;
}

void opengl_describe(cJSON *document, svo_device *const *devices, size_t device_count)
{
    (void)devices;
    (void)device_count;
    cJSON_AddArrayToObject(document, "renderers");
    cJSON_AddArrayToObject(document, "pairs");
}
