/* SPDX-License-Identifier: MIT */
/*
 * Random scenes of voxels and of triangles: their tree, their light, and the same on dense grids. Call inside a running
 * cmocka test.
 */
#ifndef SVOCL_TESTS_LIGHT_SCENE_H
#define SVOCL_TESTS_LIGHT_SCENE_H

#include "light_fixture.h"
#include "light_reference.h"

#define LIGHT_SCENE_DEPTH 5u
#define LIGHT_SCENE_WIDTH ((size_t)1 << LIGHT_SCENE_DEPTH)
#define LIGHT_SCENE_CELLS (LIGHT_SCENE_WIDTH * LIGHT_SCENE_WIDTH * LIGHT_SCENE_WIDTH)

typedef struct light_scene {
    uint8_t *alphas; /* LIGHT_SCENE_CELLS; NULL for a mesh */
    svo_tree *tree;
    svo_tree_info info;
    svo_light *light;
    light_levels levels; /* opacity */
    uint16_t *opacity; /* SVO_LIGHT_OPACITY */
} light_scene;

/* Clusters of voxels, some of them transparent. */
void light_scene_open(const fixture *opened, uint64_t seed, svo_light_form form, light_scene *out);
/* Random triangles with colors, normals and projected areas. */
void light_scene_open_mesh(const fixture *opened, uint64_t seed, svo_light_form form, light_scene *out);
void light_scene_close(light_scene *scene);

/* Where a sample of a brick is in the lattice of the level below its node. */
void light_scene_place(const svo_node *node, uint32_t sample, int at[3]);

#endif
