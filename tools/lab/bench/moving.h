/* SPDX-License-Identifier: MIT */
/* Subject "moving": updates of scenes that move beside full builds. */
#ifndef SVOCL_TOOLS_BENCH_MOVING_H
#define SVOCL_TOOLS_BENCH_MOVING_H

#include "measure/suite.h"

extern const suite_subject bench_moving;

#endif
