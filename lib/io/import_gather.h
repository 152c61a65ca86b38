/* SPDX-License-Identifier: MIT */
/*
 * The mesh that an import child gathers: triangles over distinct vertices. Corners that are equal in all attributes,
 * bit for bit, share a vertex. (Most formats give every triangle three corners of its own, which would triple what is
 * sent, snapped and uploaded. assimp's own joining also merges positions that are merely close.)
 */
#ifndef SVO_LIB_IO_IMPORT_GATHER_H
#define SVO_LIB_IO_IMPORT_GATHER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "svocl/io.h"

/* Hashed and compared as bytes: no padding. */
typedef struct gather_vertex {
    float position[3];
    float normal[3]; /* zero: none */
    float uv[2];
    uint8_t color[4];
} gather_vertex;

typedef struct gather {
    bool has_normals, has_colors, has_uvs;
    gather_vertex *vertices;
    size_t vertex_count, vertex_capacity;
    uint32_t *slots; /* hash table of vertex indices, EMPTY where free; at most half full */
    size_t slot_count; /* a power of two */
    uint32_t *indices; /* three per triangle; GATHER_NO_VERTEX: the file names a vertex that does not exist */
    uint16_t *triangle_materials;
    size_t triangle_count, triangle_capacity;
    svo_material *materials;
    size_t material_count, material_capacity;
} gather;

#define GATHER_NO_VERTEX UINT32_MAX

/* These return false when memory or 32-bit indices run out. */
bool svo_i_gather_vertex(gather *mesh, const gather_vertex *vertex, uint32_t *index);
bool svo_i_gather_triangle(gather *mesh, const uint32_t corners[3], uint16_t material);
bool svo_i_gather_material(gather *mesh, const svo_material *material); /* the new one is the last */
void svo_i_gather_free(gather *mesh);

/* Writes the mesh's frames (import_stream.h), all but textures and the end. Returns 0, or -1 when the parent is
   gone. */
int svo_i_gather_send(const gather *mesh, int stream);

#endif
