/* SPDX-License-Identifier: MIT */
/* One-line error messages of the scenes and their writers. */
#ifndef SVOCL_TOOLS_SCENES_FAIL_H
#define SVOCL_TOOLS_SCENES_FAIL_H

#include <stdarg.h>
#include <stdio.h>

#include "svocl/status.h"

/* Writes the words into message (NULL allowed) and returns status. */
static inline svo_status __attribute__((format(printf, 3, 4)))
scene_fail(svo_message *message, svo_status status, const char *format, ...)
{
    if (message != NULL) {
        va_list arguments;
        va_start(arguments, format);
        (void)vsnprintf(message->text, sizeof message->text, format, arguments);
        va_end(arguments);
    }
    return status;
}

#endif
