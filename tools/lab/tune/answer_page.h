/* SPDX-License-Identifier: MIT */
/* The page of `svocl tune`: the answer, Pareto fronts, tables. */
#ifndef SVOCL_TOOLS_TUNE_ANSWER_PAGE_H
#define SVOCL_TOOLS_TUNE_ANSWER_PAGE_H

#include <stdio.h>

#include "measure/result.h"
#include "tune/sweep.h"

/* Writes the page. Returns the exit code. */
int answer_page(const sweep *all, const result_set *tables, FILE *page);

#endif
