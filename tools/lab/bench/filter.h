/* SPDX-License-Identifier: MIT */
/* Subject "filter": attributes under each weighting. */
#ifndef SVOCL_TOOLS_BENCH_FILTER_H
#define SVOCL_TOOLS_BENCH_FILTER_H

#include "measure/suite.h"

extern const suite_subject bench_filter;

#endif
