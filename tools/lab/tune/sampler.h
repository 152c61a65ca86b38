/* SPDX-License-Identifier: MIT */
/*
 * Errors of trees against the mesh as it was given. Distances and rays are svo_tree_nearest and svo_trace_triangles of
 * the input's own vertices, which are exact up to the rounding of a float; means of payload are sums in double over the
 * parts of the triangles in a voxel; light is traced by path.h. Sample points come in rungs, each of new points.
 */
#ifndef SVOCL_TOOLS_TUNE_SAMPLER_H
#define SVOCL_TOOLS_TUNE_SAMPLER_H

#include "path/path.h"
#include "support/input.h"
#include "support/lights_file.h"
#include "support/session.h"
#include "tune/dimensions.h"
#include "tune/measures.h"
#include "tune/ray_errors.h"

typedef struct sampler {
    program *state;
    const input *source;
    session *opened; /* borrowed */
    svo_tree *truth; /* with lists, at the ray depth */
    svo_tree_info grid; /* of truth: its origin and edge are those of all trees */
    double area, volume; /* of the mesh, world units; volume 0: it is not closed */
    bool has_colors;
    uint32_t measured; /* svo_need bits of what is measured; others were not asked for */
    unsigned threads;
    ray_truth rays;
    lights_file lights; /* of --lights */
    svo_light_source sun;
    svo_light_setup setup; /* the file's lights, or the sun and a sky */
    double range; /* of ambient occlusion: that of `svocl gather` */
    uint32_t light_seed; /* of the truth below */
    svo_gather_point *points; /* NULL: not made yet */
    path_result *lit; /* after one reflection of the lights */
    path_result *twice_lit; /* after two, which probes have */
    bool has_probes; /* some setting does; else there is no twice_lit */
} sampler;

/* Returns the exit code; on failure nothing is left to release. */
int sampler_open(program *state, const input *source, session *opened, sampler *out);
void sampler_close(sampler *made);

/* Sample points of a rung. */
size_t sampler_points(unsigned rung);
/* Adds the points of a rung and seed to the errors of a setting. Those of a kind may be NULL, and of light are. Returns
   the exit code. */
typedef struct sampler_targets {
    tune_errors *of[KIND_COUNT];
} sampler_targets;
int sampler_add(sampler *made, const tune_setting *setting, unsigned rung, uint32_t seed,
                const sampler_targets *targets);

#endif
