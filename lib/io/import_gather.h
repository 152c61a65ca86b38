/* SPDX-License-Identifier: MIT */
/*
 * The mesh that an import child gathers: triangles over distinct vertices. Corners that are equal in all attributes,
 * bit for bit, share a vertex. (Most formats give every triangle three corners of its own, which would triple what is
 * sent, snapped and uploaded. assimp's own joining also merges positions that are merely close.)
 */
#ifndef SVO_LIB_IO_IMPORT_GATHER_H
#define SVO_LIB_IO_IMPORT_GATHER_H

#include <math.h>
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

typedef struct gather_material {
    svo_material base;
    svo_finish finish;
    svo_normal_map normal_map;
} gather_material;

typedef struct gather {
    bool has_normals, has_colors, has_uvs;
    gather_vertex *vertices;
    size_t vertex_count, vertex_capacity;
    gather_slot *slots; /* hash table of vertices; at most half full */
    size_t slot_count; /* a power of two */
    uint32_t *indices; /* three per triangle; GATHER_NO_VERTEX: the file names a vertex that does not exist */
    uint16_t *triangle_materials;
    size_t triangle_count, triangle_capacity;
    gather_material *materials;
    size_t material_count, material_capacity;
    uint32_t *file_vertices; /* per vertex of the file the mesh's; GATHER_NO_VERTEX: in no face. NULL: not known */
    size_t file_vertex_count;
} gather;

/* Room for so many vertices, all different, and triangles: saves growing step by step. hashed: for svo_i_gather_vertex,
   else for svo_i_gather_append. */
bool svo_i_gather_reserve(gather *mesh, size_t vertex_count, size_t triangle_count, bool hashed);
/* These return false when memory or 32-bit indices run out. */
bool svo_i_gather_vertex(gather *mesh, const gather_vertex *vertex, uint32_t *index);
/* Adds a vertex that is known to be new; svo_i_gather_vertex does not find it. */
bool svo_i_gather_append(gather *mesh, const gather_vertex *vertex, uint32_t *index);
bool svo_i_gather_triangle(gather *mesh, const uint32_t corners[3], uint16_t material);
/* White and diffuse, without textures. */
gather_material svo_i_gather_plain_material(void);
/* Whether it has a texture, so that its triangles need texture coordinates. */
bool svo_i_gather_is_textured(const gather_material *material);
/* The new one is the last. */
bool svo_i_gather_material(gather *mesh, const gather_material *material);
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

/* ---- transforms of nodes, in double ---- */

#define TRANSFORM_UNIT_ERROR 1e-6 /* of the squared length of a quaternion of floats */

/* The affine part of a 4 x 4 matrix, rows of 3 and a translation. */
typedef struct transform {
    double linear[3][3];
    double offset[3];
    double normal[3][3]; /* the inverse transpose up to a positive factor */
    bool is_identity; /* coordinates are copied bit for bit */
    bool mirrors; /* reverses the winding, so corners are listed in the opposite order */
} transform;

static inline transform transform_identity(void)
{
    return (transform){
        .linear = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .normal = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .is_identity = true};
}

/* The cofactors are the inverse transpose times the determinant, and exist where the inverse does not. */
static inline void transform_derive_normal(transform *t)
{
    double(*const m)[3] = t->linear;
    for (int i = 0; i < 3; ++i) {
        const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
        for (int k = 0; k < 3; ++k) {
            const int k1 = (k + 1) % 3, k2 = (k + 2) % 3;
            t->normal[i][k] = m[i1][k1] * m[i2][k2] - m[i1][k2] * m[i2][k1];
        }
    }
    const double determinant = m[0][0] * t->normal[0][0] + m[0][1] * t->normal[0][1] + m[0][2] * t->normal[0][2];
    t->mirrors = determinant < 0;
    for (int i = 0; i < 9 && t->mirrors; ++i) {
        t->normal[i / 3][i % 3] = -t->normal[i / 3][i % 3];
    }
}

/* parent applied after a node's own matrix, rows of 4. */
static inline transform transform_combine(const transform *parent, const double local[3][4])
{
    static const double none[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    bool is_identity = true;
    for (int i = 0; i < 12; ++i) {
        is_identity = is_identity && local[i / 4][i % 4] == none[i / 4][i % 4];
    }
    if (is_identity) {
        return *parent;
    }
    transform result = {.is_identity = false};
    for (int row = 0; row < 3; ++row) {
        result.offset[row] = parent->offset[row];
        for (int k = 0; k < 3; ++k) {
            result.offset[row] += parent->linear[row][k] * local[k][3];
            for (int column = 0; column < 3; ++column) {
                result.linear[row][column] += parent->linear[row][k] * local[k][column];
            }
        }
    }
    transform_derive_normal(&result);
    return result;
}

/*
 * Translation, rotation as a quaternion x, y, z, w, and scale. In floats, which the file's numbers mostly are, so that
 * trees stay the same bytes from version to version. Quaternions of integers are not quite of length 1.
 */
static inline void transform_compose(const double move[3], const double turn[4], const double scale[3],
                                     double local[3][4])
{
    const double length2 = turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2] + turn[3] * turn[3];
    const double to_unit = fabs(length2 - 1) < TRANSFORM_UNIT_ERROR || !(length2 > 0) ? 1 : 1 / sqrt(length2);
    const float x = (float)(turn[0] * to_unit), y = (float)(turn[1] * to_unit);
    const float z = (float)(turn[2] * to_unit), w = (float)(turn[3] * to_unit);
    const float rotation[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                                  {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                                  {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) {
            local[row][column] = (double)(rotation[row][column] * (float)scale[column]);
        }
        local[row][3] = (double)(float)move[row];
    }
}

static inline void transform_apply(const double linear[3][3], const double offset[3], const double vector[3],
                                   float out[3])
{
    for (int row = 0; row < 3; ++row) {
        out[row] =
            (float)(linear[row][0] * vector[0] + linear[row][1] * vector[1] + linear[row][2] * vector[2] + offset[row]);
    }
}

/* A vertex's position, and its normal at any length. */
static inline void transform_point(const transform *t, const double point[3], float out[3])
{
    for (int i = 0; i < 3 && t->is_identity; ++i) {
        out[i] = (float)point[i];
    }
    if (!t->is_identity) {
        transform_apply(t->linear, t->offset, point, out);
    }
}

static inline void transform_normal(const transform *t, const double normal[3], float out[3])
{
    static const double no_offset[3] = {0};
    for (int i = 0; i < 3 && t->is_identity; ++i) {
        out[i] = (float)normal[i];
    }
    if (!t->is_identity) {
        transform_apply(t->normal, no_offset, normal, out);
    }
}

#endif
