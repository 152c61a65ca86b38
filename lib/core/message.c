/* SPDX-License-Identifier: MIT */
/* Error messages, checked sizes. */
#include "core/message.h"

#include <stdio.h>
#include <string.h>

#include "core/limits.h"
#include "svocl/version.h"

svo_status svo_i_fail_v(svo_message *message, svo_status status, const char *format, va_list arguments)
{
    if (message != NULL) {
        (void)vsnprintf(message->text, sizeof message->text, format, arguments);
        for (char *c = message->text; *c != '\0'; ++c) {
            if (*c == '\n' || *c == '\r') {
                *c = ' ';
            }
        }
    }
    if (status == SVO_OUT_OF_HOST_MEMORY) {
        svo_i_limit_explain(message);
    }
    return status;
}

svo_status svo_i_fail(svo_message *message, svo_status status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    svo_i_fail_v(message, status, format, arguments);
    va_end(arguments);
    return status;
}

void svo_i_message_set(svo_message *message, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    svo_i_fail_v(message, SVO_OK, format, arguments);
    va_end(arguments);
}

void svo_i_message_rename(svo_message *message, const char *function)
{
    if (message == NULL) {
        return;
    }
    const svo_message inner = *message;
    const size_t name_length = strcspn(inner.text, ": ");
    const bool has_name = strncmp(inner.text + name_length, ": ", 2) == 0;
    svo_i_message_set(message, "%s: %s", function, has_name ? inner.text + name_length + 2 : inner.text);
}

bool svo_i_mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b) {
        return false;
    }
    *out = a * b;
    return true;
}

bool svo_i_add_size(size_t a, size_t b, size_t *out)
{
    if (a > SIZE_MAX - b) {
        return false;
    }
    *out = a + b;
    return true;
}

const char *svo_version_string(void)
{
    return SVO_VERSION_STRING;
}
