/* SPDX-License-Identifier: MIT */
/* Runs the kernels of averages.cl on one set of samples. */
#ifndef SVOCL_TOOLS_ERRORS_AVERAGES_H
#define SVOCL_TOOLS_ERRORS_AVERAGES_H

#include "errors/attribute_samples.h"
#include "support/session.h"

typedef enum average_method { AVERAGE_RGBA8 = 0, AVERAGE_FLOAT, AVERAGE_METHOD_COUNT } average_method;

typedef struct averages averages;

/* NULL on failure. */
averages *averages_create(const session *opened, const attribute_samples *samples);
void averages_destroy(averages **made);

/* Uploads the samples in their current order, as 8-bit values of value * scale + offset. */
bool averages_upload(averages *made, const attribute_samples *samples, double scale, double offset);
/* Clears the means and runs the method. Returns the milliseconds of the kernel, below 0 on failure. */
double averages_run(averages *made, average_method method);
/* The means of the last run of that method, in the units of the samples. */
bool averages_read(averages *made, average_method method, double (*means)[3]);

#endif
