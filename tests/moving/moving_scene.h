/* SPDX-License-Identifier: MIT */
/* A scene of random meshes that move, and the full builds that its trees must equal. A failure fails the test. */
#ifndef SVOCL_TESTS_MOVING_SCENE_H
#define SVOCL_TESTS_MOVING_SCENE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "support/attributed_mesh.h"
#include "support/fixture.h"

enum { OBJECTS = 5 };

/* A static mesh around the unit cube and smaller objects, of random triangles with every attribute. */
typedef struct actors {
    attributed_mesh room, objects[OBJECTS];
    float *floats[OBJECTS + 1]; /* their positions; NULL: doubles */
} actors;

/* An object has triangles of its own materials, without or with indices, and a few that are refused. */
void actors_create(uint64_t seed, size_t triangles, bool in_floats, actors *out);
void actors_destroy(actors *made);

/* A random turn, stretch and shift; half of the objects reach outside the grid, some lie outside. */
void random_transform(uint64_t *seed, double out[12]);

/* struct_size of options need not be set. */
svo_moving *make_moving(const fixture *opened, const svo_mesh *mesh, unsigned depth, svo_moving_options options);
/* A scene of the room and all objects, not yet updated. */
svo_moving *make_stage(const fixture *opened, const actors *of, unsigned depth, svo_moving_options options);
void update_moving(const fixture *opened, svo_moving *moving);

/* What a tree holds. */
typedef struct outcome {
    char hash[SVO_HASH_TEXT_BYTES];
    svo_tree_info info;
    svo_tree_arrays arrays;
} outcome;

outcome outcome_of(const fixture *opened, svo_tree *tree);
void assert_same(const outcome *actual, const outcome *expected);

/* A full build of the scene's mesh. */
svo_tree *build_whole(const fixture *opened, svo_moving *moving, unsigned depth, const svo_moving_options *of);
/* Compares the tree with a full build. */
void compare_moving(const fixture *opened, svo_moving *moving, unsigned depth, const svo_moving_options *of);

/* A triangle moves, out of the grid too, hides, goes and comes back, so many times. Early on and at the end a scene
   holds the same: blocks of the host, lists, and what `held` says. Skips where kernels for another device run. */
void check_memory_is_flat(int updates, void (*update)(const fixture *opened, svo_moving *moving),
                          uint64_t (*held)(const svo_moving *moving));

#endif
