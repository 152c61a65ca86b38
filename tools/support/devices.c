/* SPDX-License-Identifier: MIT */
/* JSON output that both halves of `svocl devices` use. */
#include "support/devices.h"

#include <stdlib.h>

void devices_add_method(cJSON *array, const char *name, const char *reason)
{
    cJSON *method = cJSON_CreateObject();
    json_add_text(method, "name", name);
    cJSON_AddBoolToObject(method, "works", reason[0] == '\0');
    json_add_text(method, "reason", reason);
    cJSON_AddItemToArray(array, method);
}

static cl_int query(cl_device_id device, cl_platform_id platform, cl_uint what, size_t bytes, char *text,
                    size_t *needed)
{
    return device != NULL ? clGetDeviceInfo(device, what, bytes, text, needed)
                          : clGetPlatformInfo(platform, what, bytes, text, needed);
}

char *devices_text(cl_device_id device, cl_platform_id platform, cl_uint what)
{
    size_t bytes = 0;
    const cl_int error = query(device, platform, what, 0, NULL, &bytes);
    char *text = calloc(1, (error == CL_SUCCESS ? bytes : 0) + 1);
    if (text != NULL && error == CL_SUCCESS && bytes > 0) {
        (void)query(device, platform, what, bytes, text, NULL);
    }
    return text;
}
