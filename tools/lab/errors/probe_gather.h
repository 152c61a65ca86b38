/* SPDX-License-Identifier: MIT */
/* Light at the points of a truth from probes: by rays through them, or from their prefiltered maps. */
#ifndef SVOCL_TOOLS_ERRORS_PROBE_GATHER_H
#define SVOCL_TOOLS_ERRORS_PROBE_GATHER_H

#include "errors/cone_truth.h"
#include "svocl/probes.h"

typedef struct probe_gather {
    const error_run *run;
    const cone_truth *truth;
    svo_probes *probes;
    unsigned per_point; /* rays; 0: prefiltered */
    svo_ray *rays;
    svo_probe_hit *hits;
    svo_probe_irradiance *results; /* where prefiltered */
} probe_gather;

/* probes: with a light, and diffuse where strata is 0. strata: of a point's cosine-weighted rays along a side of their
   square; they begin lift world units above the surface. False when memory runs out; what was made then is still
   released by probe_gather_free. */
bool probe_gather_make(const error_run *run, const cone_truth *truth, svo_probes *probes, unsigned strata, double lift,
                       probe_gather *out);
void probe_gather_free(probe_gather *work);

/* Traces the rays, or reads the maps: an interleaved_method's work. */
double probe_gather_work(void *user);
/* Of the irradiance of the last run. Unknown rays are left out of a point's mean; where all are, the point is dark. */
truth_error probe_gather_error(const probe_gather *work);

#endif
