/* SPDX-License-Identifier: MIT */
/* The tables that matter most, shortened, as Markdown: for summary.md. */
#ifndef SVOCL_TOOLS_REPORT_SUMMARY_H
#define SVOCL_TOOLS_REPORT_SUMMARY_H

#include <stdio.h>

#include "measure/result.h"

/* The machine in a sentence, then a table for each extract whose table the results have. */
void summary_write(const result_set *results, FILE *text);

#endif
