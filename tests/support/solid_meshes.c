/* SPDX-License-Identifier: MIT */
/* Closed parts, added to one mesh. */
#include "solid_meshes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <math.h>

void parts_free(parts *made)
{
    free(made->positions);
    free(made->indices);
    *made = (parts){.vertex_count = 0};
}

svo_mesh parts_mesh(const parts *made)
{
    return (svo_mesh){.struct_size = sizeof(svo_mesh),
                      .positions_double = made->positions,
                      .vertex_count = made->vertex_count,
                      .indices = made->indices,
                      .triangle_count = made->triangle_count};
}

/* Returns the index of the new vertex. */
static uint32_t add_vertex(parts *made, double x, double y, double z)
{
    const double at[3] = {x, y, z};
    double *grown = realloc(made->positions, (made->vertex_count + 1) * sizeof at);
    assert_non_null(grown);
    made->positions = grown;
    memcpy(made->positions + made->vertex_count * 3, at, sizeof at);
    return (uint32_t)made->vertex_count++;
}

static void add_triangle(parts *made, uint32_t a, uint32_t b, uint32_t c)
{
    const uint32_t corners[3] = {a, b, c};
    uint32_t *grown = realloc(made->indices, (made->triangle_count + 1) * sizeof corners);
    assert_non_null(grown);
    made->indices = grown;
    memcpy(made->indices + made->triangle_count++ * 3, corners, sizeof corners);
}

void parts_add_box(parts *made, const double low[3], const double high[3], bool inwards, int skip)
{
    uint32_t corners[8];
    for (unsigned i = 0; i < 8; ++i) {
        corners[i] = add_vertex(made, (i & 1) != 0 ? high[0] : low[0], (i & 2) != 0 ? high[1] : low[1],
                                (i & 4) != 0 ? high[2] : low[2]);
    }
    for (int face = 0; face < 6; ++face) {
        const unsigned axis = (unsigned)face / 2;
        const unsigned u = 1u << (axis + 1) % 3;
        const unsigned v = 1u << (axis + 2) % 3;
        const unsigned first = face % 2 == 1 ? 1u << axis : 0;
        const bool turned = (face % 2 == 0) != inwards;
        if (face != skip) {
            add_triangle(made, corners[first], corners[first + (turned ? v : u)], corners[first + u + v]);
            add_triangle(made, corners[first], corners[first + u + v], corners[first + (turned ? u : v)]);
        }
    }
}

void parts_add_cube(parts *made, double first, double last, bool inwards, int skip)
{
    const double low[3] = {first, first, first};
    const double high[3] = {last, last, last};
    parts_add_box(made, low, high, inwards, skip);
}

void parts_add_tetrahedron(parts *made, const double corners[4][3])
{
    uint32_t v[4];
    for (int i = 0; i < 4; ++i) {
        v[i] = add_vertex(made, corners[i][0], corners[i][1], corners[i][2]);
    }
    add_triangle(made, v[0], v[2], v[1]);
    add_triangle(made, v[0], v[1], v[3]);
    add_triangle(made, v[1], v[2], v[3]);
    add_triangle(made, v[2], v[0], v[3]);
}

void parts_add_sphere(parts *made, const double center[3], double radius, unsigned rings)
{
    static const double pi = 3.14159265358979323846;
    const unsigned sectors = 2 * rings;
    const uint32_t bottom = add_vertex(made, center[0], center[1], center[2] - radius);
    const uint32_t first = bottom + 1;
    for (unsigned ring = 1; ring < rings; ++ring) {
        for (unsigned k = 0; k < sectors; ++k) {
            const double tilt = pi * ring / rings;
            const double turn = 2 * pi * k / sectors;
            add_vertex(made, center[0] + radius * sin(tilt) * cos(turn), center[1] + radius * sin(tilt) * sin(turn),
                       center[2] - radius * cos(tilt));
        }
    }
    const uint32_t top = add_vertex(made, center[0], center[1], center[2] + radius);
    const uint32_t last = top - sectors;
    for (unsigned k = 0; k < sectors; ++k) {
        const unsigned next = (k + 1) % sectors;
        add_triangle(made, bottom, first + next, first + k);
        add_triangle(made, top, last + k, last + next);
        for (unsigned ring = 1; ring + 1 < rings; ++ring) {
            const uint32_t low = first + (ring - 1) * sectors;
            add_triangle(made, low + k, low + next, low + sectors + next);
            add_triangle(made, low + k, low + sectors + next, low + sectors + k);
        }
    }
}
