/* SPDX-License-Identifier: MIT */
/* UTF-8 by table 3-7 of the Unicode Standard: neither overlong forms nor surrogates nor anything above U+10FFFF. */
#include "support/utf8.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
