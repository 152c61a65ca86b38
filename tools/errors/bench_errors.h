/* SPDX-License-Identifier: MIT */
/* The experiments of `svocl bench errors` as the command sees them. */
#ifndef SVOCL_TOOLS_ERRORS_BENCH_ERRORS_H
#define SVOCL_TOOLS_ERRORS_BENCH_ERRORS_H

#include "bench/bench.h"

/* Whether which is "errors" (all of them) or one of "e1" to "e5". */
bool bench_errors_know(const char *which);
/* The names "e1" to "e5" and what each is about, one line; NULL past the last. Static strings. */
const char *bench_errors_describe(size_t index, const char **summary);
/* How many steps of the progress bar it makes. */
unsigned bench_errors_step_count(const char *which);
/* Adds a table per experiment to the suite's results. Returns the exit code. */
int bench_errors_fill(const bench_suite *all, const char *which);

#endif
