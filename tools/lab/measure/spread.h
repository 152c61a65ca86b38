/* SPDX-License-Identifier: MIT */
/* Median and quartiles of repeated measurements; and interleaved timing: each round runs every method once, so that
   disturbances of the machine affect all alike. */
#ifndef SVOCL_TOOLS_MEASURE_SPREAD_H
#define SVOCL_TOOLS_MEASURE_SPREAD_H

#include <stdbool.h>
#include <stddef.h>

#include "measure/result.h"

typedef struct spread {
    double median, low, high; /* low, high: the quartiles. All NAN: nothing was measured */
} spread;

/* Sorts the values. Quantiles interpolate between neighbors: type 7 of Hyndman and Fan, "Sample Quantiles in
   Statistical Packages", 1996. */
spread spread_of(double *values, size_t count);
/* The quantile of sorted values at a fraction, 0 .. 1. count: above 0. */
double spread_quantile(const double *sorted, size_t count, double fraction);
/* The median of values that stay as they are. scratch: count. */
double spread_median(const double *values, size_t count, double *scratch);
/* Nothing measured. */
spread spread_none(void);

/* Three columns: name, "name q1", "name q3". */
void spread_add_columns(result_table *table, const char *name, const char *unit);
void spread_add(result_table *table, spread measured);
/* Rates relative to another's, round by round. scratch: round_count. */
void spread_add_ratio(result_table *table, const double *other_ms, const double *ms, size_t round_count,
                      double *scratch);

typedef struct interleaved_method {
    double (*work_ms)(void *user); /* does the work once; returns its milliseconds, below 0 on failure */
    void *user;
    double median_ms; /* over the measured rounds: set by interleave_measure */
} interleaved_method;

/* Runs a warm-up round, then round_count measured ones. A single round has no warm-up round: it is for results, not for
   times. Returns false when a method fails or memory runs out; then no median is set. */
bool interleave_measure(interleaved_method *methods, size_t method_count, size_t round_count);

#endif
