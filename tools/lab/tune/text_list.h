/* SPDX-License-Identifier: MIT */
/* A text that grows in a buffer that holds the longest command line: a path of PATH_MAX bytes, quoted, and options. */
#ifndef SVOCL_TOOLS_TUNE_TEXT_LIST_H
#define SVOCL_TOOLS_TUNE_TEXT_LIST_H

#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#define TEXT_LIST_BYTES 32768u

typedef struct text_list {
    char text[TEXT_LIST_BYTES];
    size_t used;
} text_list;

static inline void text_list_clear(text_list *list)
{
    list->text[0] = '\0';
    list->used = 0;
}

__attribute__((format(printf, 2, 3))) static inline void text_list_add(text_list *list, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(list->text + list->used, TEXT_LIST_BYTES - list->used, format, arguments);
    va_end(arguments);
    list->used = length < 0                                      ? list->used
                 : (size_t)length < TEXT_LIST_BYTES - list->used ? list->used + (size_t)length
                                                                 : TEXT_LIST_BYTES - 1;
}

#endif
