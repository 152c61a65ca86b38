/* SPDX-License-Identifier: MIT */
/* Shared by the OpenCL half and the OpenGL half of svocl devices. */
#ifndef SVOCL_TOOLS_SUPPORT_DEVICES_H
#define SVOCL_TOOLS_SUPPORT_DEVICES_H

#include <CL/cl.h>

#include "support/json.h"

/* Adds a method and whether it works. reason: why not; "" if it works. */
void devices_add_method(cJSON *array, const char *name, const char *reason);

/* A text of a device, or without one of a platform, of any length, by malloc. "" where the driver does not tell it;
   NULL when out of memory. */
char *devices_text(cl_device_id device, cl_platform_id platform, cl_uint what);

#endif
