/* SPDX-License-Identifier: MIT */
/* One attribute of one mesh averaged in its voxels by every way there is, in several orders; each against double. */
#ifndef SVOCL_ATTRIBUTE_WAYS_H
#define SVOCL_ATTRIBUTE_WAYS_H

#include "errors/errors.h"
#include "errors/attribute_samples.h"

#define ATTRIBUTE_WAYS_MAX 5u

/* Errors of colours: of the worst channel, in 1/255. Of normals: the angle to the mean's direction, in degrees. */
typedef struct attribute_way_result {
    const char *way; /* static */
    double ms;
    double mean, most, largest; /* over leaves; most: 99 of 100 are below */
    double order_mean, order_largest; /* between the first order and any other */
} attribute_way_result;

/* pairs_per_leaf: receives how many samples a voxel has on average. Returns the exit code. */
int attribute_ways_measure(error_run *run, const svo_mesh *mesh, attribute kind, unsigned depth,
                           attribute_way_result *results, size_t *result_count, double *pairs_per_leaf);

#endif
