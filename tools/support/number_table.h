/* SPDX-License-Identifier: MIT */
/* CSV files of numbers, as many to each line. */
#ifndef SVOCL_TOOLS_SUPPORT_NUMBER_TABLE_H
#define SVOCL_TOOLS_SUPPORT_NUMBER_TABLE_H

#include <stddef.h>

#include "support/program.h"

typedef struct number_form {
    size_t fields; /* numbers of a line, at most 16 */
    const char *line; /* what messages call a line: "ox,oy,oz,dx,dy,dz" */
    const char *noun; /* and what it stands for: "ray" */
} number_form;

typedef struct number_table {
    float *numbers; /* row by row, by malloc */
    size_t row_count; /* at least 1 */
} number_table;

/* Reads a file or, for "-", standard input. A first line that does not begin with a number is a heading; empty lines
   are skipped. Any other line is an error that names it. Returns the exit code. */
int number_table_read(program *state, const char *path, const number_form *form, number_table *out);
void number_table_free(number_table *table);

/* Comma-separated numbers, at most limit; returns how many, 0 if anything else is among them. */
size_t number_table_parse(const char *text, float *numbers, size_t limit);

#endif
