/* SPDX-License-Identifier: MIT */
/*
 * Rays per second of svocl and of its rivals, interleaved, for the same rays and the same triangles. A rival is Embree
 * with one of its builds and calls, or a grid of the tree's leaf lists on the same device.
 *
 * The mesh is snapped to integers before the build, so that grid units are world units and all get the same bits for
 * every vertex and every ray.
 */
#ifndef SVOCL_TOOLS_BENCH_RAY_RUN_H
#define SVOCL_TOOLS_BENCH_RAY_RUN_H

#include "bench/grid_rays.h"
#include "measure/embree.h"
#include "measure/ray_sets.h"
#include "measure/spread.h"
#include "support/job.h"

#define RAY_BUILDS     4 /* of Embree */
#define RAY_CALLS      3 /* widths of Embree's medium build */
#define RAY_RIVALS_MAX (RAY_CALLS + RAY_BUILDS - 1)

typedef enum ray_set_kind {
    RAY_SET_PRIMARY = 0, /* in tiles of 4 x 4, which packets of 16 are */
    RAY_SET_ROWS, /* the same picture row by row */
    RAY_SET_CLOSE, /* in tiles, from a quarter of the distance */
    RAY_SET_SHADOW, /* from where the primary rays hit, as the next two */
    RAY_SET_BOUNCE,
    RAY_SET_OCCLUSION, /* within a twentieth of the box's diagonal */
    RAY_SET_INCOHERENT,
    RAY_SET_THROUGH, /* those of the incoherent rays that miss */
    RAY_SET_MISSES, /* away from the box */
    RAY_SETS
} ray_set_kind;

/* One of the others with one set of rays. */
typedef struct ray_rival {
    const char *build; /* "medium", "robust", ...; "" for the grid */
    const embree *peer; /* NULL: the grid */
    unsigned width; /* of the call; 0: the fastest one */
    embree_call call; /* chosen in the warm-up round */
    spread ms, ratio; /* ratio: its time to svocl's, within each round */
} ray_rival;

/* One set of rays, and its results. */
typedef struct ray_set {
    const char *name;
    bool any; /* whether a ray meets anything, in place of the first hit */
    bool is_measured; /* false: no such rays, or the rival has no such call */
    svo_ray *rays;
    spread ours_ms;
    ray_rival rivals[RAY_RIVALS_MAX];
    size_t rival_count;
    size_t best; /* the fastest rival among Embree's calls with its medium build, or the grid */
    ray_verdict verdict; /* of svocl and the first rival */
} ray_set;

typedef struct ray_run {
    program *state;
    job work;
    svo_mesh snapped; /* the input with integer coordinates */
    float *positions;
    embree *peers[RAY_BUILDS]; /* NULL: not asked for */
    grid_rays *grid; /* the same */
    unsigned threads;
    size_t ray_count, repeats;
    svo_hit *ours, *theirs, *spare;
    svo_hit *primary; /* svocl's hits of the set from which others start */
    cl_mem device_rays, device_hits, grid_hits;
    ray_set sets[RAY_SETS];
} ray_run;

/* Builds and measures by the options, whose versus chooses the rivals. Returns the exit code, its line printed; what
   the run owns ray_run_release releases either way. */
int ray_run_all(ray_run *run);
void ray_run_release(ray_run *run);

bool ray_run_has_rivals(const ray_run *run);
/* "rtcIntersect8", "rtcOccluded1", ...; "grid" */
void ray_rival_call(const ray_rival *rival, char *text, size_t text_bytes);
/* Millions of rays per second. */
double ray_run_rate(const ray_run *run, double ms);

#endif
