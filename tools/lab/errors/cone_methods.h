/* SPDX-License-Identifier: MIT */
/* Cones, gathered in many ways at the points of a truth. */
#ifndef SVOCL_TOOLS_ERRORS_CONE_METHODS_H
#define SVOCL_TOOLS_ERRORS_CONE_METHODS_H

#include "errors/cone_truth.h"

#define CONE_LIGHTS_MAX 8u
#define CONE_TREES_MAX  5u

/* One way to gather. */
typedef struct cone_way {
    const char *method; /* what the table calls it: ways that differ in one number have the same name */
    unsigned depth;
    svo_coverage coverage;
    svo_light_form form;
    svo_opacity opacity;
    svo_march march;
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
