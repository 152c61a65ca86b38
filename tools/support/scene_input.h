/* SPDX-License-Identifier: MIT */
/*
 * The surfaces of a scene's file in its world, as the mesh of one tree: meshes that are placed, and faces of voxels.
 */
#ifndef SVOCL_TOOLS_SUPPORT_SCENE_INPUT_H
#define SVOCL_TOOLS_SUPPORT_SCENE_INPUT_H

#include "support/input.h"
#include "support/program.h"
#include "support/scene_file.h"
#include "svocl/mesh.h"
#include "svocl/scene.h"
#include "svocl/tree.h"

/* A mesh with arrays of its own, but for texels. */
typedef struct placed_mesh {
    svo_mesh mesh; /* all zero: none */
    double *positions;
    uint32_t *indices;
    float *normals;
    uint8_t *colors;
    float *uvs;
    uint16_t *triangle_materials;
    svo_material *materials;
    svo_texture *textures;
    svo_finish *finishes;
    svo_normal_map *normal_maps;
} placed_mesh;

/* Surfaces that are placed, and what they borrow. */
typedef struct scene_input {
    input *sources; /* of the scene's trees: meshes, or nothing */
    placed_mesh *voxels; /* of the others: the surfaces of their voxels */
    size_t count; /* of both */
    placed_mesh placed;
} scene_input;

/* Reads all trees of the file, a step of the progress bar each, and places them: meshes themselves, and of finished
   trees the surfaces of their voxels. Returns the exit code; on failure nothing stays open. */
int scene_input_open(program *state, const scene_file *file, scene_input *out);
void scene_input_close(scene_input *opened);

#endif
