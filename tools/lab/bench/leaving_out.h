/* SPDX-License-Identifier: MIT */
/* Subject "leaving-out": time and bytes of each need. */
#ifndef SVOCL_TOOLS_BENCH_LEAVING_OUT_H
#define SVOCL_TOOLS_BENCH_LEAVING_OUT_H

#include "measure/suite.h"

extern const suite_subject bench_leaving_out;

#endif
