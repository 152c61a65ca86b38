/* SPDX-License-Identifier: MIT */
/*
 * Intervals by the bootstrap (Efron, "Bootstrap Methods: Another Look at the Jackknife", 1979): the rounds of a time
 * drawn with replacement. Draws are a function of their numbers alone, so that the same measurements have the same
 * intervals everywhere.
 */
#ifndef SVOCL_TOOLS_MEASURE_BOOTSTRAP_H
#define SVOCL_TOOLS_MEASURE_BOOTSTRAP_H

#include <stddef.h>
#include <stdint.h>

#include "measure/result.h"
#include "scenes/maths.h"

#define BOOTSTRAP_ROUNDS_MAX 64u
#define BOOTSTRAP_DRAWS      200u

typedef struct interval {
    double low, middle, high; /* 95 %; NAN: nothing was measured */
} interval;

/* Which draw: the same draw and stream take the same places. */
typedef struct draw {
    uint64_t number, stream;
} draw;

random_stream bootstrap_begin(draw which);
/* The interval of BOOTSTRAP_DRAWS values, which it sorts; it contains the estimate. */
interval bootstrap_interval(double *values, double estimate);

double bootstrap_median(const double *rounds, size_t count);
/* The median of rounds drawn with replacement. count: 1 .. BOOTSTRAP_ROUNDS_MAX. */
double bootstrap_time(const double *rounds, size_t count, draw which);
/* Of the median. count: 0 .. BOOTSTRAP_ROUNDS_MAX. */
interval interval_of_time(const double *rounds, size_t count);

/* Three columns: name, "name low", "name high". */
void interval_add_columns(result_table *table, const char *name, const char *unit);
void interval_add(result_table *table, interval of);

#endif
