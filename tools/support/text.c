/* SPDX-License-Identifier: MIT */
/*
 * UTF-8 by table 3-7 of the Unicode Standard: neither overlong forms nor surrogates nor anything above U+10FFFF. cJSON
 * writes bytes as they are, so they are made UTF-8 before it gets them.
 */
#include "support/text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "svocl/version.h"

/* ---- UTF-8 ---- */

#define ESCAPED_BYTES 4 /* \xNN */

/* How many bytes a first byte announces, and what the second may be; 0: it is no first byte. */
static size_t announce(unsigned char first, unsigned char *second_min, unsigned char *second_max)
{
    *second_min = first == 0xe0 ? 0xa0 : first == 0xf0 ? 0x90 : 0x80;
    *second_max = first == 0xed ? 0x9f : first == 0xf4 ? 0x8f : 0xbf;
    return first == 0                       ? 0
           : first < 0x80                   ? 1
           : first >= 0xc2 && first <= 0xdf ? 2
           : first >= 0xe0 && first <= 0xef ? 3
           : first >= 0xf0 && first <= 0xf4 ? 4
                                            : 0;
}

size_t utf8_length(const char *text)
{
    const unsigned char *bytes = (const unsigned char *)text;
    unsigned char minimum, maximum;
    const size_t length = announce(bytes[0], &minimum, &maximum);
    for (size_t i = 1; i < length; ++i) {
        if (bytes[i] < minimum || bytes[i] > maximum) {
            return 0;
        }
        minimum = 0x80;
        maximum = 0xbf;
    }
    return length;
}

char *utf8_format(const char *format, va_list arguments)
{
    va_list again;
    va_copy(again, arguments);
    const int length = vsnprintf(NULL, 0, format, again);
    va_end(again);
    char *text = length >= 0 ? malloc((size_t)length + 1) : NULL;
    if (text != NULL) {
        (void)vsnprintf(text, (size_t)length + 1, format, arguments);
    }
    return text;
}

char *utf8_escape(const char *text)
{
    char *escaped = malloc(strlen(text) * ESCAPED_BYTES + 1);
    char *to = escaped;
    while (to != NULL && *text != '\0') {
        const size_t length = utf8_length(text);
        if (length > 0) {
            memcpy(to, text, length);
            to += length;
            text += length;
        } else {
            to += snprintf(to, ESCAPED_BYTES + 1, "\\x%02x", (unsigned)(unsigned char)*text++);
        }
    }
    if (to != NULL) {
        *to = '\0';
    }
    return escaped;
}

/* ---- JSON ---- */

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
    /* Where a name should begin, cJSON stops behind the first character; else it has passed all white space. */
    at -= at > text && at[0] != '\0' && strchr(" \t\r\n", at[0]) != NULL ? 1 : 0;
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

/* ---- logs of compilers ---- */

unsigned log_registers(const char *log, const char *kernel)
{
    static const char entry[] = "Compiling entry function '";
    const size_t length = strlen(kernel);
    for (const char *at = strstr(log, entry); at != NULL; at = strstr(at, entry)) {
        at += sizeof entry - 1;
        if (strncmp(at, kernel, length) == 0 && at[length] == '\'') {
            const char *end = strstr(at, entry);
            const char *used = strstr(at, "Used ");
            return used != NULL && (end == NULL || used < end) ? (unsigned)strtoul(used + sizeof "Used " - 1, NULL, 10)
                                                               : 0;
        }
    }
    return 0;
}
