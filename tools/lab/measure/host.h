/* SPDX-License-Identifier: MIT */
/* What results say of the machine besides its drivers; and the vectors that PoCL's kernels and Embree use: figures of
   the same code differ between them. */
#ifndef SVOCL_TOOLS_MEASURE_HOST_H
#define SVOCL_TOOLS_MEASURE_HOST_H

#include <stdbool.h>

#include "measure/result.h"
#include "support/options.h"

/* Processor, clock, memory, threads, instruction set, and the version of svocl. */
void host_describe(const options *given, result_machine *machine);

/* The name for tables, "AVX-512": of the processor's widest set where asked is NULL, else of "sse2", "avx2" or
   "avx512". "" for an unknown processor. */
const char *instruction_set_name(const char *asked);

/* Whether the processor has it. */
bool instruction_set_is_there(const char *asked);

/* Makes PoCL compile for that set, in a cache of its own: a folder of the caller's. To be called before OpenCL starts.
   False when the environment cannot be changed. */
bool instruction_set_choose(const char *asked, const char *cache_path);

#endif
