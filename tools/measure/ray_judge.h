/* SPDX-License-Identifier: MIT */
/* Two answers to the same rays: where they differ, and who is right by trying every triangle in long double. */
#ifndef SVOCL_TOOLS_MEASURE_RAY_JUDGE_H
#define SVOCL_TOOLS_MEASURE_RAY_JUDGE_H

#include "reference/oracle_rays.h"
#include "svocl/svocl.h"

/* Whether two ts are the same up to rounding in float. */
bool ray_ties(double a, double b);
/* The ray as the reference takes it. */
oracle_ray ray_widen(const svo_ray *ray);

typedef struct ray_verdict {
    size_t hits; /* of ours */
    double leaves; /* that ours looked into, mean over all rays */
    size_t differing; /* ids that differ, for whatever cause: the sum of the three below */
    size_t tied; /* both met something at the same t, up to rounding: an edge or a corner that triangles share */
    size_t wrong_ids, missed; /* ours against the reference; missed: it met something, ours did not */
    size_t their_wrong_ids, their_missed;
} ray_verdict;

/* triangle_ids: of the scene's triangles, ascending. theirs: NULL: nothing to compare with. */
ray_verdict ray_judge(const oracle_ray_scene *scene, const uint32_t *triangle_ids, const svo_ray *rays,
                      const svo_hit *ours, const svo_hit *theirs, size_t ray_count);

#endif
