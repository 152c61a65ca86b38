/* SPDX-License-Identifier: MIT */
/*
 * A triangle mesh as the caller hands it over: borrowed arrays, read during svo_plan_create and not touched later.
 *
 * Any values are allowed in the arrays: triangles with an index out of range or a vertex that is not finite are refused
 * and counted, never undefined. Degenerate triangles (segments, points) are geometry and touch what they touch.
 */
#ifndef SVOCL_MESH_H
#define SVOCL_MESH_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/export.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How texture coordinates outside [0, 1) are read. */
typedef enum svo_wrap { SVO_WRAP_REPEAT = 0, SVO_WRAP_CLAMP = 1, SVO_WRAP_MIRROR = 2 } svo_wrap;

/* RGBA8 texels, 4 bytes each, rows top to bottom without padding; v = 0 is the first row. Sampled bilinearly in fixed
   point, the same on every device. width and height: 1 .. 16384. */
typedef struct svo_texture {
    const uint8_t *rgba;
    uint32_t width, height;
    svo_wrap wrap_u, wrap_v;
} svo_texture;

#define SVO_NO_TEXTURE UINT32_MAX

/* A triangle's colour is vertex colour * base colour * texel, each in [0, 255] / 255, rounded half up. */
typedef struct svo_material {
    uint8_t rgba[4]; /* base colour */
    uint32_t texture_index; /* into svo_mesh.textures; SVO_NO_TEXTURE, or any other value out of range: none */
} svo_material;

typedef struct svo_mesh {
    size_t struct_size; /* sizeof(svo_mesh) */

    /* Exactly one of the two, unless vertex_count is 0: x, y, z per vertex, any unit. */
    const float *positions;
    const double *positions_double;
    size_t vertex_count; /* below 2^32 - 1 */

    const uint32_t *indices; /* three per triangle; NULL: vertices 3t, 3t + 1, 3t + 2 */
    size_t triangle_count; /* below 2^32 - 1; the triangle ids of fragments and lists are positions in this array */

    /* Optional attributes, NULL where absent. */
    const float *normals; /* three per vertex, any length; not finite or zero: the triangle's own normal */
    const uint8_t *colors; /* RGBA8 per vertex */
    const float *uvs; /* two per vertex; not finite: 0; limited to -32767 .. 32767 */
    const uint16_t *triangle_materials; /* per triangle, below material_count; NULL: material 0 */
    const svo_material *materials;
    size_t material_count; /* 0: white, no texture; at most 65535 */
    const svo_texture *textures;
    size_t texture_count;
} svo_mesh;

#ifdef __cplusplus
}
#endif

#endif
