/* SPDX-License-Identifier: MIT */
/*
 * svocl bench errors: error beside run time. Each experiment runs several ways to the same answer interleaved, compares
 * what they found with an exact reference, and fills one table of the results.
 */
#ifndef SVOCL_TOOLS_ERRORS_ERRORS_H
#define SVOCL_TOOLS_ERRORS_ERRORS_H

#include <stdbool.h>
#include <stddef.h>

#include "measure/result.h"
#include "scenes/scenes.h"
#include "support/session.h"

/* What the experiments share. */
typedef struct error_run {
    program *state;
    session opened; /* borrowed; frontend: OpenGL's where there is one */
    bool quick; /* smaller sizes, fewer rounds: the same ways and columns */
    unsigned threads; /* of ways that run on the host: as many as the device's */
    size_t rounds; /* times are medians of so many, after one that does not count */
    result_set *results;
} error_run;

/* Each adds one table and returns the exit code. */
int errors_voxelization(error_run *run); /* e1-voxelization */
int errors_rays(error_run *run); /* e2-rays */
int errors_attributes(error_run *run); /* e3-attributes */
int errors_detail(error_run *run); /* e4-detail */
int errors_conditioning(error_run *run); /* e5-stiffness */

/* What experiments fail with: the words of the device handle, or memory. */
int errors_fail(error_run *run);
/* A scene by its name, "statue:20000"; NULL with the failure printed. */
scene *errors_scene(error_run *run, const char *spec);

#endif
