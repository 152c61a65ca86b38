/* SPDX-License-Identifier: MIT */
/*
 * What cones are an alternative to. Light by so many paths a point, as svo_gather takes them by default.
 * Ambient occlusion by exact rays, so many a point. And sets of exact cones, whose error is that of their directions
 * alone.
 */
#ifndef SVOCL_TOOLS_ERRORS_CONE_PEERS_H
#define SVOCL_TOOLS_ERRORS_CONE_PEERS_H

#include "errors/cones.h"
#include "measure/embree.h"

typedef struct few_paths {
    const error_run *run;
    const cone_truth *truth;
    svo_light *light; /* borrowed; has the truth's sources */
    unsigned per_point;
    svo_gather_result *results;
} few_paths;

/* per_point: as svo_gather_options.paths. False when memory runs out. */
bool few_paths_make(const error_run *run, const cone_truth *truth, svo_light *light, unsigned per_point,
                    few_paths *out);
void few_paths_free(few_paths *work);

/* Gathers ambient occlusion and light by paths: an interleaved_method's work. */
double few_paths_trace(void *user);
/* Of the last run. */
truth_error few_paths_error(const few_paths *work);

/* A square number of rays for each point of a truth. */
typedef struct occlusion_rays {
    const error_run *run;
    const cone_truth *truth;
    const embree *peer; /* traces them; NULL: svocl does */
    unsigned per_point;
    svo_ray *rays;
    svo_hit *hits;
} occlusion_rays;

/* Cosine-weighted, one in each cell of a square of strata. False when memory runs out. */
bool occlusion_rays_make(const error_run *run, const cone_truth *truth, unsigned per_point, occlusion_rays *out);
void occlusion_rays_free(occlusion_rays *work);

/* Traces the rays, any hit ends one: an interleaved_method's work. */
double occlusion_rays_trace(void *user);
/* Ambient occlusion from the hits of the last run, one number a point. */
void occlusion_rays_openness(const occlusion_rays *work, double *openness);

/* Ambient occlusion by the set of so many cones (1, 5, 6, 16, 64), each of which is the mean of rays evenly spread over
   its solid angle. Returns false when memory runs out or tracing fails. */
bool occlusion_exact_cones(const error_run *run, const cone_truth *truth, unsigned cones, double *openness);

#endif
