/* SPDX-License-Identifier: MIT */
/* Lookups that both payload references (payload_reference.c in integers, payload_doubles.c) use. */
#ifndef SVOCL_TESTS_PAYLOAD_PAIR_H
#define SVOCL_TESTS_PAYLOAD_PAIR_H

#include "compare_tree.h"

/* A pair's triangle and voxel. */
typedef struct payload_pair {
    uint32_t indices[3];
    const int32_t *corners[3];
    oracle_box box;
} payload_pair;

void payload_pair_open(const exact *expected, const oracle_pair *pair, payload_pair *out);

/* Twice the signed area of the triangle (point, p, q) seen along axis. */
int64_t payload_area_seen(const int64_t point[3], const int32_t p[3], const int32_t q[3], unsigned axis);

/* The axis along which the triangle's projection is largest; the first of equal ones. */
unsigned payload_pair_axis(const int32_t *const corners[3]);

/* The triangle's material, or NULL for white; its texture, or NULL for none. */
const svo_material *payload_material(const svo_mesh *mesh, uint32_t triangle);
const svo_texture *payload_texture(const svo_mesh *mesh, uint32_t triangle);

/* A channel of the texel at any coordinates, by the texture's wrap mode. */
int64_t payload_texel(const svo_texture *texture, int64_t x, int64_t y, unsigned channel);

/* payload_doubles.c: the area of the triangle inside the box, in faces of the box, and the centroid of that part, in
   grid units from the box's corner. Without area, the centroid is the box's center. */
double payload_double_part(const payload_pair *pair, double centroid[3]);

/* The triangle's normal: the cross product of two edges. */
void payload_pair_normal(const int32_t *const corners[3], int64_t normal[3]);

/* Whether some edge of the accepted triangles is used more often in one direction than in the other, where vertices of
   the same position are one. */
bool payload_mesh_is_open(const exact *expected);

/* value modulo period, never negative. */
int64_t payload_remainder(int64_t value, int64_t period);

#endif
