/* SPDX-License-Identifier: MIT */
/*
 * What svocl bench gl-vs-cl measures is two tables, whose rows any number of processes make and one puts together:
 * cells, each a way to build a tree with its settings, and rounds, each a build. All other tables are computed from
 * them, and from one of processes that build one tree.
 */
#ifndef SVOCL_TOOLS_BENCH_VERSUS_DATA_H
#define SVOCL_TOOLS_BENCH_VERSUS_DATA_H

#include "bench/versus_design.h"
#include "measure/bootstrap.h"

/* Of cells the first row is central in all but its method, and so are those after it until one is not. */
#define VERSUS_CELLS_ID  "gl-vs-cl-cells"
#define VERSUS_ROUNDS_ID "gl-vs-cl-rounds"
#define VERSUS_STARTS_ID "gl-vs-cl-starts"
#define VERSUS_SERIES_ID "gl-vs-cl-series"

/* The times of a build: by the wall clock, by the report's clocks, and by the wall clock again. */
typedef enum versus_time {
    VERSUS_WALL, /* from svo_plan_create to clFinish */
    VERSUS_PLAN, /* of it, svo_plan_create */
    VERSUS_VOXELIZE,
    VERSUS_TREE, /* subdivide, link, pack and filter */
    VERSUS_TRANSFER,
    VERSUS_COMPILE,
    VERSUS_TIMES
} versus_time;

#define VERSUS_LONG_MS 1000.0
/* Whether a first build is a round as well: a long one that compiled nothing. */
bool versus_is_round(const double ms[VERSUS_TIMES]);

/* Adds the two tables, and the table of starts, without rows. */
void versus_add_tables(result_set *results);

/* ---- what was measured ---- */

/* The rounds of a cell, in all processes. */
typedef struct versus_sample {
    double ms[VERSUS_TIMES][BOOTSTRAP_ROUNDS_MAX];
    unsigned process[BOOTSTRAP_ROUNDS_MAX], round[BOOTSTRAP_ROUNDS_MAX];
    size_t count; /* of rounds, without first builds that are none */
    double first_ms; /* the wall clock's, of the first build; NAN: none */
} versus_sample;

typedef struct versus_data {
    const result_table *cells;
    versus_sample *samples; /* of each cell */
    size_t count;
} versus_data;

/* Reads the tables of a set, and compares the hashes of trees that must be the same. Returns the exit code, on failure
   with nothing to release. name: of the file, for messages. */
int versus_open(program *state, const result_set *results, const char *name, versus_data *out);
void versus_close(versus_data *data);

/* Appends cells and rounds of one more process. False when memory runs out or tables differ. */
bool versus_merge(result_set *into, result_set *from, unsigned process);

/* ---- cells and times ---- */

/* The text of a factor or column; "" where it is none. */
const char *versus_text(const versus_data *data, size_t cell, versus_column column);
double versus_number(const versus_data *data, size_t cell, versus_column column);
/* Whether two cells have the same values of a set of VERSUS_BITs. */
bool versus_same(const versus_data *data, size_t a, size_t b, unsigned factors);
/* A cell's path, list, share and builder in words: "gl-expand, host, sorted", with "gpu path" where it is not the
   device's own. */
typedef struct versus_words {
    char text[96];
} versus_words;
versus_words versus_method_words(const versus_data *data, size_t cell);

/* Of the wall clock in a process, from 1 on; NAN where it has no round of the cell. */
double versus_process_median(const versus_sample *sample, unsigned process);
unsigned versus_process_count(const versus_data *data);
/* Of a median; without ends where there is one value. */
interval versus_interval_of(const double *values, size_t count);
interval versus_interval(const versus_data *data, size_t cell, versus_time time);
/* Of the wall clocks of rounds that both cells have; without such, of their medians in each process. */
interval versus_ratio(const versus_data *data, size_t cell, size_t other);

#define VERSUS_KINDS_MAX 16u
/* Of the central cells that have rounds, the first of each path, list and builder: with the first share that works. */
size_t versus_kinds(const versus_data *data, size_t kinds[VERSUS_KINDS_MAX]);

#endif
