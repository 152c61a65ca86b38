/* SPDX-License-Identifier: MIT */
/* A table of results in a page: units in the head, figures aligned at their points, quartiles small beside medians. */
#ifndef SVOCL_TOOLS_REPORT_TABLE_HTML_H
#define SVOCL_TOOLS_REPORT_TABLE_HTML_H

#include <stdio.h>

#include "measure/result.h"

/* Long tables are folded. */
void table_html_write(const result_table *table, FILE *page);

/* What a column of bytes is shown in: the unit, and what the numbers are divided by. Other columns keep theirs. */
double table_html_unit(const result_table *table, size_t column, const char **unit);

#endif
