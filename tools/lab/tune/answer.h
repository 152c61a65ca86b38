/* SPDX-License-Identifier: MIT */
/* What a sweep found out: tables, the lines of the answer, JSON, and a page. */
#ifndef SVOCL_TOOLS_TUNE_ANSWER_H
#define SVOCL_TOOLS_TUNE_ANSWER_H

#include <stdio.h>

#include "measure/result.h"
#include "tune/sweep.h"

/* The tables "tune" (a setting in each row), "tune-errors" (all measures with their intervals) and "tune-rounds". NULL
   when out of memory. */
result_set *answer_tables(const sweep *all);
/* A table and the answer to standard output. */
void answer_print(const sweep *all);
/* The state with "answer" and "tables". NULL when out of memory. */
cJSON *answer_to_json(const sweep *all, const result_set *tables);
/* The values of a setting in what varies, but the depth: "half-open, 64 rays". */
void answer_varied(const sweep *all, size_t index, text_list *out);
/* One line in words: what was asked and found. */
void answer_words(const sweep *all, text_list *out);

#endif
