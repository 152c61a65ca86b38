/* SPDX-License-Identifier: MIT */
/* Sets of rays through a scene with their exact hits, and a verdict on what probes make of them. */
#ifndef SVOCL_TOOLS_ERRORS_PROBE_RAYS_H
#define SVOCL_TOOLS_ERRORS_PROBE_RAYS_H

#include "errors/errors.h"
#include "svocl/probes.h"

typedef enum probe_ray_kind {
    PROBE_RAYS_PRIMARY = 0, /* of a camera */
    PROBE_RAYS_COSINE, /* from what the camera sees, a leaf's edge above it, cosine-weighted */
    PROBE_RAYS_RANDOM, /* from anywhere in the grid in any direction */
    PROBE_RAYS_COUNT
} probe_ray_kind;

const char *probe_rays_name(probe_ray_kind kind);

/* Directions are unit vectors. */
typedef struct probe_rays {
    size_t count;
    svo_ray *rays;
    svo_hit *exact;
} probe_rays;

/* Fills PROBE_RAYS_COUNT sets of count rays. tree: with SVO_NEED_RAYS, on a device. False on failure, with the reason
   in the device's message; what was made then is still released by probe_rays_free. */
bool probe_rays_make(const error_run *run, svo_tree *tree, const svo_camera *camera, size_t count, probe_rays *sets);
void probe_rays_free(probe_rays *sets);

/* Shares of all rays in percent, and errors of distances. */
typedef struct probe_verdict {
    double hit, miss, unknown;
    double wrong_hit; /* nothing is there, or it is more than two leaves nearer or farther */
    double wrong_miss; /* something is there */
    double median, p90, p99; /* of |t - exact| in leaf edges, where both hit; NAN where none does */
} probe_verdict;

/* False when memory runs out. */
bool probe_rays_judge(const probe_rays *set, const svo_probe_hit *hits, double leaf_edge, probe_verdict *out);

#endif
