/* SPDX-License-Identifier: MIT */
/* The page of a report: one HTML file that needs nothing else. */
#ifndef SVOCL_TOOLS_REPORT_PAGE_H
#define SVOCL_TOOLS_REPORT_PAGE_H

#include <stdio.h>

#include "measure/result.h"
#include "report/pictures.h"

typedef struct page_content {
    const result_set *results;
    const pictures *drawn;
    const char *source; /* how the figures came here, one sentence: "Measured in this run." */
    const char *absence; /* why a table is not there: "not in results.json" */
} page_content;

/* A step of the progress bar. Returns the exit code. */
int page_write(program *state, const page_content *content, FILE *page);

#endif
