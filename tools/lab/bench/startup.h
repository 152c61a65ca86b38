/* SPDX-License-Identifier: MIT */
/* Subject "startup": from the start of a process to its first tree. */
#ifndef SVOCL_TOOLS_BENCH_STARTUP_H
#define SVOCL_TOOLS_BENCH_STARTUP_H

#include "measure/suite.h"

extern const suite_subject bench_startup;

#endif
