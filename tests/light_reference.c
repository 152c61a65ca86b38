/* SPDX-License-Identifier: MIT */
/* Filters dense grids of opacity, level by level, in the words of the formulas. */
#include "light_reference.h"

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

static uint16_t round_half_up(double value)
{
    return (uint16_t)(value + 0.5);
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
static uint16_t face_value(const light_levels *levels, uint32_t level, const int at[3], uint32_t direction)
{
    const unsigned along = 1u << (direction / 2);
    double passing = 0;
    for (unsigned octant = 0; octant < 8; ++octant) {
        int front[3];
        int back[3];
        if ((octant & along) == 0) {
            step_to(at, 2, octant, front);
            step_to(at, 2, octant | along, back);
            passing += (65535 - light_levels_get(levels, level + 1, front, direction)) *
                       (65535 - light_levels_get(levels, level + 1, back, direction));
        }
    }
    return (uint16_t)(65535 - round_half_up(passing / (4.0 * 65535)));
}

static uint16_t voxel_value(const light_levels *levels, uint32_t level, const int at[3])
{
    double sum = 0;
    for (unsigned octant = 0; octant < 8; ++octant) {
        int child[3];
        step_to(at, 2, octant, child);
        sum += light_levels_get(levels, level + 1, child, 0);
    }
    return round_half_up(sum / 8);
}

/* Bricks: (1, 2, 1) / 4 on each axis, around every second point. */
static uint16_t point_value(const light_levels *levels, uint32_t level, const int at[3])
{
    double sum = 0;
    for (int k = 0; k < 27; ++k) {
        const int by[3] = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
        const int fine[3] = {2 * at[0] + by[0], 2 * at[1] + by[1], 2 * at[2] + by[2]};
        sum += (2 - abs(by[0])) * (2 - abs(by[1])) * (2 - abs(by[2])) * light_levels_get(levels, level + 1, fine, 0);
    }
    return round_half_up(sum / 64);
}

static uint16_t value_of(const light_levels *levels, uint32_t level, const int at[3], uint32_t value)
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

static double largest_of(const uint16_t *leaf)
{
    double largest = 0;
    for (int direction = 0; direction < 6; ++direction) {
        largest = leaf[direction] > largest ? leaf[direction] : largest;
    }
    return largest;
}

static uint16_t deepest_value(const light_levels *levels, const uint16_t *leaves, const int at[3], uint32_t value)
{
    const int cells = 1 << levels->depth;
    double sum = 0;
    if (levels->form != SVO_LIGHT_BRICKS) {
        const uint16_t *leaf = leaves + 6 * (size_t)(at[0] + cells * (at[1] + cells * at[2]));
        return levels->form == SVO_LIGHT_FACES ? leaf[value] : (uint16_t)largest_of(leaf);
    }
    for (unsigned octant = 0; octant < 8; ++octant) {
        int cell[3];
        step_to(at, 1, octant, cell);
        const int x = cell[0] - 1;
        const int y = cell[1] - 1;
        const int z = cell[2] - 1;
        if (x >= 0 && y >= 0 && z >= 0 && x < cells && y < cells && z < cells) {
            sum += largest_of(leaves + 6 * (size_t)(x + cells * (y + cells * z)));
        }
    }
    return round_half_up(sum / 8);
}

void light_levels_make(svo_light_form form, uint32_t depth, const uint16_t *leaves, light_levels *out)
{
    *out = (light_levels){.form = form, .depth = depth, .count = form == SVO_LIGHT_FACES ? 6 : 1};
    for (uint32_t level = depth + 1; level-- > (form == SVO_LIGHT_BRICKS ? 1u : 0u);) {
        const size_t width = light_levels_width(out, level);
        out->cells[level] = malloc(width * width * width * out->count * sizeof(uint16_t));
        assert_non_null(out->cells[level]);
        for (size_t k = 0; k < width * width * width * out->count; ++k) {
            const size_t cell = k / out->count;
            const uint32_t value = (uint32_t)(k % out->count);
            const int at[3] = {(int)(cell % width), (int)(cell / width % width), (int)(cell / width / width)};
            out->cells[level][k] =
                level == depth ? deepest_value(out, leaves, at, value) : value_of(out, level, at, value);
        }
    }
}

void light_levels_free(light_levels *levels)
{
    for (int level = 0; level <= LIGHT_DEPTH_MAX; ++level) {
        free(levels->cells[level]);
        levels->cells[level] = NULL;
    }
}
