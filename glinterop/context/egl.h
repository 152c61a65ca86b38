/* SPDX-License-Identifier: MIT */
/* Off-screen contexts by EGL, and what EGL has current on a thread. */
#ifndef SVO_GLINTEROP_CONTEXT_EGL_H
#define SVO_GLINTEROP_CONTEXT_EGL_H

#include "context/platform.h"

extern const svo_i_gl_platform svo_i_egl_platform;

/* The EGL devices of one machine: more are not looked at. */
#define SVO_I_EGL_DEVICES_MAX 32u

/* How many devices EGL lists. A failure, with *count 0: no libEGL, or it cannot be asked. */
svo_status svo_i_egl_count_devices(uint32_t *count, svo_message *message);

/* The same, and for each of the first devices, at most room, whether EGL says that it draws on the CPU. Makes no
   context. */
svo_status svo_i_egl_find_software(bool *software, uint32_t room, uint32_t *count, svo_message *message);

/* What the extensions of an EGL device say without a context: a CPU draws; a GPU must draw. NULL: EGL cannot say. */
bool svo_i_egl_device_is_software(const char *extensions);
bool svo_i_egl_device_is_gpu(const char *extensions);

/* What EGL has current on this thread. Handles are EGL's, without its types. */
typedef struct svo_i_egl_binding {
    bool loaded; /* the process has loaded libEGL, so there is something to restore */
    unsigned api;
    void *display, *context, *draw_surface, *read_surface; /* context: NULL when none is current */
} svo_i_egl_binding;

/* Reads what EGL has current and unbinds it. Does nothing when the process has not loaded libEGL. */
void svo_i_egl_binding_take(svo_i_egl_binding *binding);
/* Binds it again. */
void svo_i_egl_binding_restore(const svo_i_egl_binding *binding);

#endif
