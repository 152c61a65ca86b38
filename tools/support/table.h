/* SPDX-License-Identifier: MIT */
/*
 * Tables and figures for people: aligned columns without frames, counts with separators, sizes and rates with units. On
 * a terminal, long cells of the last column wrap to its width, and headings are bold unless NO_COLOR or TERM=dumb
 * forbids it. A file or a pipe gets one line per row.
 */
#ifndef SVOCL_TOOLS_SUPPORT_TABLE_H
#define SVOCL_TOOLS_SUPPORT_TABLE_H

#include <stddef.h>
#include <stdint.h>

typedef struct table table;

#define TABLE_COLUMNS_MAX 24U
#define TABLE_HELP_WIDTH  80U /* of lines of help */

/* alignment: one letter per column, 'l' or 'r', at most TABLE_COLUMNS_MAX. NULL if memory runs out; the other
   functions accept it. */
table *table_create(const char *alignment);

/* Adds the next cell, row by row. */
void table_cell(table *rows, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Prints the rows to standard output, indented, and releases the table. */
void table_print(table *rows);
/* The same with lines of at most so many columns, in a file or a pipe too. */
void table_print_wrapped(table *rows, size_t line_width);

/* An empty line between tables, a heading, and a line of text below it, to standard output. */
void table_gap(void);
void table_heading(const char *format, ...) __attribute__((format(printf, 1, 2)));
void table_line(const char *format, ...) __attribute__((format(printf, 1, 2)));

#define FIGURE_BYTES 56
typedef struct figure {
    char text[FIGURE_BYTES];
} figure;

/* Three digits, for values that are chosen: what is printed and given back on a command line is the same number. */
double figure_rounded(double value);

figure figure_count(uint64_t count); /* "1,167,738" */
figure figure_bytes(uint64_t bytes); /* "12.3 MiB" */
figure figure_ms(double ms); /* "12.34 ms" */
figure figure_rate(double per_second); /* "6.21 M/s" */
figure figure_needs(uint32_t bits); /* svo_need bits: "color, normal", or "none" */

#endif
