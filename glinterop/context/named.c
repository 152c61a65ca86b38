/* SPDX-License-Identifier: MIT */
/*
 * Chooses an EGL device by name. EGL names a device by its driver, if at all; only a context knows the renderer. So
 * this creates a context on each device and compares its renderer.
 */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "context/context.h"
#include "context/egl.h"
#include "core/message.h"

#define GPU "gpu"

static bool matches(const svo_gl_context *context, const char *device_name)
{
    if (strcasecmp(device_name, GPU) == 0) {
        return !svo_i_gl_is_software(&context->functions);
    }
    return svo_i_text_contains(context->functions.renderer, device_name);
}

/* Whether the name is an index, and which. */
static bool is_index(const char *device_name, uint32_t *index)
{
    unsigned value = 0;
    char rest = '\0';
    const bool found = strspn(device_name, "0123456789") == strlen(device_name) && strlen(device_name) <= 9 &&
                       sscanf(device_name, "%u%c", &value, &rest) == 1;
    *index = value;
    return found;
}

/* Appends "; 1: words" to a list, cut when it is full. */
static void add_line(svo_message *list, uint32_t index, const char *words)
{
    const size_t used = strlen(list->text);
    (void)snprintf(list->text + used, sizeof list->text - used, "%s%u: %s", used > 0 ? "; " : "", index, words);
}

/* *out: the device's context if it matches. Otherwise NULL, and a line of the list names its renderer or the failure.
   Fails where a next device would fail too; the list has the reason then. */
static svo_status try_device(uint32_t index, const char *device_name, const svo_gl_context_options *options,
                             svo_gl_context **out, svo_message *list)
{
    svo_message reason = {""};
    svo_gl_context *context = NULL;
    const svo_status status = svo_gl_context_create_with(SVO_GL_EGL_DEVICE, index, options, &context, &reason);
    if (status == SVO_OUT_OF_HOST_MEMORY || status == SVO_INVALID_ARGUMENT) {
        *list = reason;
        return status;
    }
    if (status != SVO_OK) {
        const char *words = strstr(reason.text, ": ");
        add_line(list, index, words != NULL ? words + 2 : reason.text);
    } else if (!matches(context, device_name)) {
        add_line(list, index, context->functions.renderer);
        svo_gl_context_destroy(&context);
    }
    *out = context;
    return SVO_OK;
}

svo_status svo_gl_context_create_named(const char *device_name, svo_gl_context **out, svo_message *message)
{
    return svo_gl_context_create_named_with(device_name, NULL, out, message);
}

svo_status svo_gl_context_create_named_with(const char *device_name, const svo_gl_context_options *options,
                                            svo_gl_context **out, svo_message *message)
{
    if (device_name == NULL || device_name[0] == '\0' || out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_gl_context_create_named: %s",
                          out == NULL ? "out is NULL" : "device_name is NULL or empty");
    }
    uint32_t index = 0;
    if (is_index(device_name, &index)) {
        return svo_gl_context_create_with(SVO_GL_EGL_DEVICE, index, options, out, message);
    }
    svo_message list = {""};
    uint32_t count = 0;
    SVO_I_TRY(svo_i_egl_count_devices(&count, message));
    for (index = 0; index < count; ++index) {
        svo_gl_context *context = NULL;
        const svo_status status = try_device(index, device_name, options, &context, &list);
        if (status != SVO_OK) {
            return svo_i_fail(message, status, "%s", list.text);
        }
        if (context != NULL) {
            *out = context;
            return SVO_OK;
        }
    }
    return svo_i_fail(message, SVO_NO_GL,
                      "svo_gl_context_create_named: no EGL device matches \"%.200s\"; found: %.700s", device_name,
                      count > 0 ? list.text : "none");
}
