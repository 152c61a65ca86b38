/* SPDX-License-Identifier: MIT */
/*
 * The second step to a surface: cubes that it passes, and a vertex for each of their pieces, at the mean of the points
 * where the piece crosses edges (Gibson 1998, "Constrained Elastic Surface Nets"). Such a mean lies within its cube and
 * is not on its faces, so vertices of two cubes are not the same.
 */
#include "surface/vertices.h"

#include <math.h>
#include <string.h>

#include "shared/nodes.clh"

/* Crossings keep so far from centers, in voxels: pieces around one center would else shrink to a point. */
#define KEPT_FROM_CENTER 0x1p-10

#define CUBES ((size_t)SVO_I_SURFACE_BRICK * SVO_I_SURFACE_BRICK * SVO_I_SURFACE_BRICK)

/* A cube in its window. */
typedef struct cube {
    int32_t place[3]; /* of its lowest center in the field */
    size_t sites[8]; /* of its corners in the window */
    float values[8]; /* of its corners */
    unsigned inside; /* corners: bits */
} cube;

static svo_status fail_full(const svo_i_surface_work *work)
{
    return svo_i_fail(work->message, SVO_UNSUPPORTED, "svo_surface_create: the surface has %u vertices or more",
                      UINT32_MAX);
}

/* ---- cubes ---- */

static size_t site_of(size_t x, size_t y, size_t z)
{
    return x + SVO_I_SURFACE_SIDE * (y + SVO_I_SURFACE_SIDE * z);
}

/* Whether all corners are known. */
static bool take_cube(const svo_i_surface_window *window, size_t place, cube *out)
{
    const size_t at[3] = {place % SVO_I_SURFACE_BRICK, place / SVO_I_SURFACE_BRICK % SVO_I_SURFACE_BRICK,
                          place / SVO_I_SURFACE_BRICK / SVO_I_SURFACE_BRICK};
    bool is_whole = true;
    out->inside = 0;
    for (int axis = 0; axis < 3; ++axis) {
        out->place[axis] = window->low[axis] + (int32_t)at[axis];
    }
    for (unsigned corner = 0; corner < 8; ++corner) {
        const size_t site = site_of(at[0] + (corner & 1u), at[1] + (corner >> 1 & 1u), at[2] + (corner >> 2));
        out->sites[corner] = site;
        is_whole = is_whole && window->states[site] != SVO_I_SURFACE_ABSENT;
        out->inside |= window->states[site] == SVO_I_SURFACE_INSIDE ? 1u << corner : 0u;
    }
    return is_whole;
}

/* Whether the surface crosses one of the edges at the lowest corner, of a cube with corners that are not known. */
static bool is_crossed(const svo_i_surface_window *window, const cube *c)
{
    const uint8_t state = window->states[c->sites[0]];
    bool found = false;
    for (unsigned axis = 0; axis < 3; ++axis) {
        const uint8_t other = window->states[c->sites[1u << axis]];
        found = found || (state != SVO_I_SURFACE_ABSENT && other != SVO_I_SURFACE_ABSENT && state != other);
    }
    return found;
}

/* Whether the cube's shared face is that of its neighbor there, too. */
static bool is_joined(const svo_i_surface_work *work, const cube *c)
{
    const uint8_t face = work->cases.shared_face[c->inside];
    if (face == SVO_I_SURFACE_NO_FACE) {
        return false;
    }
    unsigned inside = 0;
    for (unsigned corner = 0; corner < 8; ++corner) {
        int32_t place[3];
        for (unsigned axis = 0; axis < 3; ++axis) {
            place[axis] = c->place[axis] + (int32_t)(corner >> axis & 1u);
        }
        place[face / 2] += face % 2 != 0 ? 1 : -1;
        const svo_i_surface_state state = svo_i_surface_look(&work->reader, place);
        if (state == SVO_I_SURFACE_ABSENT) {
            return false;
        }
        inside |= state == SVO_I_SURFACE_INSIDE ? 1u << corner : 0u;
    }
    return work->cases.shared_face[inside] == (face ^ 1u);
}

/* ---- vertices ---- */

/* Where the level is between the ends of an edge, from the lower one on. */
static double find_crossing(const svo_i_surface_work *work, const cube *c, unsigned edge)
{
    const double low = (double)c->values[svo_i_surface_edge_low(edge)];
    const double high = (double)c->values[svo_i_surface_edge_high(edge)];
    const double share = high != low ? ((double)work->reader.level - low) / (high - low) : 0.5;
    return fmin(fmax(share, KEPT_FROM_CENTER), 1.0 - KEPT_FROM_CENTER);
}

/* The mean of the crossings of a piece, from the lowest center on, in voxels. */
static void find_mean(const svo_i_surface_work *work, const cube *c, unsigned piece, double mean[3])
{
    double count = 0.0;
    double sum[3] = {0.0, 0.0, 0.0};
    for (unsigned edge = 0; edge < 12; ++edge) {
        if ((piece >> edge & 1u) != 0) {
            const unsigned corner = svo_i_surface_edge_low(edge);
            for (unsigned axis = 0; axis < 3; ++axis) {
                sum[axis] += (double)(corner >> axis & 1u);
            }
            sum[edge / 4] += find_crossing(work, c, edge);
            count += 1.0;
        }
    }
    for (int axis = 0; axis < 3; ++axis) {
        mean[axis] = sum[axis] / count;
    }
}

/* The gradient of the trilinear interpolation of the corners, as long as 1; 0 where there is none. */
static void find_normal(const cube *c, const double at[3], float normal[3])
{
    double gradient[3] = {0.0, 0.0, 0.0};
    for (unsigned corner = 0; corner < 8; ++corner) {
        double weights[3];
        for (unsigned axis = 0; axis < 3; ++axis) {
            weights[axis] = (corner >> axis & 1u) != 0 ? at[axis] : 1.0 - at[axis];
        }
        for (unsigned axis = 0; axis < 3; ++axis) {
            const double slope = weights[(axis + 1) % 3] * weights[(axis + 2) % 3] * (double)c->values[corner];
            gradient[axis] += (corner >> axis & 1u) != 0 ? slope : -slope;
        }
    }
    const double largest = fmax(fabs(gradient[0]), fmax(fabs(gradient[1]), fabs(gradient[2])));
    double squared = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        gradient[axis] = largest > 0.0 ? gradient[axis] / largest : 0.0;
        squared += gradient[axis] * gradient[axis];
    }
    for (int axis = 0; axis < 3; ++axis) {
        normal[axis] = largest > 0.0 ? (float)(gradient[axis] / sqrt(squared)) : 0.0F;
    }
}

static svo_status add_vertex(svo_i_surface_work *work, const cube *c, unsigned piece)
{
    svo_surface *surface = work->surface;
    const size_t index = work->vertex_count;
    double mean[3];
    if (index + 1 >= UINT32_MAX) {
        return fail_full(work);
    }
    SVO_I_TRY(svo_i_surface_grow(work, (void **)&surface->positions, index + 1, &work->vertex_capacity,
                                 3 * sizeof *surface->positions));
    find_mean(work, c, piece, mean);
    for (int axis = 0; axis < 3; ++axis) {
        const svo_surface_field *field = &work->reader.field;
        surface->positions[3 * index + (size_t)axis] =
            (float)(field->first[axis] + field->spacing * ((double)c->place[axis] + mean[axis]));
    }
    if (work->with_normals) {
        SVO_I_TRY(svo_i_surface_grow(work, (void **)&surface->normals, index + 1, &work->normal_capacity,
                                     3 * sizeof *surface->normals));
        find_normal(c, mean, surface->normals + 3 * index);
    }
    work->vertex_count = index + 1;
    return SVO_OK;
}

/* Adds a cube that the surface passes. */
static svo_status add_cube(svo_i_surface_work *work, const svo_i_surface_window *window, size_t place, cube *c)
{
    const bool joined = is_joined(work, c);
    const svo_i_surface_case *made = joined ? &work->cases.joined[c->inside] : &work->cases.apart[c->inside];
    SVO_I_TRY(svo_i_surface_grow(work, (void **)&work->cubes, work->cube_count + 1, &work->cube_capacity,
                                 sizeof *work->cubes));
    work->cubes[work->cube_count++] = (svo_i_surface_cube){.vertex = (uint32_t)work->vertex_count,
                                                           .place = (uint16_t)place,
                                                           .inside = (uint8_t)c->inside,
                                                           .is_joined = joined};
    for (unsigned corner = 0; corner < 8; ++corner) {
        c->values[corner] = window->values[c->sites[corner]];
    }
    for (unsigned i = 0; i < made->piece_count; ++i) {
        SVO_I_TRY(add_vertex(work, c, made->pieces[i]));
    }
    return SVO_OK;
}

/* ---- bricks ---- */

static bool is_cube_of_field(const svo_surface_field *field, const cube *c)
{
    bool is_within = true;
    for (int axis = 0; axis < 3; ++axis) {
        is_within = is_within && c->place[axis] >= -1 && c->place[axis] < (int32_t)field->size[axis];
    }
    return is_within;
}

static svo_status add_cubes(svo_i_surface_work *work, const svo_i_surface_window *window)
{
    for (size_t place = 0; place < CUBES; ++place) {
        cube c;
        const bool is_whole = take_cube(window, place, &c);
        if (!is_cube_of_field(&work->reader.field, &c)) {
            continue;
        }
        if (!is_whole && is_crossed(window, &c)) {
            return svo_i_surface_fail_open(work, c.place);
        }
        if (is_whole && c.inside != 0 && c.inside != 255) {
            SVO_I_TRY(add_cube(work, window, place, &c));
        }
    }
    return SVO_OK;
}

svo_status svo_i_surface_find_vertices(svo_i_surface_work *work)
{
    svo_i_surface_window window;
    for (uint64_t i = 0; i < work->reader.brick_count; ++i) {
        const size_t begin = work->cube_count;
        SVO_I_TRY(svo_i_surface_read(&work->reader, work->reader.bricks[i], work->message, &window));
        if (window.is_mixed) {
            SVO_I_TRY(add_cubes(work, &window));
        }
        /* With room for the one behind them. */
        SVO_I_TRY(svo_i_surface_grow(work, (void **)&work->bricks, work->brick_count + 2, &work->brick_capacity,
                                     sizeof *work->bricks));
        if (work->cube_count > begin) {
            work->bricks[work->brick_count++] = (svo_i_surface_brick){work->reader.bricks[i], begin};
        }
        work->bricks[work->brick_count] = (svo_i_surface_brick){UINT64_MAX, work->cube_count};
    }
    return SVO_OK;
}
