/* SPDX-License-Identifier: MIT */
/* Light: its stages, bytes, views and frames. Tables "light-stages", "light-bytes", "light-frames". */
#ifndef SVOCL_TOOLS_BENCH_LIGHT_H
#define SVOCL_TOOLS_BENCH_LIGHT_H

#include "measure/suite.h"

extern const suite_subject bench_light;

#endif
