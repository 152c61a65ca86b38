/* SPDX-License-Identifier: MIT */
/* Ways that are compared take turns in one run, so that whatever else the machine does falls on all of them alike. */
#ifndef SVOCL_TOOLS_MEASURE_INTERLEAVE_H
#define SVOCL_TOOLS_MEASURE_INTERLEAVE_H

#include <stdbool.h>
#include <stddef.h>

typedef struct interleaved_method {
    double (*work_ms)(void *user); /* does the work once; returns what it took, below 0 on failure */
    void *user;
    double median_ms; /* of the rounds after the first: set by interleave_measure */
} interleaved_method;

/* The first round warms up and does not count. Returns false when a way fails or memory runs out; then no median is
   set. */
bool interleave_measure(interleaved_method *methods, size_t method_count, size_t round_count);

#endif
