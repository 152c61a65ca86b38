/* SPDX-License-Identifier: MIT */
/*
 * Polygons to triangles. The choices (which corner a fan begins at, which ear comes first) and their arithmetic in
 * single precision are those of assimp's aiProcess_Triangulate, so that a mesh has the same triangles whichever of the
 * two read it.
 */
#include "io/import_polygon.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/message.h"

#define PI_FLOAT 3.14159265358979323846f

bool svo_i_polygon_reserve(polygon *shape, size_t corner_count)
{
    if (corner_count <= shape->corner_capacity) {
        return true;
    }
    size_t bytes = 0;
    const size_t capacity = corner_count < SIZE_MAX / 2 ? 2 * corner_count : corner_count;
    if (!svo_i_mul_size(capacity, 3 * sizeof(float), &bytes)) {
        return false;
    }
    svo_i_polygon_free(shape);
    shape->corners = malloc(bytes);
    shape->triangles = malloc(bytes);
    shape->flat = malloc(capacity * sizeof *shape->flat);
    shape->before = malloc(capacity * sizeof *shape->before);
    shape->after = malloc(capacity * sizeof *shape->after);
    shape->ears = malloc(capacity);
    if (shape->corners == NULL || shape->triangles == NULL || shape->flat == NULL || shape->before == NULL ||
        shape->after == NULL || shape->ears == NULL) {
        svo_i_polygon_free(shape);
        return false;
    }
    shape->corner_capacity = capacity;
    return true;
}

void svo_i_polygon_free(polygon *shape)
{
    free(shape->corners);
    free(shape->triangles);
    free(shape->flat);
    free(shape->before);
    free(shape->after);
    free(shape->ears);
    *shape = (polygon){.crossed_count = shape->crossed_count};
}

/* Four corners */

/* A vector of length 1 in the direction of to - from, or that difference where it has no length. */
static void direction(const float from[3], const float to[3], float out[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        out[axis] = to[axis] - from[axis];
    }
    const float length = sqrtf(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
    if (length == 0) {
        return;
    }
    const float inverse = 1.0f / length;
    for (int axis = 0; axis < 3; ++axis) {
        out[axis] *= inverse;
    }
}

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The corner whose angle, measured to the diagonal on both sides, is above 180 degrees; else 0. */
static uint32_t inward_corner(float (*corners)[3])
{
    float edges[4][3], diagonals[2][3], sides[2][3], across[3];
    for (uint32_t i = 0; i < 4; ++i) {
        direction(corners[i], corners[(i + 1) % 4], edges[i]);
    }
    direction(corners[0], corners[2], diagonals[0]);
    direction(corners[1], corners[3], diagonals[1]);
    for (uint32_t i = 0; i < 4; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            sides[0][axis] = -edges[(i + 3) % 4][axis];
            sides[1][axis] = edges[i][axis];
            across[axis] = i < 2 ? diagonals[i % 2][axis] : -diagonals[i % 2][axis];
        }
        const float left = dot(sides[0], across), right = dot(sides[1], across);
        /* Two angles within [0, 180] degrees have a sum above 180 where their cosines have one below 0. The slow
           functions decide only where rounding might. */
        if (left + right < 1e-3f && acosf(left) + acosf(right) > PI_FLOAT) {
            return i;
        }
    }
    return 0;
}

static void cut_four(polygon *shape)
{
    const uint32_t first = inward_corner(shape->corners);
    const uint32_t cut[6] = {first, (first + 1) % 4, (first + 2) % 4, first, (first + 2) % 4, (first + 3) % 4};
    memcpy(shape->triangles, cut, sizeof cut);
}

/* More corners */

/* The plane that the polygon covers most of, its axes ordered so that corners run counterclockwise. Newell's normal. */
static void project(polygon *shape, uint32_t corner_count)
{
    float(*const corners)[3] = shape->corners;
    float normal[3] = {0, 0, 0};
    for (uint32_t i = 0; i < corner_count; ++i) {
        const float *low = corners[i], *at = corners[(i + 1) % corner_count], *high = corners[(i + 2) % corner_count];
        normal[0] += at[1] * (high[2] - low[2]);
        normal[1] += at[2] * (high[0] - low[0]);
        normal[2] += at[0] * (high[1] - low[1]);
    }
    const float x = fabsf(normal[0]), y = fabsf(normal[1]), z = fabsf(normal[2]);
    int left_out = 2;
    if (x > y) {
        left_out = x > z ? 0 : 2;
    } else if (y > z) {
        left_out = 1;
    }
    const bool swapped = normal[left_out] < 0;
    const int first = (left_out + (swapped ? 2 : 1)) % 3, second = (left_out + (swapped ? 1 : 2)) % 3;
    for (uint32_t i = 0; i < corner_count; ++i) {
        shape->flat[i][0] = corners[i][first];
        shape->flat[i][1] = corners[i][second];
    }
}

/* Half the cross product, positive where the three turn clockwise. */
static double clockwise_area(const float a[2], const float b[2], const float c[2])
{
    return 0.5 * (a[0] * ((double)c[1] - b[1]) + b[0] * ((double)a[1] - c[1]) + c[0] * ((double)b[1] - a[1]));
}

static bool is_inside(const float a[2], const float b[2], const float c[2], const float point[2])
{
    const float u[2] = {b[0] - a[0], b[1] - a[1]}, v[2] = {c[0] - a[0], c[1] - a[1]};
    const float w[2] = {point[0] - a[0], point[1] - a[1]};
    const double uu = u[0] * u[0] + u[1] * u[1], vv = v[0] * v[0] + v[1] * v[1], uv = u[0] * v[0] + u[1] * v[1];
    const double uw = u[0] * w[0] + u[1] * w[1], vw = v[0] * w[0] + v[1] * w[1];
    const double determinant = uu * vv - uv * uv;
    if (determinant == 0) {
        return false;
    }
    const double inverse = 1.0 / determinant;
    const double s = (vv * uw - uv * vw) * inverse, t = (uu * vw - uv * uw) * inverse;
    return s > 0 && t > 0 && s + t < 1;
}

static bool is_same(const float a[2], const float b[2])
{
    return a[0] == b[0] && a[1] == b[1];
}

/* Whether the triangle of a corner and its neighbors lies inside the polygon. Corners that were cut off count too, so
   the answer changes with the neighbors alone. */
static bool test_ear(const polygon *shape, uint32_t corner_count, uint32_t ear)
{
    const float *before = shape->flat[shape->before[ear]], *at = shape->flat[ear],
                *after = shape->flat[shape->after[ear]];
    if (clockwise_area(before, at, after) > 0) {
        return false;
    }
    for (uint32_t i = 0; i < corner_count; ++i) {
        const float *other = shape->flat[i];
        if (is_inside(before, at, after, other) && !is_same(other, at) && !is_same(other, after) &&
            !is_same(other, before)) {
            return false;
        }
    }
    return true;
}

enum { EAR_UNKNOWN = 0, EAR_YES, EAR_NO };

static bool is_ear(const polygon *shape, uint32_t corner_count, uint32_t corner)
{
    if (shape->ears[corner] == EAR_UNKNOWN) {
        shape->ears[corner] = test_ear(shape, corner_count, corner) ? EAR_YES : EAR_NO;
    }
    return shape->ears[corner] == EAR_YES;
}

static uint32_t *take_ear(polygon *shape, uint32_t ear, uint32_t *out)
{
    const uint32_t before = shape->before[ear], after = shape->after[ear];
    out[0] = before;
    out[1] = ear;
    out[2] = after;
    shape->after[before] = after;
    shape->before[after] = before;
    shape->ears[before] = EAR_UNKNOWN;
    shape->ears[after] = EAR_UNKNOWN;
    return out + 3;
}

/* The first ear at or after a corner; without one, after two rounds, the corner itself. */
static uint32_t find_ear(polygon *shape, uint32_t corner_count, uint32_t from, bool *found)
{
    unsigned rounds = 0;
    for (uint32_t ear = from;; ear = shape->after[ear]) {
        rounds += shape->after[ear] < ear ? 1 : 0;
        *found = rounds < 2;
        if (!*found) {
            return from;
        }
        if (is_ear(shape, corner_count, ear)) {
            return ear;
        }
    }
}

/* The last three corners of the ring, in ascending order. */
static void take_rest(const polygon *shape, uint32_t any, uint32_t *out)
{
    uint32_t first = any;
    for (int i = 0; i < 3; ++i) {
        any = shape->after[any];
        first = any < first ? any : first;
    }
    out[0] = first;
    out[1] = shape->after[first];
    out[2] = shape->after[out[1]];
}

static void cut_ears(polygon *shape, uint32_t corner_count)
{
    for (uint32_t i = 0; i < corner_count; ++i) {
        shape->before[i] = (i + corner_count - 1) % corner_count;
        shape->after[i] = (i + 1) % corner_count;
        shape->ears[i] = EAR_UNKNOWN;
    }
    uint32_t *out = shape->triangles;
    uint32_t next = 0;
    bool found = true;
    for (uint32_t left_count = corner_count; left_count > 3; --left_count) {
        /* A polygon that crosses itself may have no ear. Its corners are then taken in their order. */
        const uint32_t ear = found ? find_ear(shape, corner_count, next, &found) : next;
        next = shape->after[ear];
        out = take_ear(shape, ear, out);
    }
    shape->crossed_count += found ? 0 : 1;
    take_rest(shape, next, out);
}

void svo_i_polygon_cut(polygon *shape, uint32_t corner_count)
{
    if (corner_count == 3) {
        memcpy(shape->triangles, (const uint32_t[]){0, 1, 2}, 3 * sizeof *shape->triangles);
    } else if (corner_count == 4) {
        cut_four(shape);
    } else {
        project(shape, corner_count);
        cut_ears(shape, corner_count);
    }
}
