/* SPDX-License-Identifier: MIT */
/* What the OpenCL half and the OpenGL half of svocl devices share. */
#ifndef SVOCL_TOOLS_SUPPORT_DEVICES_H
#define SVOCL_TOOLS_SUPPORT_DEVICES_H

#include "support/json.h"
#include "svocl/svocl.h"

/* Adds a method and whether it works. reason: why not; "" if it works. */
void devices_add_method(cJSON *array, const char *name, const char *reason);

/* Adds "renderers", and "pairs": what works with each of the devices. */
void opengl_describe(cJSON *document, svo_device *const *devices, size_t device_count);

#endif
