/* SPDX-License-Identifier: MIT */
/*
 * Random meshes with every attribute that payload is made of: colors, normals, texture coordinates, materials,
 * textures. Inside a running cmocka test, which fails when memory runs out.
 */
#ifndef SVOCL_TESTS_ATTRIBUTED_MESH_H
#define SVOCL_TESTS_ATTRIBUTED_MESH_H

#include "meshes.h"

enum { ATTRIBUTED_MATERIALS = 8, ATTRIBUTED_TEXTURES = 5 };

/* A mesh with every attribute there is; tests take away what they do without. */
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

/* Triangles as of random_mesh. Released by attributed_mesh_destroy. */
void attributed_mesh_create(uint64_t seed, size_t triangle_count, double reach, attributed_mesh *out);
void attributed_mesh_destroy(attributed_mesh *made);

#endif
