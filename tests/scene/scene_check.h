/* SPDX-License-Identifier: MIT */
/* Shared by tests of scenes: trees to place, random instances, and references in double. Call inside a running cmocka
   test. */
#ifndef SVOCL_TESTS_SCENE_CHECK_H
#define SVOCL_TESTS_SCENE_CHECK_H

#include "support/fixture.h"
#include "support/meshes.h"

#define MODELS 3
#define RAYS   1000

/* Trees of different shapes, depths and grids, with leaf lists, colors and normals. */
typedef struct models {
    built trees[MODELS];
    svo_tree *handles[MODELS];
} models;

void models_make(models *out);
void models_destroy(models *made);

/* Shared by all tests of a program, since trees take longer to build than to place. */
extern fixture opened;
extern models shapes;
int scene_group_open(void **state);
int scene_group_close(void **state);

extern const svo_instance identity; /* of the first tree */

/* The device's message after a failure. */
void expect_words(svo_status status, svo_status expected, const char *words);

/* Compares RAYS records of so many bytes, which begin with t. what, count: for the message. */
void assert_same_hits(const char *what, uint32_t count, const void *hits, const void *expected, size_t bytes);
/* The scene's hits of RAYS rays must be those of a new scene. */
void compare_with_new_scene(svo_scene *moved, const svo_instance *placed, uint32_t count, const svo_ray *rays);

/* Instances of all trees anywhere in a cube of that width: turned, and by kind also mirrored, sheared, and scaled by
   1e-3 .. 1e3, each axis by itself. */
typedef enum placement { PLACE_MOVED, PLACE_SCALED, PLACE_SHEARED } placement;
void random_instances(uint64_t *random, placement kind, double width, svo_instance *out, uint32_t count);

/* Rays from anywhere in a cube around the instances towards points near one of them. */
void random_scene_rays(uint64_t *random, const models *of, const svo_instance *instances, uint32_t instance_count,
                       svo_ray *out, size_t count);

/* need: as svo_scene_options. */
svo_scene *make_placed_scene(const models *of, const svo_instance *instances, uint32_t count, uint32_t need);
void trace_scene(svo_scene *traced, const svo_ray *rays, svo_scene_hit *hits, size_t count, float footprint,
                 uint32_t flags);

/* The first leaf along the ray of all instances, from boxes in double; t is infinite without one. */
typedef struct reference_hit {
    double t;
    uint32_t instance;
} reference_hit;
reference_hit reference_closest(const models *of, const svo_instance *instances, uint32_t count, const svo_ray *ray);

/* The inverse of the linear part of a matrix, row by row. */
void invert_linear(const float transform[12], double out[9]);
/* The ray in the instance's tree, rounded to floats. */
svo_ray ray_in_tree(const svo_instance *instance, const svo_ray *ray);

#endif
