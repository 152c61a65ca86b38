/* SPDX-License-Identifier: MIT */
/* Subject "parts": time and memory against the number of parts. */
#ifndef SVOCL_TOOLS_BENCH_PARTS_H
#define SVOCL_TOOLS_BENCH_PARTS_H

#include "measure/suite.h"

extern const suite_subject bench_parts;

#endif
