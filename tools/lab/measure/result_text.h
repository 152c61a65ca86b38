/* SPDX-License-Identifier: MIT */
/* Sets of tables as text: for people and as CSV. */
#ifndef SVOCL_TOOLS_MEASURE_RESULT_TEXT_H
#define SVOCL_TOOLS_MEASURE_RESULT_TEXT_H

#include <stdio.h>

#include "measure/result.h"

/* The facts of the machine, and a table, for people, to standard output. */
void result_print_machine(const result_set *set);
void result_print(const result_table *results);
/* RFC 4180: a heading with units, commas, texts quoted where they must be; an absent cell is empty. */
void result_write_csv(const result_table *results, FILE *file);

#endif
