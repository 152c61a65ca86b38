/* SPDX-License-Identifier: MIT */
/* Extracts of the tables of results as Markdown: rows and columns that matter most, for the summary and for docs/. */
#ifndef SVOCL_TOOLS_REPORT_SUMMARY_H
#define SVOCL_TOOLS_REPORT_SUMMARY_H

#include <stdio.h>

#include "measure/result.h"

typedef struct summary_extract summary_extract;

/* NULL where there is no extract of that ID. */
const summary_extract *summary_find(const char *id);

/* Writes one extract. Returns false and writes nothing where the results lack its table or one of its columns, or
   where no row fits. */
bool summary_write_extract(const summary_extract *wanted, const result_set *results, FILE *text);

/* Writes a whole table; the low and high ends of intervals stand beside their middle. */
void summary_write_table(const result_table *table, FILE *text);

/* What the results were measured on, as a table. */
void summary_write_machine(const result_machine *machine, FILE *text);

/* The machine, then the extracts that belong to a short report, each under its title. */
void summary_write(const result_set *results, FILE *text);

#endif
