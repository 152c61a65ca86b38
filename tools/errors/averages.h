/* SPDX-License-Identifier: MIT */
/* The kernels of averages.cl on one set of samples. */
#ifndef SVOCL_TOOLS_ERRORS_AVERAGES_H
#define SVOCL_TOOLS_ERRORS_AVERAGES_H

#include "errors/attribute_samples.h"
#include "support/session.h"

typedef enum average_method { AVERAGE_RGBA8 = 0, AVERAGE_FLOAT, AVERAGE_METHOD_COUNT } average_method;

typedef struct averages averages;

/* NULL on failure. */
averages *averages_create(const session *opened, const attribute_samples *samples);
void averages_destroy(averages **made);

/* Uploads the samples in the order they have now. values: what the means are of, scaled as the way wants it: octets of
   value * scale + offset. */
bool averages_upload(averages *made, const attribute_samples *samples, double scale, double offset);
/* Runs the way from zeros. Returns the milliseconds of the kernel, below 0 on failure. */
double averages_run(averages *made, average_method method);
/* The means of the last run of that way, as the samples are: by (octet - offset) / scale. */
bool averages_read(averages *made, average_method method, double (*means)[3]);

#endif
