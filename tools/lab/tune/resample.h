/* SPDX-License-Identifier: MIT */
/*
 * Intervals by the bootstrap (Efron, "Bootstrap Methods: Another Look at the Jackknife", 1979): rounds of a time, and
 * blocks of sample points, drawn with replacement. Draws are a function of their numbers alone, so that the same
 * measurements have the same intervals everywhere.
 */
#ifndef SVOCL_TOOLS_TUNE_RESAMPLE_H
#define SVOCL_TOOLS_TUNE_RESAMPLE_H

#include "tune/measures.h"

#define RESAMPLE_ROUNDS_MAX 64u

typedef struct interval {
    double low, middle, high; /* 95 %; NAN: nothing was measured */
} interval;

/* Which draw: the same draw and stream take the same places. */
typedef struct draw {
    uint64_t number, stream;
} draw;

double resample_median(const double *rounds, size_t count);
/* The median of rounds drawn with replacement. count: 1 .. RESAMPLE_ROUNDS_MAX. */
double resample_time(const double *rounds, size_t count, draw which);
double resample_error(const tune_errors *errors, const tune_measure *measure, draw which);

interval interval_of_time(const double *rounds, size_t count);
/* Of the magnitude: a bias counts without its sign. */
interval interval_of_error(const tune_errors *errors, const tune_measure *measure);

#endif
