/* SPDX-License-Identifier: MIT */
/* The page of svocl export-web. */
#ifndef SVOCL_TOOLS_WEB_PAGE_H
#define SVOCL_TOOLS_WEB_PAGE_H

#include <stdio.h>

#include "support/program.h"
#include "web/pack.h"

typedef struct web_page {
    const char *name; /* of the tree, a heading */
    const web_tree *tree;
    web_cut cut;
    const unsigned char *packed; /* what web_pack makes of the cut */
    size_t packed_count;
} web_page;

/* The bytes of the page without its data. Returns the exit code. */
int web_page_measure(program *state, const web_page *page, size_t *shell_bytes);

/* The most bytes of data for a page of at most page_bytes; the rest of the page takes shell_bytes. */
size_t web_page_room(uint64_t page_bytes, size_t shell_bytes);

/* Returns the exit code. */
int web_page_write(program *state, const web_page *page, FILE *out);

#endif
