/* SPDX-License-Identifier: MIT */
/* One attribute of one mesh averaged in its voxels by every way there is, in several orders; each against double. */
#ifndef SVOCL_TOOLS_ERRORS_ATTRIBUTE_METHODS_H
#define SVOCL_TOOLS_ERRORS_ATTRIBUTE_METHODS_H

#include "errors/attribute_samples.h"
#include "errors/errors.h"

#define ATTRIBUTE_METHODS_MAX 5u

/* Errors of colors: of the worst channel, in 1/255. Of normals: the angle to the mean's direction, in degrees. */
typedef struct attribute_method_result {
    const char *method; /* static */
    double ms;
    double mean, most, largest; /* over leaves; most: 99 of 100 are below */
    double order_mean, order_largest; /* between the first order and any other */
} attribute_method_result;

/* pairs_per_leaf: receives how many samples a voxel has on average. Returns the exit code. */
int attribute_methods_measure(error_run *run, const svo_mesh *mesh, attribute kind, unsigned depth,
                              attribute_method_result *results, size_t *result_count, double *pairs_per_leaf);

#endif
