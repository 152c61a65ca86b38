/* SPDX-License-Identifier: MIT */
/* A text that grows in a buffer of fixed length; what does not fit is cut. */
#ifndef SVOCL_TOOLS_TUNE_TEXT_LIST_H
#define SVOCL_TOOLS_TUNE_TEXT_LIST_H

#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

typedef struct text_list {
    char *text;
    size_t bytes, used;
} text_list;

__attribute__((format(printf, 2, 3))) static inline void text_list_add(text_list *list, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(list->text + list->used, list->bytes - list->used, format, arguments);
    va_end(arguments);
    list->used = length < 0                                  ? list->used
                 : (size_t)length < list->bytes - list->used ? list->used + (size_t)length
                                                             : list->bytes - 1;
}

#endif
