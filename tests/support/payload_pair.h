/* SPDX-License-Identifier: MIT */
/* Lookups that both payload references (payload_reference.c in integers, payload_doubles.c) use. */
#ifndef SVOCL_TESTS_PAYLOAD_PAIR_H
#define SVOCL_TESTS_PAYLOAD_PAIR_H

#include "compare_tree.h"

/* A pair's triangle and voxel. Corners are the caller's, rounded to sub-units, from the voxel's corner. */
typedef struct payload_pair {
    uint32_t indices[3];
    int64_t corners[3][3];
    oracle_box box; /* in grid units */
} payload_pair;

/* The edge of a voxel in sub-units. */
#define PAYLOAD_WIDTH (INT64_C(1) << 24)

void payload_pair_open(const exact *expected, const oracle_pair *pair, payload_pair *out);

/* The axis along which the triangle's projection is largest; the first of equal ones. */
unsigned payload_pair_axis(const int64_t corners[3][3]);

/* The triangle's material, or NULL for white; its texture, or NULL for none. */
const svo_material *payload_material(const svo_mesh *mesh, uint32_t triangle);
const svo_texture *payload_texture(const svo_mesh *mesh, uint32_t triangle);

/* A channel of the texel at any coordinates, by the texture's wrap mode. */
int64_t payload_texel(const svo_texture *texture, int64_t x, int64_t y, unsigned channel);

/* payload_doubles.c: the area of the triangle inside the voxel, in faces, and the centroid of that part in sub-units.
   Without area, the centroid is the voxel's center. */
double payload_double_part(const payload_pair *pair, double centroid[3]);

/* The triangle's normal: the cross product of the edges from its first corner. Where a component of these has more than
   30 bits, they are halved, rounded down, as often as it takes. Corners may be from any point. */
void payload_pair_normal(const int64_t corners[3][3], int64_t normal[3]);

/* Halvings of numbers, each rounded down, until none of them has more than so many bits. */
unsigned payload_halve(int64_t *numbers, unsigned count, unsigned bits);

/* Whether some edge of the accepted triangles is used more often in one direction than in the other, where vertices of
   the same position are one. */
bool payload_mesh_is_open(const exact *expected);

/* value modulo period, never negative. */
int64_t payload_remainder(int64_t value, int64_t period);

#endif
