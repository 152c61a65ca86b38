/* SPDX-License-Identifier: MIT */
/* svocl bench solid: the inside of closed meshes. */
#ifndef SVOCL_TOOLS_BENCH_SOLID_H
#define SVOCL_TOOLS_BENCH_SOLID_H

#include "measure/suite.h"

extern const suite_subject bench_solid;

#endif
