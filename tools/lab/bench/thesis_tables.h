/* SPDX-License-Identifier: MIT */
/* Subjects "thesis-2020" and "thesis-2016": the published tables of two older systems, measured again. */
#ifndef SVOCL_TOOLS_BENCH_THESIS_TABLES_H
#define SVOCL_TOOLS_BENCH_THESIS_TABLES_H

#include "measure/suite.h"

extern const suite_subject bench_thesis_2020, bench_thesis_2016;

#endif
