/* SPDX-License-Identifier: MIT */
/* Off-screen contexts by OSMesa, and what OSMesa has current on a thread. */
#ifndef SVO_GLINTEROP_CONTEXT_OSMESA_H
#define SVO_GLINTEROP_CONTEXT_OSMESA_H

#include "context/platform.h"

extern const svo_i_gl_platform svo_i_osmesa_platform;

/* What OSMesa has current on this thread, and the color buffer it draws to. */
typedef struct svo_i_osmesa_binding {
    void *context, *pixels; /* context: NULL when none is current */
    int width, height;
    unsigned pixel_type;
} svo_i_osmesa_binding;

/* Reads what OSMesa has current and unbinds it. Does nothing when the process has not loaded libOSMesa. */
void svo_i_osmesa_binding_take(svo_i_osmesa_binding *binding);
/* Binds it again. */
void svo_i_osmesa_binding_restore(const svo_i_osmesa_binding *binding);

#endif
