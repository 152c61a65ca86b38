/* SPDX-License-Identifier: MIT */
/* File names are bytes; JSON and terminals want UTF-8. A byte that is not part of it is shown as \xNN. */
#ifndef SVOCL_TOOLS_SUPPORT_UTF8_H
#define SVOCL_TOOLS_SUPPORT_UTF8_H

#include <stdarg.h>
#include <stddef.h>

/* The bytes, 1 to 4, of the character that text begins with; 0: it begins with none (or is empty). */
size_t utf8_length(const char *text);

/* The text of a format, of any length, by malloc; NULL when out of memory. */
char *utf8_format(const char *format, va_list arguments) __attribute__((format(printf, 1, 0)));

/* The text with \xNN for each byte that belongs to no character, by malloc; NULL when out of memory. */
char *utf8_escape(const char *text);

#endif
