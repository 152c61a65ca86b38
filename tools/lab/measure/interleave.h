/* SPDX-License-Identifier: MIT */
/* Interleaved timing: each round runs every method once, so that disturbances of the machine affect all alike. */
#ifndef SVOCL_TOOLS_MEASURE_INTERLEAVE_H
#define SVOCL_TOOLS_MEASURE_INTERLEAVE_H

#include <stdbool.h>
#include <stddef.h>

typedef struct interleaved_method {
    double (*work_ms)(void *user); /* does the work once; returns its milliseconds, below 0 on failure */
    void *user;
    double median_ms; /* over the measured rounds: set by interleave_measure */
} interleaved_method;

/* Runs a warm-up round, then round_count measured ones. A single round has no warm-up round: it is for results, not for
   times. Returns false when a method fails or memory runs out; then no median is set. */
bool interleave_measure(interleaved_method *methods, size_t method_count, size_t round_count);

#endif
