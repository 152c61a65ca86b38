/* SPDX-License-Identifier: MIT */
/* Pages of results other than the report's: a template and a content of their own, with its style and scripts. */
#ifndef SVOCL_TOOLS_MEASURE_RESULTS_PAGE_H
#define SVOCL_TOOLS_MEASURE_RESULTS_PAGE_H

#include <cjson/cJSON.h>
#include <stdio.h>

#include "measure/result.h"
#include "support/program.h"

/* Writes the page. page_template names ../report/page.css and the scripts, and content.js, which it calls
   content_name. data: gets the results and no pictures, and is released. Returns the exit code. */
int results_page_write(program *state, const char *page_template, const char *content_name, const char *content,
                       const result_set *results, cJSON *data, FILE *page);

#endif
