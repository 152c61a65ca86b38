/* SPDX-License-Identifier: MIT */
/* Generates meshes for tests. */
#include "meshes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

uint32_t random_word(uint64_t *state)
{
    *state += UINT64_C(0x9e3779b97f4a7c15); /* SplitMix64: Steele, Lea and Flood, 2014 */
    uint64_t mixed = *state;
    mixed = (mixed ^ mixed >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    mixed = (mixed ^ mixed >> 27) * UINT64_C(0x94d049bb133111eb);
    return (uint32_t)((mixed ^ mixed >> 31) >> 32);
}

uint32_t random_below(uint64_t *state, uint32_t limit)
{
    return (uint32_t)((uint64_t)random_word(state) * limit >> 32);
}

double random_unit(uint64_t *state)
{
    return (double)random_word(state) * 0x1p-32;
}

static void allocate(size_t triangle_count, owned_mesh *out)
{
    *out = (owned_mesh){.positions = calloc(triangle_count * 9 + 1, sizeof(double)),
                        .indices = calloc(triangle_count * 3 + 1, sizeof(uint32_t))};
    assert_non_null(out->positions);
    assert_non_null(out->indices);
    for (size_t i = 0; i < triangle_count * 3; ++i) {
        out->indices[i] = (uint32_t)i;
    }
    out->mesh = (svo_mesh){.struct_size = sizeof out->mesh,
                           .positions_double = out->positions,
                           .vertex_count = triangle_count * 3,
                           .indices = out->indices,
                           .triangle_count = triangle_count};
}

void owned_mesh_free(owned_mesh *owned)
{
    free(owned->positions);
    free(owned->indices);
    *owned = (owned_mesh){0};
}

static double clamp_to(double value, double low, double high)
{
    return value < low ? low : value > high ? high : value;
}

/* Corners at most extent away from the first. */
static void around(uint64_t *state, double reach, double extent, double *corners)
{
    for (unsigned axis = 0; axis < 3; ++axis) {
        corners[axis] = random_unit(state) * (1.0 + 2.0 * reach) - reach;
    }
    for (unsigned k = 3; k < 9; ++k) {
        corners[k] = corners[k % 3] + (random_unit(state) * 2.0 - 1.0) * extent;
    }
}

/* Rounds all coordinates to multiples of 1 / cells, which include the voxel faces. */
static void align(double *corners, unsigned cells)
{
    for (unsigned k = 0; k < 9; ++k) {
        const double scaled = corners[k] * cells;
        corners[k] = (double)(int64_t)(scaled < 0.0 ? scaled - 0.5 : scaled + 0.5) / cells;
    }
}

static void copy_corner(double *corners, unsigned from, unsigned to)
{
    for (unsigned axis = 0; axis < 3; ++axis) {
        corners[to * 3 + axis] = corners[from * 3 + axis];
    }
}

static void random_triangle(uint64_t *state, double reach, double *corners)
{
    static const double extents[] = {1e-6, 1e-4, 1e-3, 1e-2, 0.05, 0.3, 1.0};
    const uint32_t sort = random_below(state, 16);
    around(state, reach, extents[random_below(state, 7)] * (1.0 + reach), corners);
    if (sort == 0) { /* a point */
        copy_corner(corners, 0, 1);
        copy_corner(corners, 0, 2);
    } else if (sort == 1) { /* a segment: two equal corners */
        copy_corner(corners, random_below(state, 2), 2);
    } else if (sort == 2) { /* a segment: a corner between the others */
        for (unsigned axis = 0; axis < 3; ++axis) {
            corners[6 + axis] = (corners[axis] + corners[3 + axis]) * 0.5;
        }
    } else if (sort == 3) { /* a needle */
        for (unsigned axis = 0; axis < 3; ++axis) {
            corners[6 + axis] = corners[3 + axis] + (random_unit(state) - 0.5) * 1e-5;
        }
    } else if (sort <= 6) { /* corners on voxel faces */
        align(corners, 1u << (2 + random_below(state, 8)));
    } else if (sort == 7) { /* in a plane perpendicular to an axis */
        const uint32_t axis = random_below(state, 3);
        corners[3 + axis] = corners[6 + axis] = corners[axis];
        if (random_below(state, 2) == 0) {
            align(corners, 64);
        }
    }
    for (unsigned k = 0; k < 9; ++k) {
        corners[k] = clamp_to(corners[k], -reach, 1.0 + reach - (reach == 0.0 ? 0x1p-20 : 0.0));
    }
}

void random_mesh(uint64_t seed, size_t triangle_count, double reach, owned_mesh *out)
{
    uint64_t state = seed;
    allocate(triangle_count, out);
    for (size_t t = 0; t < triangle_count; ++t) {
        random_triangle(&state, reach, out->positions + t * 9);
        if (t > 0 && random_below(&state, 4) == 0) {
            out->indices[t * 3] = (t < 2 ? 0 : random_below(&state, (uint32_t)t)) * 3u;
        }
    }
}

void random_dust(uint64_t seed, size_t triangle_count, const double corner[3], double width, owned_mesh *out)
{
    uint64_t state = seed;
    allocate(triangle_count, out);
    for (size_t i = 0; i < triangle_count * 9; ++i) {
        out->positions[i] = corner[i % 3] + random_unit(&state) * width;
    }
}

void random_needles(uint64_t seed, size_t triangle_count, owned_mesh *out)
{
    static const double widths[] = {1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5, 1e-6};
    uint64_t state = seed;
    allocate(triangle_count, out);
    for (size_t t = 0; t < triangle_count; ++t) {
        double *corners = out->positions + t * 9;
        const double along = random_unit(&state);
        const double width = widths[random_below(&state, 9)];
        for (unsigned axis = 0; axis < 3; ++axis) {
            corners[axis] = random_unit(&state);
            corners[3 + axis] = random_unit(&state);
            const double inside = corners[axis] + (corners[3 + axis] - corners[axis]) * along;
            corners[6 + axis] = clamp_to(inside + (random_unit(&state) - 0.5) * width, 0.0, 1.0);
        }
    }
}

void corner_mesh(unsigned cells, owned_mesh *out)
{
    /* The plane x + y + z = 3 eps cuts seven of the eight octants around the corner. */
    static const double shape[9] = {4.0, -2.0, -1.0, -1.0, 4.0, -2.0, -2.0, -1.0, 4.0};
    const size_t inner = cells - 1;
    allocate(inner * inner * inner, out);
    for (size_t t = 0; t < out->mesh.triangle_count; ++t) {
        const size_t cell[3] = {t % inner + 1, t / inner % inner + 1, t / inner / inner + 1};
        for (unsigned k = 0; k < 9; ++k) {
            out->positions[t * 9 + k] = (double)cell[k % 3] / cells + shape[k] * 0x1p-20;
        }
    }
}
