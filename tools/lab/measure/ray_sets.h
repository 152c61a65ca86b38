/* SPDX-License-Identifier: MIT */
/* The rays that `svocl bench rays` traces: the same bits on every machine. Tracers of the same rays are compared with
   each other and with the triangles in long double. */
#ifndef SVOCL_TOOLS_MEASURE_RAY_SETS_H
#define SVOCL_TOOLS_MEASURE_RAY_SETS_H

#include <stdbool.h>
#include <stddef.h>

#include "reference/oracle_rays.h"
#include "svocl/svocl.h"

/* A pinhole camera's rays of a square picture, by square tiles of that edge, in which the rays lie row by row, as the
   tiles do. 1: row by row of the picture. Rays after its last full row of tiles start again at the top. */
void ray_set_primary(const svo_camera *camera, unsigned tile, size_t count, svo_ray *rays);

/* From random points on the sphere around the box towards random points inside the box. */
void ray_set_incoherent(const double low[3], const double high[3], size_t count, svo_ray *rays);

/* From the same points away from the box: all miss it. */
void ray_set_misses(const double low[3], const double high[3], size_t count, svo_ray *rays);

/* Those of some rays that miss, in their order, again and again until there are count. False: all hit. */
bool ray_set_through(const svo_ray *among, const svo_hit *hits, size_t count, svo_ray *rays);

/* From where primary rays hit to a sun above and beside the camera, in the order of the hits, again and again until
   there are count. False: no ray hits. */
bool ray_set_shadow(const svo_camera *camera, const svo_ray *primary, const svo_hit *hits, size_t count, svo_ray *rays);

/* From the same places in directions of diffuse light: distributed as the cosine to the normal of the side that the
   primary ray met. t_max: of each. False: no ray hits. */
bool ray_set_diffuse(const svo_ray *primary, const svo_hit *hits, float t_max, size_t count, svo_ray *rays);

/* Whether two ts are equal up to rounding in float. */
bool ray_ties(double a, double b);
/* The ray in the reference's type. */
oracle_ray ray_widen(const svo_ray *ray);

/* How a hit compares with the triangle that it names, in exact numbers. */
typedef struct ray_t_error {
    bool beyond; /* the triangle's t is more than an ulp of float beyond that of the nearest one */
    double ulps; /* of its t to the triangle's */
} ray_t_error;

/* triangle: its index in the scene. t: as the hit has it. nearest: the exact t of the nearest triangle; infinity: the
   ray meets none. */
ray_t_error ray_judge_t(const oracle_ray_scene *scene, size_t triangle, const oracle_ray *ray, float t, double nearest);

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
