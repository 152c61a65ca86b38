/* SPDX-License-Identifier: MIT */
/*
 * Shapes in integers. A voxel's center is an odd multiple of half a voxel, so in units of 1/256 every number here is
 * whole: coordinates are below 2^30, squares of distances below 2^62. The projection on a capsule's line is compared
 * without a division, by products of 128 bits.
 */
#include "edit/shape.h"

#include <math.h>

#include "edit/store.h"

#define UNIT_LOG2   8
#define VOXEL_UNITS (1 << UNIT_LOG2)
#define NORMAL_ONE  32767.0

/* ---- reading ---- */

static int64_t rounded(double voxels)
{
    return (int64_t)floor(voxels * VOXEL_UNITS + 0.5);
}

static svo_status check_place(const char *function, const char *name, const double place[3], double radius,
                              const svo_edit_info *info, svo_message *message)
{
    for (int axis = 0; axis < 3; ++axis) {
        if (!(place[axis] - radius >= (double)info->low[axis] && place[axis] + radius <= (double)info->high[axis])) {
            return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s.%c %g with radius %g is not within %d .. %d",
                              function, name, "xyz"[axis], place[axis], radius, info -> low[axis], info -> high[axis]);
        }
    }
    return SVO_OK;
}

svo_status svo_i_edit_solid_read(const char *function, const svo_edit_step *step, const svo_edit_info *info,
                                 const int64_t corner[3], svo_i_edit_solid *out, svo_message *message)
{
    const bool has_radius = step->shape != SVO_EDIT_BOX;
    const bool has_to = step->shape != SVO_EDIT_SPHERE;
    const double radius = has_radius ? step->radius : 0.0;
    if (!(radius >= 0.0)) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: step.radius %g is not at least 0", function, radius);
    }
    SVO_I_TRY(check_place(function, "step.begin", step->begin, radius, info, message));
    if (has_to) {
        SVO_I_TRY(check_place(function, "step.end", step->end, radius, info, message));
    }
    *out = (svo_i_edit_solid){.kind = (svo_edit_shape)step->shape, .radius = rounded(radius)};
    for (int axis = 0; axis < 3; ++axis) {
        out->begin[axis] = rounded(step->begin[axis] - (double)corner[axis]);
        out->end[axis] = has_to ? rounded(step->end[axis] - (double)corner[axis]) : out->begin[axis];
        const bool ascends = out->begin[axis] <= out->end[axis];
        out->low[axis] = (ascends ? out->begin[axis] : out->end[axis]) - out->radius;
        out->high[axis] = (ascends ? out->end[axis] : out->begin[axis]) + out->radius;
    }
    return SVO_OK;
}

/* ---- distances ---- */

static int64_t dot(const int64_t a[3], const int64_t b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* a * b <= c * c, for numbers from 0 to below 2^63. */
static bool product_is_at_most_square(uint64_t a, uint64_t b, uint64_t c)
{
    const uint64_t low_half = UINT32_MAX;
    const uint64_t factors[2][2] = {{a, b}, {c, c}};
    uint64_t high[2];
    uint64_t low[2];
    for (int i = 0; i < 2; ++i) {
        const uint64_t x = factors[i][0];
        const uint64_t y = factors[i][1];
        const uint64_t cross = (x >> 32) * (y & low_half) + ((x & low_half) * (y & low_half) >> 32);
        const uint64_t middle = (x & low_half) * (y >> 32) + (cross & low_half);
        high[i] = (x >> 32) * (y >> 32) + (cross >> 32) + (middle >> 32);
        low[i] = x * y;
    }
    return high[0] < high[1] || (high[0] == high[1] && low[0] <= low[1]);
}

/* Whether a point is at most radius from the line between the ends, which may be one. */
static bool is_near(const svo_i_edit_solid *solid, const int64_t point[3], int64_t radius)
{
    int64_t along[3];
    int64_t from[3];
    int64_t to[3];
    for (int axis = 0; axis < 3; ++axis) {
        along[axis] = solid->end[axis] - solid->begin[axis];
        from[axis] = point[axis] - solid->begin[axis];
        to[axis] = point[axis] - solid->end[axis];
    }
    const int64_t reach = radius * radius;
    const int64_t distance = dot(from, from);
    const int64_t place = dot(from, along);
    const int64_t length = dot(along, along);
    if (distance <= reach) {
        return true;
    }
    if (place <= 0) {
        return false;
    }
    return place >= length ? dot(to, to) <= reach
                           : product_is_at_most_square((uint64_t)(distance - reach), (uint64_t)length, (uint64_t)place);
}

/* ---- cubes ---- */

/* The centers of a cube's least and greatest voxel. */
static void centers_of(const uint32_t cell[3], uint32_t level, int64_t low[3], int64_t high[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] = (int64_t)cell[axis] * VOXEL_UNITS + VOXEL_UNITS / 2;
        high[axis] = low[axis] + (((int64_t)1 << level) - 1) * VOXEL_UNITS;
    }
}

static svo_i_edit_side side_of_box(const svo_i_edit_solid *solid, const int64_t low[3], const int64_t high[3])
{
    bool inside = true;
    for (int axis = 0; axis < 3; ++axis) {
        if (high[axis] < solid->begin[axis] || low[axis] >= solid->end[axis]) {
            return SVO_I_EDIT_OUTSIDE;
        }
        inside = inside && low[axis] >= solid->begin[axis] && high[axis] < solid->end[axis];
    }
    return inside ? SVO_I_EDIT_INSIDE : SVO_I_EDIT_CROSSING;
}

static svo_i_edit_side side_of_sphere(const svo_i_edit_solid *solid, const int64_t low[3], const int64_t high[3])
{
    int64_t nearest[3];
    int64_t farthest[3];
    for (int axis = 0; axis < 3; ++axis) {
        const int64_t below = solid->begin[axis] - low[axis];
        const int64_t above = high[axis] - solid->begin[axis];
        nearest[axis] = below < 0 ? -below : above < 0 ? -above : 0;
        farthest[axis] = below > above ? below : above;
    }
    const int64_t reach = solid->radius * solid->radius;
    return dot(farthest, farthest) <= reach ? SVO_I_EDIT_INSIDE
           : dot(nearest, nearest) <= reach ? SVO_I_EDIT_CROSSING
                                            : SVO_I_EDIT_OUTSIDE;
}

/* A capsule is convex: a cube whose corners are inside is. One whose center is farther than the radius and half the
   cube's diagonal, which is below 1774 / 1024 of half its edge, is outside. */
static svo_i_edit_side side_of_capsule(const svo_i_edit_solid *solid, const int64_t low[3], const int64_t high[3])
{
    const int64_t half = (high[0] - low[0]) / 2;
    const int64_t middle[3] = {low[0] + half, low[1] + half, low[2] + half};
    if (!is_near(solid, middle, solid->radius + half * 1774 / 1024 + 1)) {
        return SVO_I_EDIT_OUTSIDE;
    }
    for (int corner = 0; corner < 8; ++corner) {
        const int64_t point[3] = {(corner & 1) != 0 ? high[0] : low[0], (corner & 2) != 0 ? high[1] : low[1],
                                  (corner & 4) != 0 ? high[2] : low[2]};
        if (!is_near(solid, point, solid->radius)) {
            return SVO_I_EDIT_CROSSING;
        }
    }
    return SVO_I_EDIT_INSIDE;
}

/* low, high: the centers of a cube's least and greatest voxel. */
static svo_i_edit_side side_of(const svo_i_edit_solid *solid, const int64_t low[3], const int64_t high[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        if (high[axis] < solid->low[axis] || low[axis] > solid->high[axis]) {
            return SVO_I_EDIT_OUTSIDE;
        }
    }
    switch (solid->kind) {
    case SVO_EDIT_BOX:
        return side_of_box(solid, low, high);
    case SVO_EDIT_SPHERE:
        return side_of_sphere(solid, low, high);
    default:
        return side_of_capsule(solid, low, high);
    }
}

svo_i_edit_side svo_i_edit_solid_side(const svo_i_edit_solid *solid, const uint32_t cell[3], uint32_t level,
                                      uint32_t margin)
{
    int64_t low[3];
    int64_t high[3];
    centers_of(cell, level, low, high);
    const svo_i_edit_side side = side_of(solid, low, high);
    if (side != SVO_I_EDIT_INSIDE || margin == 0) {
        return side;
    }
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] -= (int64_t)margin * VOXEL_UNITS;
        high[axis] += (int64_t)margin * VOXEL_UNITS;
    }
    return side_of(solid, low, high) == SVO_I_EDIT_INSIDE ? SVO_I_EDIT_INSIDE : SVO_I_EDIT_CROSSING;
}

/* Where a voxel's coordinates along an axis are in a Morton code. */
static uint32_t code_of(uint32_t x, uint32_t y, uint32_t z)
{
    static const uint32_t spread[4] = {0, 1, 8, 9};
    return spread[x] | spread[y] << 1 | spread[z] << 2;
}

/* Of a sphere: the sums of three squares each. */
static uint64_t mask_of_sphere(const svo_i_edit_solid *solid, const int64_t low[3])
{
    int64_t squares[3][4];
    uint64_t mask = 0;
    for (int axis = 0; axis < 3; ++axis) {
        for (int i = 0; i < 4; ++i) {
            const int64_t away = low[axis] + (int64_t)i * VOXEL_UNITS - solid->begin[axis];
            squares[axis][i] = away * away;
        }
    }
    for (uint32_t i = 0; i < 64; ++i) {
        const int64_t sum = squares[0][i & 3u] + squares[1][i >> 2 & 3u] + squares[2][i >> 4];
        mask |= (uint64_t)(sum <= solid->radius * solid->radius) << code_of(i & 3u, i >> 2 & 3u, i >> 4);
    }
    return mask;
}

static bool is_inside(const svo_i_edit_solid *solid, const int64_t point[3])
{
    bool in_box = true;
    for (int axis = 0; axis < 3 && solid->kind == SVO_EDIT_BOX; ++axis) {
        in_box = in_box && point[axis] >= solid->begin[axis] && point[axis] < solid->end[axis];
    }
    return solid->kind == SVO_EDIT_BOX ? in_box : is_near(solid, point, solid->radius);
}

uint64_t svo_i_edit_solid_mask(const svo_i_edit_solid *solid, const uint32_t cell[3])
{
    int64_t low[3];
    int64_t high[3];
    uint64_t mask = 0;
    centers_of(cell, 0, low, high);
    if (solid->kind == SVO_EDIT_SPHERE) {
        return mask_of_sphere(solid, low);
    }
    for (uint32_t i = 0; i < 64; ++i) {
        const uint32_t inner[3] = {i & 3u, i >> 2 & 3u, i >> 4};
        const int64_t point[3] = {low[0] + (int64_t)inner[0] * VOXEL_UNITS, low[1] + (int64_t)inner[1] * VOXEL_UNITS,
                                  low[2] + (int64_t)inner[2] * VOXEL_UNITS};
        mask |= (uint64_t)(is_inside(solid, point) ? 1u : 0u) << code_of(inner[0], inner[1], inner[2]);
    }
    return mask;
}

/*
 * ---- normals ----
 *
 * A voxel at the surface of a sphere or a capsule has the direction from the center or from the nearest point of the
 * line to its own center. One of a box has the sum of the normals of the faces that it is at. Lengths are square roots
 * of whole numbers, so that every host has the same.
 */

/* The point's direction from the nearest point of the line between the ends. */
static void direction_of(const svo_i_edit_solid *solid, const int64_t point[3], int64_t out[3])
{
    int64_t along[3];
    int64_t from[3];
    for (int axis = 0; axis < 3; ++axis) {
        along[axis] = solid->end[axis] - solid->begin[axis];
        from[axis] = point[axis] - solid->begin[axis];
    }
    const int64_t place = dot(from, along);
    const int64_t length = dot(along, along);
    const double share = place <= 0 ? 0.0 : place >= length ? 1.0 : (double)place / (double)length;
    for (int axis = 0; axis < 3; ++axis) {
        const double nearest = share * (double)along[axis];
        out[axis] = from[axis] - (int64_t)rint(nearest);
    }
}

static void face_directions(const svo_i_edit_solid *solid, const int64_t point[3], int64_t out[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        const bool is_lowest = point[axis] - VOXEL_UNITS < solid->begin[axis];
        const bool is_highest = point[axis] + VOXEL_UNITS >= solid->end[axis];
        out[axis] = (is_highest ? 1 : 0) - (is_lowest ? 1 : 0);
    }
}

/* Whether a neighbor of a point inside is outside. */
static bool is_at_surface(const svo_i_edit_solid *solid, const int64_t point[3])
{
    if (solid->kind != SVO_EDIT_BOX && solid->radius >= VOXEL_UNITS &&
        is_near(solid, point, solid->radius - VOXEL_UNITS)) {
        return false;
    }
    for (int side = 0; side < 6; ++side) {
        int64_t neighbor[3] = {point[0], point[1], point[2]};
        neighbor[side / 2] += side % 2 == 0 ? -VOXEL_UNITS : VOXEL_UNITS;
        if (!is_inside(solid, neighbor)) {
            return true;
        }
    }
    return false;
}

static uint64_t normal_at(const svo_i_edit_solid *solid, const int64_t point[3])
{
    int64_t direction[3];
    int16_t normal[3] = {0, 0, 0};
    if (solid->kind == SVO_EDIT_BOX) {
        face_directions(solid, point, direction);
    } else {
        direction_of(solid, point, direction);
    }
    const double length = sqrt((double)dot(direction, direction));
    for (int axis = 0; axis < 3 && length > 0.0; ++axis) {
        normal[axis] = (int16_t)rint((double)direction[axis] / length * NORMAL_ONE);
    }
    return svo_i_edit_pack_normal(normal);
}

void svo_i_edit_solid_normals(const svo_i_edit_solid *solid, const uint32_t cell[3], uint64_t mask,
                              uint64_t normals[64])
{
    int64_t low[3];
    int64_t high[3];
    centers_of(cell, 0, low, high);
    for (uint32_t i = 0; i < 64; ++i) {
        const uint32_t code = code_of(i & 3u, i >> 2 & 3u, i >> 4);
        const int64_t point[3] = {low[0] + (int64_t)(i & 3u) * VOXEL_UNITS,
                                  low[1] + (int64_t)(i >> 2 & 3u) * VOXEL_UNITS,
                                  low[2] + (int64_t)(i >> 4) * VOXEL_UNITS};
        if ((mask >> code & 1u) != 0) {
            normals[code] = is_at_surface(solid, point) ? normal_at(solid, point) : 0;
        }
    }
}
