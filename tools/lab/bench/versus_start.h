/* SPDX-License-Identifier: MIT */
/* Processes that build one tree, and the table of what starting takes. */
#ifndef SVOCL_TOOLS_BENCH_VERSUS_START_H
#define SVOCL_TOOLS_BENCH_VERSUS_START_H

#include "bench/versus_data.h"

/* Adds rows of starts for these kinds, of processes that are run for about so many seconds. name: of the central scene.
   Returns the exit code. */
int versus_start(program *state, const versus_data *data, const char *name, double seconds, result_set *results);

/* Adds the table of what starting takes. measured: has the rows. */
void versus_add_starts(const result_set *measured, result_set *into);

#endif
