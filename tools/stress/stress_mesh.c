/* SPDX-License-Identifier: MIT */
/* Generates the classes of triangles. */
#include "stress/stress_mesh.h"

#include <stdlib.h>
#include <string.h>

#define VOXEL 16384 /* of depth 6; the aligned classes lie on them */

const char *stress_shape_name(stress_shape shape)
{
    static const char *const names[STRESS_SHAPE_COUNT] = {"small",    "huge",    "slivers",   "needles",
                                                          "coplanar", "lattice", "degenerate"};
    return names[shape];
}

uint32_t stress_random_below(random_stream *random, uint32_t limit)
{
    return (uint32_t)((random_bits(random) >> 32) * limit >> 32);
}

static int clamp_unit(int value)
{
    return value < 0 ? 0 : value >= STRESS_UNITS ? STRESS_UNITS - 1 : value;
}

/* A whole number within reach of value, inside the grid. */
static int near(random_stream *random, int value, int reach)
{
    return clamp_unit(value + (int)stress_random_below(random, (uint32_t)(2 * reach + 1)) - reach);
}

static void make_anywhere(random_stream *random, int reach, int corner[3][3])
{
    for (int k = 0; k < 3; ++k) {
        corner[0][k] = (int)stress_random_below(random, STRESS_UNITS);
        corner[1][k] = near(random, corner[0][k], reach);
        corner[2][k] = near(random, corner[0][k], reach);
    }
}

/* The third corner lies close to a point of the edge between the others. */
static void make_thin(random_stream *random, int reach, int width, int corner[3][3])
{
    make_anywhere(random, reach, corner);
    const int along = (int)stress_random_below(random, 1025);
    for (int k = 0; k < 3; ++k) {
        const int64_t method = (int64_t)(corner[1][k] - corner[0][k]) * along / 1024;
        corner[2][k] = near(random, corner[0][k] + (int)method, width);
    }
}

static int align(int value)
{
    return value / VOXEL * VOXEL;
}

static void make_aligned(random_stream *random, bool everywhere, int corner[3][3])
{
    make_anywhere(random, VOXEL * 6, corner);
    const uint32_t flat = stress_random_below(random, 3);
    for (uint32_t k = 0; k < 3; ++k) {
        for (int i = 0; i < 3; ++i) {
            corner[i][k] = everywhere ? align(corner[i][k]) : k == flat ? align(corner[0][k]) : corner[i][k];
        }
    }
}

static void make_degenerate(random_stream *random, int corner[3][3])
{
    make_thin(random, VOXEL * 8, 0, corner);
    if (stress_random_below(random, 2) == 0) {
        memcpy(corner[2], corner[0], sizeof corner[0]);
    }
    if (stress_random_below(random, 4) == 0) {
        memcpy(corner[1], corner[0], sizeof corner[0]);
        memcpy(corner[2], corner[0], sizeof corner[0]);
    }
}

static void make_triangle(stress_shape shape, random_stream *random, int corner[3][3])
{
    static const int widths[] = {1, 8, 64, 512, 2048};
    switch (shape) {
    case STRESS_HUGE:
        make_anywhere(random, STRESS_UNITS, corner);
        break;
    case STRESS_SLIVERS:
        make_thin(random, STRESS_UNITS / 4, widths[stress_random_below(random, 5)], corner);
        break;
    case STRESS_NEEDLES:
        make_thin(random, VOXEL * 4, 0, corner);
        for (int k = 0; k < 3; ++k) {
            corner[0][k] = clamp_unit(align(corner[0][k]) + VOXEL / 1024);
            corner[1][k] = clamp_unit(align(corner[1][k]) - VOXEL / 1024);
        }
        break;
    case STRESS_COPLANAR:
    case STRESS_LATTICE:
        make_aligned(random, shape == STRESS_LATTICE, corner);
        break;
    case STRESS_DEGENERATE:
        make_degenerate(random, corner);
        break;
    default:
        make_anywhere(random, VOXEL >> stress_random_below(random, 5), corner);
        break;
    }
}

bool stress_mesh_empty(size_t triangle_count, stress_mesh *out)
{
    *out = (stress_mesh){.positions = calloc(triangle_count * 9 + 1, sizeof(double)),
                         .colors = calloc(triangle_count * 12 + 1, 1)};
    if (out->positions == NULL || out->colors == NULL) {
        stress_mesh_free(out);
        return false;
    }
    out->mesh = (svo_mesh){.struct_size = sizeof out->mesh,
                           .positions_double = out->positions,
                           .vertex_count = triangle_count * 3,
                           .triangle_count = triangle_count};
    return true;
}

bool stress_mesh_create(stress_shape shape, uint64_t seed, size_t triangle_count, stress_mesh *out)
{
    random_stream random = {seed + (uint64_t)shape * 1000003u};
    if (!stress_mesh_empty(triangle_count, out)) {
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

void stress_mesh_free(stress_mesh *made)
{
    free(made->positions);
    free(made->colors);
    *made = (stress_mesh){0};
}

void stress_mesh_move(stress_mesh *made, double factor, double offset)
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

void stress_mesh_shuffle(stress_mesh *made, uint64_t seed)
{
    random_stream random = {seed};
    for (size_t t = made->mesh.triangle_count; t-- > 1;) {
        const size_t other = stress_random_below(&random, (uint32_t)t + 1);
        if (other != t) {
            swap_bytes(made->positions + t * 9, made->positions + other * 9, 9 * sizeof(double));
            swap_bytes(made->colors + t * 12, made->colors + other * 12, 12);
        }
    }
}
