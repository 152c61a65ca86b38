/* SPDX-License-Identifier: MIT */
/* Averages one attribute in the voxels of a mesh by every method, in several orders, and compares with double. */
#ifndef SVOCL_TOOLS_ERRORS_ATTRIBUTE_METHODS_H
#define SVOCL_TOOLS_ERRORS_ATTRIBUTE_METHODS_H

#include "errors/errors.h"

#define ATTRIBUTE_METHODS_MAX 5u

typedef enum attribute { ATTRIBUTE_COLOR = 0, ATTRIBUTE_NORMAL, ATTRIBUTE_COUNT } attribute;

/* Errors of colors: of the worst channel, in 1/255. Of normals: the angle to the mean's direction, in degrees. */
typedef struct attribute_method_result {
    const char *method; /* static */
    double ms;
    double mean, percentile_99, largest; /* over leaves */
    double order_mean, order_largest; /* between the first order and the others */
} attribute_method_result;

/* pairs_per_leaf: receives the mean number of samples per voxel. Returns the exit code. */
int attribute_methods_measure(error_run *run, const svo_mesh *mesh, attribute kind, unsigned depth,
                              attribute_method_result *results, size_t *result_count, double *pairs_per_leaf);

#endif
