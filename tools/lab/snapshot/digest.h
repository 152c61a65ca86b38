/* SPDX-License-Identifier: MIT */
/* The lines of a snapshot: NAME<TAB>VALUE, the value a digest (XXH3-128 in hexadecimal) or the exact text. */
#ifndef SVOCL_TOOLS_SNAPSHOT_DIGEST_H
#define SVOCL_TOOLS_SNAPSHOT_DIGEST_H

#include <stddef.h>

#include "svocl/status.h"

#define LINE_NAME_BYTES 256
#define LINE_TEXT_BYTES 8192

/* Text that grows by pieces and stops at its end. */
typedef struct line_text {
    char text[LINE_TEXT_BYTES];
    size_t used;
} line_text;

void line_text_add(line_text *line, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Each prints one line, named "name: part". */
void line_print(const char *name, const char *part, const char *value);
void line_print_digest(const char *name, const char *part, const void *bytes, size_t byte_count);
/* Of a failure: the status by its number, which is stable; its name may change. */
void line_print_status(const char *name, const char *part, svo_status status);
/* Of a whole file. */
void line_print_file(const char *name, const char *part, const char *path);

#endif
