/* SPDX-License-Identifier: MIT */
/* Materials of an assimp scene, in the import child. */
#ifndef SVO_LIB_IO_IMPORT_MATERIAL_H
#define SVO_LIB_IO_IMPORT_MATERIAL_H

#include <assimp/scene.h>
#include <stdbool.h>
#include <stdint.h>

#include "io/import_texture.h"

/* How a material wants its texture's coordinates: a channel of the mesh, and channel * scale + offset in assimp's
   orientation, which has v = 0 in the last row. */
typedef struct texture_use {
    unsigned uv_channel;
    float scale[2], offset[2];
} texture_use;

/*
 * The base color and color texture of one of assimp's materials. with_texture: false leaves the texture out, for meshes
 * without texture coordinates.
 * Sends the texture when it is new, or a warning when it cannot be read. Returns false when memory runs out or the
 * parent is gone.
 */
bool svo_i_import_material(texture_list *textures, const struct aiMaterial *source, bool with_texture,
                           svo_material *material, texture_use *use);

/* [0, 1] to 0 .. 255, rounded half up; what is not a number becomes 0. */
uint8_t svo_i_import_color_byte(float value);

#endif
