/* SPDX-License-Identifier: MIT */
/* Compares two tracers of the same rays, and decides where they differ by testing every triangle in long double. */
#ifndef SVOCL_TOOLS_MEASURE_RAY_JUDGE_H
#define SVOCL_TOOLS_MEASURE_RAY_JUDGE_H

#include "reference/oracle_rays.h"
#include "svocl/svocl.h"

/* Whether two ts are equal up to rounding in float. */
bool ray_ties(double a, double b);
/* The ray in the reference's type. */
oracle_ray ray_widen(const svo_ray *ray);

typedef struct ray_verdict {
    size_t hits; /* of svocl */
    double leaves; /* visited by svocl, mean over all rays */
    size_t differing; /* rays with different triangle IDs: tied, or one of the tracers is wrong */
    size_t tied; /* both hit at the same t, up to rounding: an edge or a vertex that triangles share */
    size_t wrong_ids, missed; /* of svocl; missed: the reference hits, svocl does not */
    size_t their_wrong_ids, their_missed; /* of the other tracer */
} ray_verdict;

/* triangle_ids: of the scene's triangles, ascending. ours: svocl's hits. theirs: NULL without another tracer. */
ray_verdict ray_judge(const oracle_ray_scene *scene, const uint32_t *triangle_ids, const svo_ray *rays,
                      const svo_hit *ours, const svo_hit *theirs, size_t ray_count);

/* The same of any hit: only whether a ray is occluded counts. */
ray_verdict ray_judge_occlusion(const oracle_ray_scene *scene, const svo_ray *rays, const svo_hit *ours,
                                const svo_hit *theirs, size_t ray_count);

#endif
