/* SPDX-License-Identifier: MIT */
/* Subject "compact": bytes and rays of compact trees beside the built tree. */
#ifndef SVOCL_TOOLS_BENCH_COMPACT_H
#define SVOCL_TOOLS_BENCH_COMPACT_H

#include "measure/suite.h"

extern const suite_subject bench_compact;

#endif
