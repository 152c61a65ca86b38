/* SPDX-License-Identifier: MIT */
/* The builds of one process. */
#ifndef SVOCL_TOOLS_BENCH_VERSUS_RUN_H
#define SVOCL_TOOLS_BENCH_VERSUS_RUN_H

#include "bench/versus_design.h"

/* Measures in this process, for so many seconds; 0: until every cell has its rounds. Fills the machine. Returns the
   exit code. */
int versus_run(program *state, double seconds, result_set *results);

#endif
