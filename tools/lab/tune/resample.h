/* SPDX-License-Identifier: MIT */
/* Intervals of errors by the bootstrap: blocks of sample points, drawn with replacement as bootstrap.h draws rounds. */
#ifndef SVOCL_TOOLS_TUNE_RESAMPLE_H
#define SVOCL_TOOLS_TUNE_RESAMPLE_H

#include "measure/bootstrap.h"
#include "tune/measures.h"

double resample_error(const tune_errors *errors, const tune_measure *measure, draw which);
/* Of the magnitude: a bias counts without its sign. */
interval interval_of_error(const tune_errors *errors, const tune_measure *measure);

#endif
