/* SPDX-License-Identifier: MIT */
/* cJSON writes bytes as they are, so they are made UTF-8 before it gets them. */
#include "support/json_text.h"

#include <stdlib.h>

#include "support/utf8.h"
#include "svocl/version.h"

cJSON *json_document(void)
{
    cJSON *document = cJSON_CreateObject();
    cJSON_AddStringToObject(document, "version", svo_version_string());
    return document;
}

cJSON *json_text(const char *text)
{
    char *escaped = utf8_escape(text);
    cJSON *item = escaped != NULL ? cJSON_CreateString(escaped) : NULL;
    free(escaped);
    return item;
}

void json_add_text(cJSON *object, const char *name, const char *text)
{
    cJSON_AddItemToObject(object, name, text != NULL ? json_text(text) : cJSON_CreateNull());
}
