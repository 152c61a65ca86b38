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

#define GATHER_NO_VERTEX UINT32_MAX

/* Hashed and compared as bytes: no padding. */
typedef struct gather_vertex {
    float position[3];
    float normal[3]; /* zero: none */
    float uv[2];
    uint8_t color[4];
} gather_vertex;

/* The hash is kept beside the index: most other vertices are told apart without being looked at. */
typedef struct gather_slot {
    uint32_t hash;
    uint32_t index; /* GATHER_NO_VERTEX: free */
} gather_slot;

typedef struct gather {
    bool has_normals, has_colors, has_uvs;
    gather_vertex *vertices;
    size_t vertex_count, vertex_capacity;
    gather_slot *slots; /* hash table of vertices; at most half full */
    size_t slot_count; /* a power of two */
    uint32_t *indices; /* three per triangle; GATHER_NO_VERTEX: the file names a vertex that does not exist */
    uint16_t *triangle_materials;
    size_t triangle_count, triangle_capacity;
    svo_material *materials;
    svo_finish *finishes; /* of the materials */
    size_t material_count, material_capacity;
} gather;

/* Room for so many vertices, all different, and triangles: saves growing step by step. hashed: for svo_i_gather_vertex,
   else for svo_i_gather_append. */
bool svo_i_gather_reserve(gather *mesh, size_t vertex_count, size_t triangle_count, bool hashed);
/* These return false when memory or 32-bit indices run out. */
bool svo_i_gather_vertex(gather *mesh, const gather_vertex *vertex, uint32_t *index);
/* Adds a vertex that is known to be new; svo_i_gather_vertex does not find it. */
bool svo_i_gather_append(gather *mesh, const gather_vertex *vertex, uint32_t *index);
bool svo_i_gather_triangle(gather *mesh, const uint32_t corners[3], uint16_t material);
/* The new one is the last. finish: NULL means diffuse. */
bool svo_i_gather_material(gather *mesh, const svo_material *material, const svo_finish *finish);
/* If all materials are plain white and diffuse, the mesh is stored without any. */
void svo_i_gather_drop_plain_materials(gather *mesh);
void svo_i_gather_free(gather *mesh);

/*
 * Per vertex the first one that is equal to it, itself where there is none before. Faster than svo_i_gather_vertex one
 * by one, since look-ups do not wait for each other.
 *
 * count: at most GATHER_NO_VERTEX. Returns false when memory runs out.
 */
bool svo_i_gather_match(const gather_vertex *vertices, size_t count, uint32_t *first);

/* Writes the mesh's frames (import_stream.h), all but textures and the end. Returns 0, or -1 when the parent is
   gone. */
int svo_i_gather_send(const gather *mesh, int stream);

#endif
