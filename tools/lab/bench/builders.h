/* SPDX-License-Identifier: MIT */
/* Subject "build": builders and interop paths, stage by stage. */
#ifndef SVOCL_TOOLS_BENCH_BUILDERS_H
#define SVOCL_TOOLS_BENCH_BUILDERS_H

#include "measure/suite.h"

extern const suite_subject bench_builders;

#endif
