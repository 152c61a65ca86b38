/* SPDX-License-Identifier: MIT */
/* Filters dense grids of opacity, level by level, in the words of the formulas. */
#include "light_reference.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

uint32_t light_levels_width(const light_levels *levels, uint32_t level)
{
    return (1u << level) + (levels->form == SVO_LIGHT_BRICKS ? 1u : 0u);
}

/* The index of a value, or SIZE_MAX outside. */
static size_t index_of(const light_levels *levels, uint32_t level, const int at[3], uint32_t value)
{
    const int width = (int)light_levels_width(levels, level);
    for (int axis = 0; axis < 3; ++axis) {
        if (at[axis] < 0 || at[axis] >= width) {
            return SIZE_MAX;
        }
    }
    const size_t row = (size_t)width;
    return ((size_t)at[0] + row * ((size_t)at[1] + row * (size_t)at[2])) * levels->count + value;
}

double light_levels_get(const light_levels *levels, uint32_t level, const int at[3], uint32_t value)
{
    const size_t index = index_of(levels, level, at, value);
    return index != SIZE_MAX ? levels->cells[level][index] : 0;
}

static double stored(const light_levels *levels, double value)
{
    return levels->whole ? floor(value + 0.5) : value;
}

/* ---- the values of a level ---- */

/* A neighbor's place by three bits. */
static void step_to(const int at[3], int scale, unsigned bits, int out[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        out[axis] = scale * at[axis] + (int)(bits >> axis & 1u);
    }
}

/* Faces: a ray along the axis passes through two of the eight cells, of which there are four pairs. */
static double face_value(const light_levels *levels, uint32_t level, const int at[3], uint32_t direction)
{
    const unsigned along = 1u << (direction / 2);
    double sum = 0;
    for (unsigned octant = 0; octant < 8; ++octant) {
        int front[3];
        int back[3];
        if (((octant & along) != 0) != (direction % 2 != 0)) {
            continue;
        }
        step_to(at, 2, octant, front);
        step_to(at, 2, octant ^ along, back);
        if (levels->opacity != NULL) {
            const double passing = 1 - light_levels_get(levels->opacity, level + 1, front, direction) / 65535;
            sum += light_levels_get(levels, level + 1, front, direction) +
                   passing * light_levels_get(levels, level + 1, back, direction);
        } else {
            sum += (65535 - light_levels_get(levels, level + 1, front, direction)) *
                   (65535 - light_levels_get(levels, level + 1, back, direction));
        }
    }
    return levels->opacity != NULL ? sum / 4 : 65535 - stored(levels, sum / (4.0 * 65535));
}

static double voxel_value(const light_levels *levels, uint32_t level, const int at[3])
{
    double sum = 0;
    for (unsigned octant = 0; octant < 8; ++octant) {
        int child[3];
        step_to(at, 2, octant, child);
        sum += light_levels_get(levels, level + 1, child, 0);
    }
    return stored(levels, sum / 8);
}

/* Bricks: (1, 2, 1) / 4 on each axis, around every second point. */
static double point_value(const light_levels *levels, uint32_t level, const int at[3])
{
    double sum = 0;
    for (int k = 0; k < 27; ++k) {
        const int by[3] = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
        const int fine[3] = {2 * at[0] + by[0], 2 * at[1] + by[1], 2 * at[2] + by[2]};
        sum += (2 - abs(by[0])) * (2 - abs(by[1])) * (2 - abs(by[2])) * light_levels_get(levels, level + 1, fine, 0);
    }
    return stored(levels, sum / 64);
}

static double value_of(const light_levels *levels, uint32_t level, const int at[3], uint32_t value)
{
    switch (levels->form) {
    case SVO_LIGHT_BRICKS:
        return point_value(levels, level, at);
    case SVO_LIGHT_VOXELS:
        return voxel_value(levels, level, at);
    default:
        return face_value(levels, level, at, value);
    }
}

/* ---- the deepest level ---- */

/* Bricks: the mean over the eight cells around a point. leaves: six values each. */
static double deepest_point(const light_levels *levels, const double *leaves, const int at[3])
{
    const int cells = 1 << levels->depth;
    double sum = 0;
    for (unsigned octant = 0; octant < 8; ++octant) {
        int cell[3];
        step_to(at, 1, octant, cell);
        const int x = cell[0] - 1;
        const int y = cell[1] - 1;
        const int z = cell[2] - 1;
        if (x >= 0 && y >= 0 && z >= 0 && x < cells && y < cells && z < cells) {
            sum += leaves[6 * (size_t)(x + cells * (y + cells * z))];
        }
    }
    return stored(levels, sum / 8);
}

static double deepest_value(const light_levels *levels, const double *leaves, const int at[3], uint32_t value)
{
    const int cells = 1 << levels->depth;
    return levels->form == SVO_LIGHT_BRICKS ? deepest_point(levels, leaves, at)
                                            : leaves[6 * (size_t)(at[0] + cells * (at[1] + cells * at[2])) + value];
}

/* From the deepest level upwards. */
static void filter(light_levels *levels, const double *leaves)
{
    for (uint32_t level = levels->depth + 1; level-- > (levels->form == SVO_LIGHT_BRICKS ? 1u : 0u);) {
        const size_t width = light_levels_width(levels, level);
        const size_t values = width * width * width * levels->count;
        levels->cells[level] = malloc(values * sizeof(double));
        assert_non_null(levels->cells[level]);
        for (size_t k = 0; k < values; ++k) {
            const size_t cell = k / levels->count;
            const uint32_t value = (uint32_t)(k % levels->count);
            const int at[3] = {(int)(cell % width), (int)(cell / width % width), (int)(cell / width / width)};
            levels->cells[level][k] =
                level == levels->depth ? deepest_value(levels, leaves, at, value) : value_of(levels, level, at, value);
        }
    }
}

void light_levels_make(svo_light_form form, uint32_t depth, const uint16_t *leaves, light_levels *out)
{
    const size_t cells = (size_t)1 << 3 * depth;
    double *values = malloc(cells * 6 * sizeof *values);
    assert_non_null(values);
    for (size_t k = 0; k < 6 * cells; ++k) {
        const uint16_t *leaf = leaves + k / 6 * 6;
        values[k] = leaves[k];
        for (int other = 0; form != SVO_LIGHT_FACES && other < 6; ++other) {
            values[k] = fmax(values[k], leaf[other]);
        }
    }
    *out = (light_levels){.form = form, .depth = depth, .count = form == SVO_LIGHT_FACES ? 6 : 1, .whole = true};
    filter(out, values);
    free(values);
}

void light_levels_make_light(const light_levels *opacity, const double *leaves, light_levels *out)
{
    *out = (light_levels){
        .form = opacity->form, .depth = opacity->depth, .count = opacity->count, .opacity = opacity, .whole = false};
    filter(out, leaves);
}

void light_levels_free(light_levels *levels)
{
    for (int level = 0; level <= LIGHT_DEPTH_MAX; ++level) {
        free(levels->cells[level]);
        levels->cells[level] = NULL;
    }
}
