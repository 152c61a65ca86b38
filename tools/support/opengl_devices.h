/* SPDX-License-Identifier: MIT */
/* The renderers in the output of `svocl devices`. */
#ifndef SVOCL_TOOLS_SUPPORT_OPENGL_DEVICES_H
#define SVOCL_TOOLS_SUPPORT_OPENGL_DEVICES_H

#include "support/json.h"
#include "svocl/svocl.h"

/* Adds "renderers", and "pairs": what works with each of the devices. */
void opengl_describe(cJSON *document, svo_device *const *devices, size_t device_count);

#endif
