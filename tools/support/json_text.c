/* SPDX-License-Identifier: MIT */
/* cJSON writes bytes as they are, so they are made UTF-8 before it gets them. */
#include "support/json_text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

json_error json_error_at(const char *text, const char *at)
{
    json_error error = {.line = 1};
    const char *line = text;
    at += at[0] != '\0' ? strspn(at, " \t\r\n") : 0;
    for (const char *c = text; c < at; ++c) {
        if (*c == '\n') {
            ++error.line;
            line = c + 1;
        }
    }
    const unsigned column = (unsigned)(at - line) + 1;
    const int length = (int)strcspn(at, " \t\r\n,:]}");
    if (at[0] == '\0') {
        (void)snprintf(error.text, sizeof error.text, "not JSON at column %u, where the text ends", column);
    } else if (length == 0) {
        (void)snprintf(error.text, sizeof error.text, "not JSON at column %u, '%c'", column, at[0]);
    } else {
        (void)snprintf(error.text, sizeof error.text, "not JSON at column %u, '%.*s'", column,
                       length < 16 ? length : 16, at);
    }
    return error;
}

void json_add_text(cJSON *object, const char *name, const char *text)
{
    cJSON_AddItemToObject(object, name, text != NULL ? json_text(text) : cJSON_CreateNull());
}
