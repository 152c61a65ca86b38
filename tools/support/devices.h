/* SPDX-License-Identifier: MIT */
/* Shared by the OpenCL half and the OpenGL half of svocl devices. */
#ifndef SVOCL_TOOLS_SUPPORT_DEVICES_H
#define SVOCL_TOOLS_SUPPORT_DEVICES_H

#include "support/json.h"

/* Adds a method and whether it works. reason: why not; "" if it works. */
void devices_add_method(cJSON *array, const char *name, const char *reason);

#endif
