/* SPDX-License-Identifier: MIT */
/* Materials of an assimp scene, in the import child. */
#ifndef SVO_LIB_IO_IMPORT_MATERIAL_H
#define SVO_LIB_IO_IMPORT_MATERIAL_H

#include <assimp/scene.h>
#include <stdbool.h>
#include <stdint.h>

#include "io/import_texture.h"

/* A texture's coordinates: a channel of the mesh, transformed to channel * scale + offset in assimp's orientation,
   where v = 0 is the last row. */
typedef struct texture_use {
    unsigned uv_channel;
    float scale[2], offset[2];
} texture_use;

/*
 * The base color and color texture of one of assimp's materials. with_texture: false leaves the texture out, for meshes
 * without texture coordinates.
 * Sends a new texture, or a warning when it cannot be read. Returns false when memory runs out or the parent has closed
 * the pipe.
 */
bool svo_i_import_material(texture_list *textures, const struct aiMaterial *source, bool with_texture,
                           svo_material *material, texture_use *use);

/*
 * What one of assimp's materials does besides its color: emission, specular color and its exponent.
 */
void svo_i_import_finish(const struct aiMaterial *source, svo_finish *finish);

/* A finish that svo_light_set_sources takes: what is negative or not finite becomes 0, specular color is at most 1. A
   material without specular color has no exponent. */
void svo_i_import_tame_finish(svo_finish *finish);

/* [0, 1] to 0 .. 255, rounded half up; NaN becomes 0. */
uint8_t svo_i_import_color_byte(float value);

#endif
