/* SPDX-License-Identifier: MIT */
/* svocl bench gl-vs-cl: what building by OpenGL costs beside OpenCL. */
#ifndef SVOCL_TOOLS_BENCH_VERSUS_H
#define SVOCL_TOOLS_BENCH_VERSUS_H

#include "measure/result.h"
#include "support/program.h"

/* Measures, or reads --from, and adds all tables. A tree of another hash than those that must be the same is a failure.
   Returns the exit code. */
int bench_versus(program *state, result_set *results);
/* Whether a table is for programs, not for people. */
bool bench_versus_is_raw(const result_table *table);
/* --csv and --page. Returns the exit code. */
int bench_versus_write(program *state, const result_set *results);

#endif
