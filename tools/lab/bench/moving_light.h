/* SPDX-License-Identifier: MIT */
/* Subject "moving-light": light that follows an object, beside light from nothing. */
#ifndef SVOCL_TOOLS_BENCH_MOVING_LIGHT_H
#define SVOCL_TOOLS_BENCH_MOVING_LIGHT_H

#include "measure/suite.h"

extern const suite_subject bench_moving_light;

#endif
