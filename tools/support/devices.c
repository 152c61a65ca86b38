/* SPDX-License-Identifier: MIT */
/* JSON output that both halves of `svocl devices` use. */
#include "support/devices.h"

void devices_add_method(cJSON *array, const char *name, const char *reason)
{
    cJSON *method = cJSON_CreateObject();
    json_add_text(method, "name", name);
    cJSON_AddBoolToObject(method, "works", reason[0] == '\0');
    json_add_text(method, "reason", reason);
    cJSON_AddItemToArray(array, method);
}
