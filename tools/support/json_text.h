/* SPDX-License-Identifier: MIT */
/* What every JSON text of the program has in common: it begins with the program's version, and it is UTF-8. */
#ifndef SVOCL_TOOLS_SUPPORT_JSON_TEXT_H
#define SVOCL_TOOLS_SUPPORT_JSON_TEXT_H

#include <cjson/cJSON.h>

/* A whole document: an object whose first member is "version". NULL when out of memory. */
cJSON *json_document(void);

/* A text with \xNN for each byte that is not UTF-8, as a file name may have. NULL when out of memory. */
cJSON *json_text(const char *text);

/* Where a text is not JSON: the line, and "not JSON at column 9, 'NaN'" for the rest of a message. */
typedef struct json_error {
    unsigned line;
    char text[64];
} json_error;

/* at: where the parser stopped, in text. */
json_error json_error_at(const char *text, const char *at);

/* text: NULL becomes null. */
void json_add_text(cJSON *object, const char *name, const char *text);

#endif
