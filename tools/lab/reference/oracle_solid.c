/* SPDX-License-Identifier: MIT */
/*
 * Columns of voxels, one row of them at a time. Each triangle adds its sign to the number of voxel centers below the
 * point where it meets a column's center line; summed up from the far end, that is the winding number of each center.
 *
 * A center line that passes through the projection of an edge or a corner is moved: by epsilon along the first axis of
 * the projection and by -epsilon^2 along the second (Edelsbrunner and Muecke, "Simulation of Simplicity", 1990). Then
 * it meets the inside of one triangle or none. The top-left rule is the same choice.
 */
#include "oracle_solid.h"

#include <stdlib.h>
#include <string.h>

__extension__ typedef __int128 wide;

typedef struct point {
    int64_t u, v, height;
} point;

typedef struct sweep {
    const oracle_mesh *mesh;
    unsigned depth, snap_bits, axis;
    oracle_rule rule;
    uint32_t edge; /* voxels per axis */
    int32_t *crossings; /* [u][number of centers below: 0 .. edge] */
    oracle_solid *out;
} sweep;

static point corner_of(const oracle_mesh *mesh, unsigned axis, size_t triangle, size_t corner)
{
    size_t at = 3 * triangle + corner;
    const int32_t *vertex = mesh->vertices + 3 * (mesh->indices ? mesh->indices[at] : at);

    return (point){vertex[(axis + 1) % 3], vertex[(axis + 2) % 3], vertex[axis]};
}

/* The sign of the area of the triangle a, b, (u, v) with the third corner moved; 0 only where a and b coincide. */
static int side_of(point a, point b, int64_t u, int64_t v)
{
    wide area = (wide)(b.u - a.u) * (v - a.v) - (wide)(b.v - a.v) * (u - a.u);

    if (area != 0)
        return area > 0 ? 1 : -1;
    if (b.v != a.v)
        return b.v < a.v ? 1 : -1;
    return b.u == a.u ? 0 : b.u < a.u ? 1 : -1;
}

/* 1 or -1 if the moved line passes through the triangle, counter-clockwise or not; else 0. */
static int sense_of(const point *corners, int64_t u, int64_t v)
{
    int first = side_of(corners[0], corners[1], u, v);

    if (first == 0 || side_of(corners[1], corners[2], u, v) != first || side_of(corners[2], corners[0], u, v) != first)
        return 0;
    return first;
}

/* numerator / denominator rounded up; denominator above 0. */
static wide divide_up(wide numerator, wide denominator)
{
    wide quotient = numerator / denominator;

    return quotient + (numerator % denominator > 0);
}

/* The height where the line meets the triangle's plane is *height / the area returned, which is above 0. */
static wide height_of(const point *corners, int64_t u, int64_t v, wide *height)
{
    const point *a = &corners[0], *b = &corners[1], *c = &corners[2];
    wide area = (wide)(b->u - a->u) * (c->v - a->v) - (wide)(b->v - a->v) * (c->u - a->u);
    /* The slopes of the plane along u and v, times the area. */
    wide slope_u = (wide)(b->height - a->height) * (c->v - a->v) - (wide)(c->height - a->height) * (b->v - a->v);
    wide slope_v = (wide)(c->height - a->height) * (b->u - a->u) - (wide)(b->height - a->height) * (c->u - a->u);

    *height = area * a->height + slope_u * (u - a->u) + slope_v * (v - a->v);
    if (area < 0) {
        area = -area;
        *height = -*height;
    }
    return area;
}

/* Voxel centers of the column below that height. */
static uint32_t centers_below(const sweep *s, const point *corners, int64_t u, int64_t v)
{
    wide height, area = height_of(corners, u, v, &height);
    /* Center k is at 2 k + 1 half voxels, below the height if at most the height rounded up, less one. */
    wide steps = divide_up(height, area << (s->snap_bits - s->depth - 1));

    if (steps <= 0)
        return 0;
    return steps / 2 >= s->edge ? s->edge : (uint32_t)(steps / 2);
}

static int64_t center_of(const sweep *s, uint32_t voxel)
{
    return (int64_t)(2 * (uint64_t)voxel + 1) << (s->snap_bits - s->depth - 1);
}

static void add_triangle(const sweep *s, size_t triangle, uint32_t row)
{
    point corners[3] = {corner_of(s->mesh, s->axis, triangle, 0), corner_of(s->mesh, s->axis, triangle, 1),
                        corner_of(s->mesh, s->axis, triangle, 2)};
    int64_t v = center_of(s, row), low = corners[0].u, high = low;
    bool above = false, below = false;

    for (int i = 0; i < 3; i++) {
        above = above || corners[i].v >= v;
        below = below || corners[i].v <= v;
        low = corners[i].u < low ? corners[i].u : low;
        high = corners[i].u > high ? corners[i].u : high;
    }
    for (uint32_t column = 0; above && below && column < s->edge; column++) {
        int64_t u = center_of(s, column);
        int sense = u < low || u > high ? 0 : sense_of(corners, u, v);

        if (sense != 0)
            s->crossings[(size_t)column * (s->edge + 1) + centers_below(s, corners, u, v)] += sense;
    }
}

static void set_inside(const sweep *s, uint32_t column, uint32_t row, uint32_t height)
{
    uint64_t at[3], index;

    at[s->axis] = height;
    at[(s->axis + 1) % 3] = column;
    at[(s->axis + 2) % 3] = row;
    index = at[0] + ((at[1] + (at[2] << s->depth)) << s->depth);
    s->out->inside[s->axis][index / 64] |= (uint64_t)1 << index % 64;
}

static void sum_row(const sweep *s, uint32_t row)
{
    for (uint32_t column = 0; column < s->edge; column++) {
        const int32_t *crossings = s->crossings + (size_t)column * (s->edge + 1);
        int64_t sum = 0;

        for (uint32_t height = s->edge; height > 0; height--) {
            sum += crossings[height];
            if (s->rule == ORACLE_PARITY ? sum % 2 != 0 : sum != 0)
                set_inside(s, column, row, height - 1);
        }
        if (sum + crossings[0] != 0)
            s->out->open_columns[s->axis]++;
    }
}

static void sweep_axis(sweep *s, unsigned axis)
{
    size_t count = (size_t)s->edge * (s->edge + 1);

    s->axis = axis;
    for (uint32_t row = 0; row < s->edge; row++) {
        memset(s->crossings, 0, count * sizeof *s->crossings);
        for (size_t t = 0; t < s->mesh->triangle_count; t++)
            add_triangle(s, t, row);
        sum_row(s, row);
    }
}

bool oracle_solid_make(const oracle_mesh *mesh, const oracle_request *request, oracle_rule rule, oracle_solid *out)
{
    sweep s = {.mesh = mesh, .depth = request->depth, .snap_bits = request->snap_bits, .rule = rule, .out = out};
    bool good =
        request->depth >= 1 && request->depth <= 10 && request->snap_bits > request->depth && request->snap_bits <= 24;

    *out = (oracle_solid){.depth = request->depth};
    if (!good)
        return false;
    s.edge = UINT32_C(1) << request->depth;
    s.crossings = malloc((size_t)s.edge * (s.edge + 1) * sizeof *s.crossings);
    good = s.crossings != NULL;
    for (unsigned axis = 0; axis < 3; axis++) {
        out->inside[axis] = calloc((((size_t)1 << 3 * request->depth) + 63) / 64, sizeof(uint64_t));
        good = good && out->inside[axis] != NULL;
    }
    for (unsigned axis = 0; good && axis < 3; axis++)
        sweep_axis(&s, axis);
    free(s.crossings);
    if (!good)
        oracle_solid_free(out);
    return good;
}

void oracle_solid_free(oracle_solid *solid)
{
    for (unsigned axis = 0; axis < 3; axis++)
        free(solid->inside[axis]);
    *solid = (oracle_solid){.depth = 0};
}

unsigned oracle_solid_votes(const oracle_solid *solid, uint32_t x, uint32_t y, uint32_t z)
{
    uint64_t index = x + ((y + ((uint64_t)z << solid->depth)) << solid->depth);
    unsigned votes = 0;

    for (unsigned axis = 0; axis < 3; axis++)
        votes += solid->inside[axis][index / 64] >> index % 64 & 1;
    return votes;
}

int64_t oracle_point_winding(const oracle_mesh *mesh, unsigned axis, const int64_t at[3])
{
    int64_t u = at[(axis + 1) % 3], v = at[(axis + 2) % 3], sum = 0;

    for (size_t t = 0; t < mesh->triangle_count; t++) {
        point corners[3] = {corner_of(mesh, axis, t, 0), corner_of(mesh, axis, t, 1), corner_of(mesh, axis, t, 2)};
        int sense = sense_of(corners, u, v);
        wide height, area;

        if (sense == 0)
            continue;
        area = height_of(corners, u, v, &height);
        sum += height > area * at[axis] ? sense : 0;
    }
    return sum;
}
