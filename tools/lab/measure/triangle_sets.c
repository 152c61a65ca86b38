/* SPDX-License-Identifier: MIT */
/* Generates the shapes of triangles. */
#include "measure/triangle_sets.h"

#include <stdlib.h>
#include <string.h>

#define VOXEL 16384 /* of depth 6; the aligned shapes lie on them */

const char *triangle_shape_name(triangle_shape shape)
{
    static const char *const names[TRIANGLE_SHAPE_COUNT] = {"small",    "huge",    "slivers",   "needles",
                                                            "coplanar", "lattice", "degenerate"};
    return names[shape];
}

static int clamp_unit(int value)
{
    return value < 0 ? 0 : value >= TRIANGLE_SET_UNITS ? TRIANGLE_SET_UNITS - 1 : value;
}

/* A whole number within reach of value, inside the grid. */
static int near(random_stream *random, int value, int reach)
{
    return clamp_unit(value + (int)random_index(random, (uint32_t)(2 * reach + 1)) - reach);
}

static void make_anywhere(random_stream *random, int reach, int corner[3][3])
{
    for (int k = 0; k < 3; ++k) {
        corner[0][k] = (int)random_index(random, TRIANGLE_SET_UNITS);
        corner[1][k] = near(random, corner[0][k], reach);
        corner[2][k] = near(random, corner[0][k], reach);
    }
}

/* The third corner lies close to a point of the edge between the others. */
static void make_thin(random_stream *random, int reach, int width, int corner[3][3])
{
    make_anywhere(random, reach, corner);
    const int along = (int)random_index(random, 1025);
    for (int k = 0; k < 3; ++k) {
        const int64_t offset = (int64_t)(corner[1][k] - corner[0][k]) * along / 1024;
        corner[2][k] = near(random, corner[0][k] + (int)offset, width);
    }
}

static int align(int value)
{
    return value / VOXEL * VOXEL;
}

static void make_aligned(random_stream *random, bool everywhere, int corner[3][3])
{
    make_anywhere(random, VOXEL * 6, corner);
    const uint32_t flat = random_index(random, 3);
    for (uint32_t k = 0; k < 3; ++k) {
        for (int i = 0; i < 3; ++i) {
            corner[i][k] = everywhere ? align(corner[i][k]) : k == flat ? align(corner[0][k]) : corner[i][k];
        }
    }
}

static void make_degenerate(random_stream *random, int corner[3][3])
{
    make_thin(random, VOXEL * 8, 0, corner);
    if (random_index(random, 2) == 0) {
        memcpy(corner[2], corner[0], sizeof corner[0]);
    }
    if (random_index(random, 4) == 0) {
        memcpy(corner[1], corner[0], sizeof corner[0]);
        memcpy(corner[2], corner[0], sizeof corner[0]);
    }
}

static void make_triangle(triangle_shape shape, random_stream *random, int corner[3][3])
{
    static const int widths[] = {1, 8, 64, 512, 2048};
    switch (shape) {
    case TRIANGLES_HUGE:
        make_anywhere(random, TRIANGLE_SET_UNITS, corner);
        break;
    case TRIANGLES_SLIVERS:
        make_thin(random, TRIANGLE_SET_UNITS / 4, widths[random_index(random, 5)], corner);
        break;
    case TRIANGLES_NEEDLES:
        make_thin(random, VOXEL * 4, 0, corner);
        for (int k = 0; k < 3; ++k) {
            corner[0][k] = clamp_unit(align(corner[0][k]) + VOXEL / 1024);
            corner[1][k] = clamp_unit(align(corner[1][k]) - VOXEL / 1024);
        }
        break;
    case TRIANGLES_COPLANAR:
    case TRIANGLES_LATTICE:
        make_aligned(random, shape == TRIANGLES_LATTICE, corner);
        break;
    case TRIANGLES_DEGENERATE:
        make_degenerate(random, corner);
        break;
    default:
        make_anywhere(random, VOXEL >> random_index(random, 5), corner);
        break;
    }
}

bool triangle_set_empty(size_t triangle_count, triangle_set *out)
{
    *out = (triangle_set){.positions = calloc(triangle_count * 9 + 1, sizeof(double)),
                          .colors = calloc(triangle_count * 12 + 1, 1)};
    if (out->positions == NULL || out->colors == NULL) {
        triangle_set_free(out);
        return false;
    }
    out->mesh = (svo_mesh){.struct_size = sizeof out->mesh,
                           .positions_double = out->positions,
                           .vertex_count = triangle_count * 3,
                           .triangle_count = triangle_count};
    return true;
}

bool triangle_set_create(triangle_shape shape, uint64_t seed, size_t triangle_count, triangle_set *out)
{
    random_stream random = {seed + (uint64_t)shape * 1000003u};
    if (!triangle_set_empty(triangle_count, out)) {
        return false;
    }
    for (size_t t = 0; t < triangle_count; ++t) {
        int corner[3][3];
        make_triangle(shape, &random, corner);
        for (size_t i = 0; i < 9; ++i) {
            const int *vertex = corner[i / 3];
            out->positions[t * 9 + i] = vertex[i % 3];
        }
    }
    return true;
}

void triangle_set_free(triangle_set *made)
{
    free(made->positions);
    free(made->colors);
    *made = (triangle_set){0};
}

void triangle_set_move(triangle_set *made, double factor, double offset)
{
    for (size_t i = 0; i < made->mesh.vertex_count * 3; ++i) {
        made->positions[i] = made->positions[i] * factor + offset;
    }
}

static void swap_bytes(void *a, void *b, size_t byte_count)
{
    uint8_t kept[72];
    memcpy(kept, a, byte_count);
    memcpy(a, b, byte_count);
    memcpy(b, kept, byte_count);
}

void triangle_set_shuffle(triangle_set *made, uint64_t seed)
{
    random_stream random = {seed};
    for (size_t t = made->mesh.triangle_count; t-- > 1;) {
        const size_t other = random_index(&random, (uint32_t)t + 1);
        if (other != t) {
            swap_bytes(made->positions + t * 9, made->positions + other * 9, 9 * sizeof(double));
            swap_bytes(made->colors + t * 12, made->colors + other * 12, 12);
        }
    }
}
