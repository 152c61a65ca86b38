/* SPDX-License-Identifier: MIT */
/* What tests of rays share: trees that hold lists, batches that must work, and the reference that tries every triangle.
   Inside a running cmocka test. */
#ifndef SVOCL_TESTS_RAY_CHECK_H
#define SVOCL_TESTS_RAY_CHECK_H

#include "fixture.h"
#include "oracle_rays.h"
#include "scenes.h"

/* edge 0: a grid fitted to the mesh. */
void build_for_rays(const fixture *opened, const svo_mesh *mesh, unsigned depth, const double origin[3], double edge,
                    built *out);
void trace_rays(const fixture *opened, const built *tree, const svo_ray *rays, size_t ray_count, uint32_t flags,
                svo_hit *hits);

oracle_ray_scene ray_scene_of(const built *tree);
oracle_ray widen_ray(const svo_ray *ray);

/* Whether two ts are the same up to the rounding of a float, or a thousandth of a grid unit. */
bool is_tied(const oracle_ray_scene *mesh, const svo_ray *ray, double a, double b);
/* The hit is the reference's, or another triangle's with the same t. what: for the message. */
void assert_is_closest(const char *what, const built *tree, const svo_ray *ray, const svo_hit *hit);

/* From anywhere in a cube of that width around the middle of the unit cube, towards a point inside it. */
svo_ray random_ray(uint64_t *random, double spread);

/* A procedural scene by name; released by scene_destroy. */
scene *make_scene(const char *name);

#endif
