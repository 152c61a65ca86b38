/* SPDX-License-Identifier: MIT */
/* Contexts of each way to ask for one, and what a pair has chosen. */
#ifndef SVOCL_TESTS_GL_CONTEXTS_H
#define SVOCL_TESTS_GL_CONTEXTS_H

#include <stdlib.h>
#include <string.h>

#include "svocl/gl.h"

static inline svo_status context_of_kind(svo_gl_context_kind kind, uint32_t device_index, svo_gl_context **out,
                                         svo_message *message)
{
    const svo_gl_context_options options = {.struct_size = sizeof options, .kind = kind, .device_index = device_index};
    return svo_gl_context_create(&options, out, message);
}

static inline svo_status context_of_name(const char *name, svo_gl_context **out, svo_message *message)
{
    const svo_gl_context_options options = {.struct_size = sizeof options, .device_name = name};
    return svo_gl_context_create(&options, out, message);
}

static inline svo_status context_for_device(const svo_device *device, svo_gl_context **out, svo_message *message)
{
    const svo_gl_context_options options = {.struct_size = sizeof options, .device = device};
    return svo_gl_context_create(&options, out, message);
}

/* The caller's, which is current. */
static inline svo_status context_wrap(svo_gl_get_proc_address find, svo_gl_context **out, svo_message *message)
{
    const svo_gl_context_options options = {
        .struct_size = sizeof options, .kind = SVO_GL_WRAPPED, .get_proc_address = find};
    return svo_gl_context_create(&options, out, message);
}

/* The value of that kind which the name is of; one that is of none ends the program. */
static inline uint32_t value_of_name(svo_name_kind kind, const char *name)
{
    uint32_t value = 0;
    while (strcmp(svo_name(kind, value), name) != 0) {
        if (++value == 8) {
            abort();
        }
    }
    return value;
}

static inline svo_gl_raster chosen_raster(svo_gl *gl)
{
    return (svo_gl_raster)value_of_name(SVO_NAME_GL_RASTER, svo_frontend_name(svo_gl_frontend(gl)));
}

static inline svo_gl_share chosen_share(svo_gl *gl)
{
    return (svo_gl_share)value_of_name(SVO_NAME_GL_SHARE, svo_frontend_share(svo_gl_frontend(gl)));
}

#endif
