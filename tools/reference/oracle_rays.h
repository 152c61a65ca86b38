/* SPDX-License-Identifier: MIT */
/*
 * Rays against the snapped mesh by trying every triangle, in long double: the reference for the ray kernels and for
 * measurements beside other libraries. The edge functions here are scalar triple products of the corners as the ray's
 * origin sees them, not the sheared form of the kernels.
 */
#ifndef SVOCL_TOOLS_REFERENCE_ORACLE_RAYS_H
#define SVOCL_TOOLS_REFERENCE_ORACLE_RAYS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct oracle_ray_scene {
    const int32_t *vertices; /* three per vertex, snapped */
    const uint32_t *indices; /* three per triangle */
    size_t triangle_count;
    double origin[3], scale; /* world to grid units: (v - origin) * scale */
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

/* The first triangle by t, then by position. */
oracle_ray_hit oracle_ray_closest(const oracle_ray_scene *scene, const oracle_ray *ray);

/* How many triangles the ray meets. */
size_t oracle_ray_count(const oracle_ray_scene *scene, const oracle_ray *ray);

/* The distance from a point (world) to the triangle, and the nearest of all triangles, the first by position among
   equals. */
double oracle_triangle_distance(const oracle_ray_scene *scene, size_t triangle, const double point[3]);
double oracle_nearest(const oracle_ray_scene *scene, const double point[3], size_t *triangle);

#endif
