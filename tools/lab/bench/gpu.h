/* SPDX-License-Identifier: MIT */
/* svocl bench gpu: what works on a machine, whether it is right, and how fast, for a machine that is there once. */
#ifndef SVOCL_TOOLS_BENCH_GPU_H
#define SVOCL_TOOLS_BENCH_GPU_H

#include "bench/gpu_steps.h"

/*
 * Runs every step and fills the set and its machine. Steps that fail are rows with their reason. The options are those
 * of OPTION_DEVICE, --quick and the context. Returns the exit code, its line printed.
 */
int bench_gpu(program *state, result_set *results, bench_gpu_verdicts *verdicts);

#endif
