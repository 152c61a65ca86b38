/* SPDX-License-Identifier: MIT */
/* The page of a report: one HTML file that needs no other, made from page.html, page.css, scripts and results. */
#ifndef SVOCL_TOOLS_REPORT_PAGE_H
#define SVOCL_TOOLS_REPORT_PAGE_H

#include <stdio.h>

#include "measure/result.h"
#include "report/pictures.h"

typedef struct page_content {
    const result_set *results;
    const pictures *drawn;
    const char *origin; /* of the results, as content.js knows it: "full", "quick" or "file" */
} page_content;

/* Returns the exit code, its line printed. */
int page_write(program *state, const page_content *content, FILE *page);

#endif
