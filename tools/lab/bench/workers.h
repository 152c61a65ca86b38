/* SPDX-License-Identifier: MIT */
/* A part of the subject "parts": strong scaling over processes that build parts side by side. */
#ifndef SVOCL_TOOLS_BENCH_WORKERS_H
#define SVOCL_TOOLS_BENCH_WORKERS_H

#include "bench/child.h"
#include "measure/suite.h"

/* Adds the empty table. Returns the exit code, its line printed. */
int workers_begin(suite *all);
/* Adds rows for each number of workers of --workers, or for 1 and 2. limit: of a part's memory. cache: warm. */
int workers_run(suite *all, const input *source, unsigned depth, uint64_t limit, const child_cache *cache);

#endif
