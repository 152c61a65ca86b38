/* SPDX-License-Identifier: MIT */
/* Shared by tests of rays: trees with lists, batches that must succeed, and the reference that tests every triangle.
   Call inside a running cmocka test. */
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

oracle_ray widen_ray(const svo_ray *ray);

/* The mesh as rays meet it: the input's, or the snapped one of a tree that has no other. */
oracle_ray_scene ray_scene_of(const built *tree);
/* Whether two values of t differ by no more than the ulp of a float. */
bool is_tied(double a, double b);
/* Checks that the hit is the reference's, or another triangle's with the same t. what: for the message. */
void assert_is_closest(const char *what, const built *tree, const svo_ray *ray, const svo_hit *hit);

/* A ray from anywhere in a cube of that width around the center of the unit cube, towards a point inside it. */
svo_ray random_ray(uint64_t *random, double spread);

/* A procedural scene by name; released by scene_destroy. */
scene *make_scene(const char *name);

#endif
