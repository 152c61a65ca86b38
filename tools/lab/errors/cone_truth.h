/* SPDX-License-Identifier: MIT */
/* A scene with its light, points on its surfaces, and the path-traced truth there. */
#ifndef SVOCL_TOOLS_ERRORS_CONE_TRUTH_H
#define SVOCL_TOOLS_ERRORS_CONE_TRUTH_H

#include "errors/errors.h"
#include "path/path.h"

typedef struct cone_truth {
    const char *name; /* of the scene */
    suite_input opened; /* the scene */
    svo_tree *tree; /* its triangles, for rays */
    svo_light_source source;
    svo_light_setup setup; /* that source, and the sky */
    double edge; /* of the grid, world units */
    double range; /* of ambient occlusion, world units; occlusion within it counts fully */
    size_t count; /* of points */
    svo_gather_point *points;
    path_result *results;
    double mean_irradiance; /* over points and channels: errors of irradiance are relative to it */
    unsigned samples; /* a point */
    double largest_error; /* standard error of ambient occlusion */
} cone_truth;

typedef struct truth_scene {
    error_scene scene;
    svo_light_source source;
    float sky[3];
} truth_scene;

/* Points are spread by area. Those between surfaces that all but touch are left out, where surfaces within 1/64 of the
   grid's width leave less than a tenth of the hemisphere open. Returns the exit code; on failure nothing is left to
   release. */
int cone_truth_make(error_run *run, const truth_scene *given, size_t point_count, unsigned samples, cone_truth *out);
void cone_truth_free(cone_truth *truth);

/* Differences from the truth over all points. */
typedef struct truth_error {
    double rmse, p99, largest, bias; /* bias: the signed mean, measured - true */
} truth_error;

/* Ambient occlusion, one number a point. Fails for lack of memory: then all are NAN. */
truth_error cone_truth_openness_error(const cone_truth *truth, const double *openness);
/* Irradiance, three channels a point, in units of mean_irradiance. */
truth_error cone_truth_irradiance_error(const cone_truth *truth, const double *irradiance);

#endif
