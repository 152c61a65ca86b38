/* SPDX-License-Identifier: MIT */
/*
 * Measurements as tables: the output of `svocl bench` and the input of a report. A set holds the facts of the
 * machine and tables; a table has columns with units and rows of cells, each a text, a number, or nothing.
 *
 * Functions that add allow NULL and then do nothing. When memory runs out the set remembers it, and result_is_whole and
 * result_to_json report it: callers check in one place.
 */
#ifndef SVOCL_TOOLS_MEASURE_RESULT_H
#define SVOCL_TOOLS_MEASURE_RESULT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#define RESULT_FACT_BYTES 256

/* The machine of the measurements; "" where a fact is unknown. */
typedef struct result_machine {
    /* What drivers say, of any length; result_set_fact replaces it. */
    char *device; /* "Portable Computing Language: pthread-..." */
    char *driver; /* version of the OpenCL driver */
    char *platform; /* version of the OpenCL platform */
    char *renderer; /* OpenGL's; "none" without OpenGL */
    char svocl[RESULT_FACT_BYTES]; /* version of svocl */
    char date[RESULT_FACT_BYTES]; /* "": left out */
    char instruction_set[RESULT_FACT_BYTES]; /* the host's widest vectors, "AVX-512"; "": left out */
    char processor[RESULT_FACT_BYTES]; /* its model; "": left out */
    char clock[RESULT_FACT_BYTES]; /* "2595 MHz"; "": left out */
    char memory[RESULT_FACT_BYTES]; /* "23.5 GiB"; "": left out */
    unsigned cpu_threads;
} result_machine;

typedef enum result_kind { RESULT_ABSENT = 0, RESULT_TEXT, RESULT_NUMBER } result_kind;

typedef struct result_cell {
    result_kind kind;
    char *text; /* RESULT_TEXT */
    double number; /* RESULT_NUMBER: finite */
} result_cell;

typedef struct result_column {
    char *name;
    char *unit; /* "", "ms", "M/s", "B", ... */
} result_column;

typedef struct result_set result_set;

/* Read its fields directly; change them through the functions below. */
typedef struct result_table {
    result_set *owner;
    char *id; /* "voxelize", "builders", "e1-voxelization", ... */
    char *title; /* one line */
    char *note; /* how it was measured, which clock, sources */
    result_column *columns;
    size_t column_count;
    result_cell *cells; /* row by row */
    size_t cell_count, cell_capacity;
} result_table;

struct result_set {
    result_machine machine;
    result_table **tables;
    size_t table_count;
    bool incomplete; /* something could not be added */
};

/* NULL when out of memory. */
result_set *result_create(void);
void result_destroy(result_set **set); /* a pointer to NULL is allowed */

/* Replaces one of the machine's texts that the set owns. */
void result_set_fact(result_set *set, char **fact, const char *text);

/* A table without columns, at the end of the set, which owns it. NULL when out of memory. */
result_table *result_add_table(result_set *set, const char *id, const char *title, const char *note);
/* Replaces the note, once it is known what ran. */
void result_set_note(result_table *table, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Appends a sentence to the note, unless the note has it already. */
void result_extend_note(result_table *table, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The next column. All columns come before the first cell. */
void result_add_column(result_table *table, const char *name, const char *unit);

/* Removes the cells of a row that is not complete. */
void result_drop_partial_row(result_table *table);

/* The next cell, row by row. A number that is not finite is absent. */
void result_add_text(result_table *table, const char *format, ...) __attribute__((format(printf, 2, 3)));
void result_add_number(result_table *table, double number);
void result_add_absent(result_table *table);
/* A copy. */
void result_add_cell(result_table *table, const result_cell *cell);

/* Whether memory sufficed and every row is complete. */
bool result_is_whole(const result_set *set);

/* NULL where there is no such table. */
result_table *result_find(const result_set *set, const char *id);
size_t result_row_count(const result_table *table);
/* The column of that name: its index, or column_count where there is none. */
size_t result_find_column(const result_table *table, const char *name);
/* Whether the two columns after this one are its quartiles, "NAME q1" and "NAME q3", or its interval, "NAME low" and
   "NAME high". */
bool result_has_quartiles(const result_table *table, size_t column);
/* NULL outside the table. */
const result_cell *result_cell_at(const result_table *table, size_t row, size_t column);

/* Moves the tables of one set to the end of another. A table replaces one with the same ID. */
void result_take(result_set *into, result_set *from);

#endif
