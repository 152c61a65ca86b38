/* SPDX-License-Identifier: MIT */
/* Which factor explains how much of the times. */
#ifndef SVOCL_TOOLS_BENCH_VERSUS_EFFECTS_H
#define SVOCL_TOOLS_BENCH_VERSUS_EFFECTS_H

#include "bench/versus_data.h"

/* Adds the table of effects: an analysis of variance of the logarithms of times. */
void versus_add_effects(const versus_data *data, result_set *results);

#endif
