/* SPDX-License-Identifier: MIT */
/* Subject "paged": misses and reads along a camera path, by the share of the file that has room. */
#ifndef SVOCL_TOOLS_BENCH_PAGED_H
#define SVOCL_TOOLS_BENCH_PAGED_H

#include "measure/suite.h"

extern const suite_subject bench_paged;

#endif
