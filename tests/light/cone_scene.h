/* SPDX-License-Identifier: MIT */
/*
 * Scenes of a few triangles whose light is known, and points in them: turned and shifted on the grid, whose voxels are
 * a unit wide. Call inside a running cmocka test.
 */
#ifndef SVOCL_TESTS_CONE_SCENE_H
#define SVOCL_TESTS_CONE_SCENE_H

#include <stdbool.h>
#include <stdint.h>

#include "light_fixture.h"

#define CONE_SCENE_TRIANGLES_MAX 4096
#define CONE_SCENE_POINTS_MAX    4096

typedef struct cone_scene {
    uint32_t depth;
    uint64_t seed; /* of the poses */
    double turn[9], center[3]; /* the pose of what is added */
    size_t triangle_count, point_count;
    float corners[9 * CONE_SCENE_TRIANGLES_MAX];
    svo_gather_point points[CONE_SCENE_POINTS_MAX];
    double openness[CONE_SCENE_POINTS_MAX]; /* the truth */
    svo_gather_result results[CONE_SCENE_POINTS_MAX];
} cone_scene;

/* An empty scene on 2^depth voxels along each axis; allocated. */
cone_scene *cone_scene_new(uint32_t depth, uint64_t seed);
void cone_scene_free(cone_scene *scene);
/* Removes triangles and points. */
void cone_scene_clear(cone_scene *scene);

/* The pose of what is added from now on: about the grid's center, moved by up to so many voxels along each axis, and
   turned at random. */
void cone_scene_pose(cone_scene *scene, bool turned, double shift);

/* What is added, in voxels from the pose's center. Quads have the corners o, o + u, o + u + v, o + v, and the normal
   u x v. */
void cone_scene_add_quad(cone_scene *scene, const double o[3], const double u[3], const double v[3]);
void cone_scene_add_disk(cone_scene *scene, const double center[3], double radius); /* faces -z */
void cone_scene_add_sphere(cone_scene *scene, const double center[3], double radius);
void cone_scene_add_room(cone_scene *scene, const double half[3]); /* seen from inside */
void cone_scene_flip(cone_scene *scene); /* winds all triangles the other way */
void cone_scene_add_point(cone_scene *scene, const double position[3], const double normal[3], double openness);

/* Builds a tree with areas and normals; the caller destroys it. */
svo_tree *cone_scene_build(const fixture *opened, const cone_scene *scene, uint32_t need);
/* Builds a tree of the scene's triangles, of which the first `plain` have material 0 and the others material 1; colors:
   of the materials. The caller destroys it. */
svo_tree *cone_scene_build_colored(const fixture *opened, const cone_scene *scene, size_t plain,
                                   const uint8_t colors[2][4], uint32_t need);
/* Gathers at all points, into results. options: NULL means 16 cones. */
void cone_scene_gather(const fixture *opened, cone_scene *scene, svo_light *light, const svo_gather_options *options);
/* The same with the light of a form, which lives for the call. */
void cone_scene_gather_form(const fixture *opened, cone_scene *scene, svo_light_form form,
                            const svo_gather_options *options);
/* The openness of all points by exact rays, side * side each. */
void cone_scene_trace_openness(const fixture *opened, cone_scene *scene, uint32_t side);

/* Errors of openness. */
typedef struct cone_errors {
    double square_sum, sum, worst;
    size_t count;
} cone_errors;

void cone_errors_add(cone_errors *errors, double difference);
void cone_errors_add_scene(cone_errors *errors, const cone_scene *scene);
double cone_errors_rms(const cone_errors *errors);
double cone_errors_mean(const cone_errors *errors);

#endif
