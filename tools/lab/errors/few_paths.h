/* SPDX-License-Identifier: MIT */
/* Light by few paths a point: what users of a tree's rays would do in place of cones. */
#ifndef SVOCL_TOOLS_ERRORS_FEW_PATHS_H
#define SVOCL_TOOLS_ERRORS_FEW_PATHS_H

#include "errors/cone_truth.h"

typedef struct few_paths {
    const error_run *run;
    const cone_truth *truth;
    unsigned per_point;
    path_result *results;
} few_paths;

/* per_point: as path_sample_count makes it. False when memory runs out. */
bool few_paths_make(const error_run *run, const cone_truth *truth, unsigned per_point, few_paths *out);
void few_paths_free(few_paths *work);

/* Traces the paths and the shadow rays where they end: an interleaved_method's work. */
double few_paths_trace(void *user);
/* Of the last run. */
truth_error few_paths_error(const few_paths *work);

#endif
