/* SPDX-License-Identifier: MIT */
/* Median and quartiles of repeated measurements. */
#ifndef SVOCL_TOOLS_MEASURE_SPREAD_H
#define SVOCL_TOOLS_MEASURE_SPREAD_H

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
/* Nothing measured. */
spread spread_none(void);

/* Three columns: name, "name q1", "name q3". */
void spread_add_columns(result_table *table, const char *name, const char *unit);
void spread_add(result_table *table, spread measured);

#endif
