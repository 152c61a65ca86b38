/* SPDX-License-Identifier: MIT */
/* The experiments of `svocl bench errors` as the command sees them. */
#ifndef SVOCL_BENCH_ERRORS_H
#define SVOCL_BENCH_ERRORS_H

#include <stdbool.h>

#include "bench/result.h"
#include "program.h"

/* Whether which is "errors" (all of them) or one of "e1" to "e5". */
bool bench_errors_know(const char *which);
/* How many steps of the progress bar it makes. */
unsigned bench_errors_step_count(const char *which);
/* Opens a session by the options and adds a table per experiment. Returns the exit code. */
int bench_errors_fill(program *state, const char *which, bool quick, result_set *results);

#endif
