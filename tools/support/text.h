/* SPDX-License-Identifier: MIT */
/*
 * Texts of the program as UTF-8 and as JSON. File names are bytes; JSON and terminals want UTF-8: a byte that is not
 * part of it is shown as \xNN. Every JSON text begins with the program's version. And what logs of compilers say.
 */
#ifndef SVOCL_TOOLS_SUPPORT_TEXT_H
#define SVOCL_TOOLS_SUPPORT_TEXT_H

#include <cjson/cJSON.h>
#include <stdarg.h>
#include <stddef.h>

/* ---- UTF-8 ---- */

/* The bytes, 1 to 4, of the character that text begins with; 0: it begins with none (or is empty). */
size_t utf8_length(const char *text);

/* The text of a format, of any length, by malloc; NULL when out of memory. */
char *utf8_format(const char *format, va_list arguments) __attribute__((format(printf, 1, 0)));

/* The text with \xNN for each byte that belongs to no character, by malloc; NULL when out of memory. */
char *utf8_escape(const char *text);

/* ---- JSON ---- */

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

/* ---- logs of compilers ---- */

/* The registers of a kernel by the log that NVIDIA's compiler writes with -cl-nv-verbose; 0: it does not say. */
unsigned log_registers(const char *log, const char *kernel);

#endif
