/* SPDX-License-Identifier: MIT */
/* Subject "parts-large": trees of a hundred million leaves in little memory. */
#ifndef SVOCL_TOOLS_BENCH_PARTS_LARGE_H
#define SVOCL_TOOLS_BENCH_PARTS_LARGE_H

#include "measure/suite.h"

extern const suite_subject bench_parts_large;

#endif
