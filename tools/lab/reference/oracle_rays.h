/* SPDX-License-Identifier: MIT */
/*
 * Rays against every triangle of a mesh in long double: the reference for the ray kernels and for measurements of
 * other libraries. The mesh is the input's, or the snapped one. The edge functions are scalar triple products of the
 * corners relative to the ray origin, not the sheared form of the kernels.
 */
#ifndef SVOCL_TOOLS_REFERENCE_ORACLE_RAYS_H
#define SVOCL_TOOLS_REFERENCE_ORACLE_RAYS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct oracle_ray_scene {
    /* Three per vertex, in one of these arrays: world units; or snapped, in grid units. */
    const float *positions;
    const double *positions_double;
    const int32_t *vertices;
    const uint32_t *indices; /* three per triangle */
    size_t triangle_count;
    double origin[3], scale; /* of snapped vertices: (v - origin) * scale */
} oracle_ray_scene;

typedef struct oracle_ray {
    double origin[3], direction[3]; /* world */
    double t_min, t_max;
} oracle_ray;

typedef struct oracle_ray_hit {
    bool hit;
    double t;
    size_t triangle; /* position in indices */
} oracle_ray_hit;

/* The part of the ray that the triangle meets, if it does: false for none, else its t; a triangle seen edge-on is not
   met. */
bool oracle_ray_meets(const oracle_ray_scene *scene, size_t triangle, const oracle_ray *ray, double *t);

/* The t at which the ray meets the triangle's plane, wherever on it; infinity for a plane seen edge-on. */
long double oracle_ray_plane(const oracle_ray_scene *scene, size_t triangle, const oracle_ray *ray);

/* The closest hit; equal t: the lower index. */
oracle_ray_hit oracle_ray_closest(const oracle_ray_scene *scene, const oracle_ray *ray);

/* The number of triangles that the ray hits. */
size_t oracle_ray_count(const oracle_ray_scene *scene, const oracle_ray *ray);

/* The distance from a point (world) to the triangle, and the nearest of all triangles; equal distances: the lower
   index. */
double oracle_triangle_distance(const oracle_ray_scene *scene, size_t triangle, const double point[3]);
double oracle_nearest(const oracle_ray_scene *scene, const double point[3], size_t *triangle);

/* Whether the ray passes the triangle no farther than double can tell. Long double may take a ray that meets exactly a
   corner for one beside it. */
bool oracle_ray_touches(const oracle_ray_scene *scene, size_t triangle, const oracle_ray *ray);

#endif
