/* SPDX-License-Identifier: MIT */
/* A scene with its light, points on its surfaces, the path-traced truth there, and cones gathered in many ways. */
#ifndef SVOCL_TOOLS_ERRORS_CONES_H
#define SVOCL_TOOLS_ERRORS_CONES_H

#include "errors/errors.h"
#include "errors/published_march.h"
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

/* Of signed differences, at least one; they are replaced by their sizes in ascending order. */
truth_error truth_error_of(double *differences, size_t count);
/* Ambient occlusion, one number a point. Fails for lack of memory: then all are NAN. */
truth_error cone_truth_openness_error(const cone_truth *truth, const double *openness);
/* Irradiance, three channels a point, in units of mean_irradiance. */
truth_error cone_truth_irradiance_error(const cone_truth *truth, const double *irradiance);

#define CONE_LIGHTS_MAX 8u
#define CONE_TREES_MAX  5u

/* One way to gather. */
typedef struct cone_way {
    const char *method; /* what the table calls it: ways that differ in one number have the same name */
    unsigned depth;
    svo_coverage coverage;
    svo_light_form form;
    svo_opacity opacity;
    bool as_published; /* node to node, by five cones through bricks (published_march.h) */
    unsigned cones;
    float step;
} cone_way;

/* The trees and lights that ways share. */
typedef struct cone_lights {
    const error_run *run;
    const cone_truth *truth;
    struct {
        unsigned depth;
        svo_coverage coverage;
        svo_tree *tree;
    } trees[CONE_TREES_MAX];
    struct {
        svo_light *light;
        cone_way made_for;
    } lights[CONE_LIGHTS_MAX];
    size_t tree_count, light_count;
} cone_lights;

/* A way with its results. */
typedef struct cone_gather {
    cone_lights *lights;
    cone_way way;
    svo_light *light; /* of lights */
    svo_light_info info;
    svo_gather_result *results;
    published_march published; /* of a way as published */
} cone_gather;

/* Finds or makes the tree of a depth and a coverage, with all that light needs. NULL on failure, with the reason in the
   device's message. It belongs to lights. */
svo_tree *cone_lights_tree(cone_lights *lights, unsigned depth, svo_coverage coverage);

/* Finds or makes the light of a way. False on failure, with the reason in the device's message; what was made then is
   still released by cone_gather_free. */
bool cone_gather_make(cone_lights *lights, const cone_way *way, cone_gather *out);
void cone_gather_free(cone_gather *work);
void cone_lights_free(cone_lights *lights);

/* The work of interleaved methods: ambient occlusion alone, within the truth's range; light too, which has no range. */
double cone_gather_occlusion(void *user);
double cone_gather_light(void *user);

/* Gathers both ways once and compares the results. */
bool cone_gather_compare(cone_gather *work, truth_error *openness, truth_error *irradiance);

#endif
