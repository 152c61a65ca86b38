/* SPDX-License-Identifier: MIT */
/* Materials of a glTF file, in the import child. */
#ifndef SVO_LIB_IO_IMPORT_GLTF_MATERIAL_H
#define SVO_LIB_IO_IMPORT_GLTF_MATERIAL_H

#include "io/import_gltf_file.h"
#include "io/import_texture.h"

/* What alpha means: alphaMode, alphaCutoff, and the base color's alpha, by which others are multiplied. */
typedef struct gltf_alpha {
    bool is_opaque; /* there is none */
    bool is_mask; /* all or nothing */
    double factor, cutoff;
} gltf_alpha;

/* A texture's coordinates: of a set of the mesh, rows of a 2 x 3 matrix applied to u, v, 1. */
typedef struct gltf_uvs {
    uint32_t set;
    bool is_identity;
    double matrix[2][3];
} gltf_uvs;

typedef struct gltf_look {
    svo_material material;
    svo_finish finish;
    gltf_alpha alpha;
    gltf_uvs uvs;
} gltf_look;

/* A material of the file; index GLTF_NONE: the default one. with_texture: false leaves its texture out. A new image is
   sent, or a warning. */
svo_status svo_i_gltf_material(gltf_file *file, texture_list *textures, uint32_t index, bool with_texture,
                               gltf_look *look);

/* The alpha of a vertex, without the base color's. */
uint8_t svo_i_gltf_alpha_byte(const gltf_alpha *alpha, double value);

/* Linear [0, 1] to sRGB (IEC 61966-2-1), 0 .. 255, rounded; the same on every platform. */
uint8_t svo_i_gltf_srgb_byte(double linear);

#endif
