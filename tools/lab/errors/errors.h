/* SPDX-License-Identifier: MIT */
/*
 * svocl bench errors: error and run time. Each experiment runs several methods for the same problem interleaved,
 * compares their results with an exact reference, and fills one table.
 */
#ifndef SVOCL_TOOLS_ERRORS_ERRORS_H
#define SVOCL_TOOLS_ERRORS_ERRORS_H

#include <stdbool.h>
#include <stddef.h>

#include "measure/suite.h"

/* What the experiments share. */
typedef struct error_run {
    program *state;
    session opened; /* borrowed; frontend: OpenGL's where there is one */
    bool quick; /* smaller sizes, fewer rounds: the same methods and columns */
    unsigned threads; /* of methods that run on the host: as many as the device's */
    size_t rounds; /* times are medians of so many, after a warm-up round where there are more than one */
    char rounds_note[64]; /* the same in words, for the tables' notes */
    result_set *results;
    const char *const *scenes; /* those of --scenes; begins with NULL: each experiment's own */
} error_run;

/* For one experiment of a suite. */
error_run errors_begin(const suite *all);

/* Another number of rounds than errors_begin chose. */
void errors_set_rounds(error_run *run, size_t rounds);

/* Fails with the message of the device, or for lack of memory. Returns the exit code. */
int errors_fail(error_run *run);
/* A scene of an experiment: what tables call it, and its INPUT. */
typedef struct error_scene {
    const char *name, *spec; /* "statue", "statue:20000" */
} error_scene;

/* The scenes of --scenes, else the experiment's own, which end with a NULL: the one at an index, with NULLs past the
   last. */
error_scene errors_scene_at(const error_run *run, const error_scene *own, size_t index);
/* Its name in tables, once it is open: that of --scenes is the file's. */
const char *errors_scene_name(const error_scene *given, const input *source);

#endif
