/* SPDX-License-Identifier: MIT */
/* Pages of HTML in one file: a template whose references give way to embedded files, and bytes and JSON as text. */
#ifndef SVOCL_TOOLS_SUPPORT_PAGE_TEMPLATE_H
#define SVOCL_TOOLS_SUPPORT_PAGE_TEMPLATE_H

#include <stdbool.h>
#include <stdio.h>

#include "support/program.h"

/* What stands in the template, and what takes its place. */
typedef struct page_part {
    const char *reference, *open, *text, *close;
    bool is_json; /* text is JSON for the inside of a script element */
} page_part;

/* Writes the template with its parts filled in. parts: in the order of their references. Returns the exit code. */
int page_template_write(program *state, const char *text, const page_part *parts, size_t part_count, FILE *page);

/* RFC 4648. */
void page_template_base64(const unsigned char *bytes, size_t byte_count, FILE *page);

#endif
