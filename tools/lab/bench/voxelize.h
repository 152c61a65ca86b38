/* SPDX-License-Identifier: MIT */
/* Subject "voxelize": the front ends. */
#ifndef SVOCL_TOOLS_BENCH_VOXELIZE_H
#define SVOCL_TOOLS_BENCH_VOXELIZE_H

#include "measure/suite.h"

extern const suite_subject bench_voxelize;

#endif
