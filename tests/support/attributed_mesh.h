/* SPDX-License-Identifier: MIT */
/*
 * Random meshes with every attribute that the payload is computed from: colors, normals, texture coordinates,
 * materials, textures. Call them inside a running cmocka test; the test fails when memory runs out.
 */
#ifndef SVOCL_TESTS_ATTRIBUTED_MESH_H
#define SVOCL_TESTS_ATTRIBUTED_MESH_H

#include "meshes.h"

enum { ATTRIBUTED_MATERIALS = 8, ATTRIBUTED_TEXTURES = 5 };

/* A mesh with every attribute; tests remove the ones they do not need. */
typedef struct attributed_mesh {
    owned_mesh base;
    svo_mesh mesh;
    uint8_t *colors;
    float *normals, *uvs;
    uint16_t *triangle_materials;
    svo_material materials[ATTRIBUTED_MATERIALS];
    svo_texture textures[ATTRIBUTED_TEXTURES];
    uint8_t *texels;
} attributed_mesh;

/* The triangles of random_mesh. Released by attributed_mesh_destroy. */
void attributed_mesh_create(uint64_t seed, size_t triangle_count, double reach, attributed_mesh *out);
void attributed_mesh_destroy(attributed_mesh *made);

#endif
