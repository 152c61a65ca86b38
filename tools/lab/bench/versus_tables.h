/* SPDX-License-Identifier: MIT */
/* The tables that are computed from what was measured. */
#ifndef SVOCL_TOOLS_BENCH_VERSUS_TABLES_H
#define SVOCL_TOOLS_BENCH_VERSUS_TABLES_H

#include "bench/versus_data.h"

/* Adds them to a set. measured: what data is of. */
void versus_tabulate(const versus_data *data, const result_set *measured, result_set *into);

#endif
