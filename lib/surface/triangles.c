/* SPDX-License-Identifier: MIT */
/*
 * The third step to a surface: two triangles around each edge between two centers that it crosses, brick by brick, by
 * the cube whose lowest corner the edge begins at.
 */
#include "surface/triangles.h"

#include "shared/nodes.clh"

/* Cubes of a brick and those before it: x + 9 (y + 9 z), from -1 on. */
typedef struct neighborhood {
    int32_t low[3]; /* the brick's first cube in the field */
    uint32_t cubes[SVO_I_SURFACE_SITES]; /* 1 + index into work->cubes; 0: the surface does not pass */
} neighborhood;

/* ---- neighbors ---- */

/* Index of the brick with that code; brick_count: there is none. */
static size_t find_brick(const svo_i_surface_work *work, uint64_t code)
{
    size_t low = 0;
    size_t high = work->brick_count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (work->bricks[middle].code < code) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low < work->brick_count && work->bricks[low].code == code ? low : work->brick_count;
}

/* Puts the cubes of a brick in their places; before: the axes on which it is the one before: bits. */
static void put_cubes(const svo_i_surface_work *work, size_t brick, unsigned before, neighborhood *near)
{
    for (size_t i = work->bricks[brick].begin; i < work->bricks[brick + 1].begin; ++i) {
        const unsigned place = work->cubes[i].place;
        const unsigned at[3] = {place % SVO_I_SURFACE_BRICK, place / SVO_I_SURFACE_BRICK % SVO_I_SURFACE_BRICK,
                                place / SVO_I_SURFACE_BRICK / SVO_I_SURFACE_BRICK};
        size_t site = 0;
        bool is_near = true;
        for (unsigned axis = 3; axis-- > 0;) {
            const bool is_before = (before >> axis & 1u) != 0;
            is_near = is_near && (!is_before || at[axis] == SVO_I_SURFACE_BRICK - 1);
            site = site * SVO_I_SURFACE_SIDE + (is_before ? 0 : at[axis] + 1);
        }
        if (is_near) {
            near->cubes[site] = (uint32_t)i + 1;
        }
    }
}

static void look_around(const svo_i_surface_work *work, size_t brick, neighborhood *near)
{
    uint32_t at[3];
    svo_deinterleave(work->bricks[brick].code, at);
    for (size_t site = 0; site < SVO_I_SURFACE_SITES; ++site) {
        near->cubes[site] = 0;
    }
    for (int axis = 0; axis < 3; ++axis) {
        near->low[axis] = ((int32_t)at[axis] - 1) * SVO_I_SURFACE_BRICK;
    }
    for (unsigned before = 0; before < 8; ++before) {
        uint32_t other[3];
        bool is_there = true;
        for (unsigned axis = 0; axis < 3; ++axis) {
            is_there = is_there && ((before >> axis & 1u) == 0 || at[axis] > 0);
            other[axis] = at[axis] - (before >> axis & 1u);
        }
        const size_t found = is_there ? find_brick(work, svo_interleave(other)) : work->brick_count;
        if (found < work->brick_count) {
            put_cubes(work, found, before, near);
        }
    }
}

/* ---- triangles ---- */

/* The vertex of the piece that crosses an edge. */
static uint32_t vertex_at(const svo_i_surface_work *work, const svo_i_surface_cube *cube, unsigned edge)
{
    const svo_i_surface_case *made =
        cube->is_joined != 0 ? &work->cases.joined[cube->inside] : &work->cases.apart[cube->inside];
    uint32_t vertex = cube->vertex;
    for (unsigned i = 0; i < made->piece_count && (made->pieces[i] >> edge & 1u) == 0; ++i) {
        ++vertex;
    }
    return vertex;
}

static double squared_length(const svo_i_surface_work *work, uint32_t from, uint32_t to)
{
    const float *a = work->surface->positions + 3 * (size_t)from;
    const float *b = work->surface->positions + 3 * (size_t)to;
    const double x = (double)b[0] - (double)a[0];
    const double y = (double)b[1] - (double)a[1];
    const double z = (double)b[2] - (double)a[2];
    return x * x + y * y + z * z;
}

/* Two triangles of four vertices in their order, along the shorter diagonal. */
static svo_status add_quad(svo_i_surface_work *work, const uint32_t around[4])
{
    static const uint8_t splits[2][6] = {{0, 1, 2, 0, 2, 3}, {1, 2, 3, 1, 3, 0}};
    if (work->triangle_count + 2 >= UINT32_MAX) {
        return svo_i_fail(work->message, SVO_UNSUPPORTED, "svo_surface_create: the surface has %u triangles or more",
                          UINT32_MAX);
    }
    SVO_I_TRY(svo_i_surface_grow(work, (void **)&work->surface->indices, work->triangle_count + 2,
                                 &work->triangle_capacity, 3 * sizeof *work->surface->indices));
    const bool is_second = squared_length(work, around[1], around[3]) < squared_length(work, around[0], around[2]);
    uint32_t *indices = work->surface->indices + 3 * work->triangle_count;
    for (int i = 0; i < 6; ++i) {
        indices[i] = around[splits[is_second ? 1 : 0][i]];
    }
    work->triangle_count += 2;
    return SVO_OK;
}

/* Whether an edge along an axis has an end beyond the field. */
static bool is_at_end(const svo_surface_field *field, const int32_t place[3], unsigned axis)
{
    return place[axis] < 0 || (uint32_t)place[axis] + 1 >= field->size[axis];
}

/* Joins the four cubes around an edge from the lowest corner of the one in the neighborhood at site on. */
static svo_status add_edge(svo_i_surface_work *work, const neighborhood *near, size_t site, const int32_t place[3],
                           unsigned axis)
{
    /* How far the cubes are before the edge on the two other axes, counterclockwise around the first. */
    static const uint8_t before[4] = {0, 1, 3, 2};
    static const size_t strides[3] = {1, SVO_I_SURFACE_SIDE, (size_t)SVO_I_SURFACE_SIDE * SVO_I_SURFACE_SIDE};
    const svo_i_surface_cube *own = &work->cubes[near->cubes[site] - 1];
    const bool is_low_inside = (own->inside & 1u) != 0;
    uint32_t around[4];
    for (unsigned i = 0; i < 4; ++i) {
        const unsigned sides = before[i];
        const size_t other =
            site - (sides & 1u) * strides[(axis + 1) % 3] - (size_t)(sides >> 1) * strides[(axis + 2) % 3];
        if (near->cubes[other] == 0) {
            return svo_i_surface_fail_open(work, place);
        }
        around[is_low_inside ? i : 3 - i] = vertex_at(work, &work->cubes[near->cubes[other] - 1], 4 * axis + sides);
    }
    if (is_at_end(&work->reader.field, place, axis)) {
        work->surface->info.end_triangles += 2;
    }
    return add_quad(work, around);
}

static svo_status add_edges(svo_i_surface_work *work, size_t brick, const neighborhood *near)
{
    for (size_t i = work->bricks[brick].begin; i < work->bricks[brick + 1].begin; ++i) {
        const svo_i_surface_cube *cube = &work->cubes[i];
        const unsigned at[3] = {cube->place % SVO_I_SURFACE_BRICK,
                                cube->place / SVO_I_SURFACE_BRICK % SVO_I_SURFACE_BRICK,
                                cube->place / SVO_I_SURFACE_BRICK / SVO_I_SURFACE_BRICK};
        const int32_t place[3] = {near->low[0] + (int32_t)at[0], near->low[1] + (int32_t)at[1],
                                  near->low[2] + (int32_t)at[2]};
        const size_t site = at[0] + 1 + SVO_I_SURFACE_SIDE * (at[1] + 1 + (size_t)SVO_I_SURFACE_SIDE * (at[2] + 1));
        for (unsigned axis = 0; axis < 3; ++axis) {
            if (((cube->inside ^ cube->inside >> (1u << axis)) & 1u) != 0) {
                SVO_I_TRY(add_edge(work, near, site, place, axis));
            }
        }
    }
    return SVO_OK;
}

svo_status svo_i_surface_find_triangles(svo_i_surface_work *work)
{
    neighborhood near;
    for (size_t brick = 0; brick < work->brick_count; ++brick) {
        look_around(work, brick, &near);
        SVO_I_TRY(add_edges(work, brick, &near));
    }
    return SVO_OK;
}
