/* SPDX-License-Identifier: MIT */
/* What results say of the machine besides its drivers. */
#ifndef SVOCL_TOOLS_MEASURE_HOST_H
#define SVOCL_TOOLS_MEASURE_HOST_H

#include "measure/result.h"
#include "support/options.h"

/* Processor, clock, memory, threads, instruction set, and the version of svocl. */
void host_describe(const options *given, result_machine *machine);

#endif
