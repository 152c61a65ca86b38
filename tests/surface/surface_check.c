/* SPDX-License-Identifier: MIT */
#include "surface_check.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* A side of a triangle, in its direction. */
typedef struct side {
    uint32_t from, to, third;
} side;

static int compare_sides(const void *a, const void *b)
{
    const side *left = a;
    const side *right = b;
    return left->from != right->from ? (left->from > right->from) - (left->from < right->from)
                                     : (left->to > right->to) - (left->to < right->to);
}

static const side *find_side(const side *sides, size_t count, uint32_t from, uint32_t to)
{
    const side wanted = {from, to, 0};
    return bsearch(&wanted, sides, count, sizeof wanted, compare_sides);
}

static side *list_sides(const svo_mesh *mesh)
{
    side *sides = malloc(3 * mesh->triangle_count * sizeof *sides + 1);
    assert_non_null(sides);
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        const uint32_t *corners = mesh->indices + i / 3 * 3;
        sides[i] = (side){corners[i % 3], corners[(i + 1) % 3], corners[(i + 2) % 3]};
        assert_true(sides[i].from < mesh->vertex_count && sides[i].from != sides[i].to);
    }
    qsort(sides, 3 * mesh->triangle_count, sizeof *sides, compare_sides);
    return sides;
}

static void check_edges(const side *sides, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        if (i > 0 && compare_sides(&sides[i - 1], &sides[i]) == 0) {
            fail_msg("two triangles pass from vertex %u to %u", sides[i].from, sides[i].to);
        }
        if (find_side(sides, count, sides[i].to, sides[i].from) == NULL) {
            fail_msg("no triangle passes from vertex %u to %u", sides[i].to, sides[i].from);
        }
    }
}

/* The triangles around each vertex, from one to the next. */
static void check_rings(const side *sides, size_t count, size_t vertex_count)
{
    size_t vertices = 0;
    for (size_t first = 0, end = 0; first < count; first = end, ++vertices) {
        size_t steps = 0;
        const uint32_t vertex = sides[first].from;
        for (end = first; end < count && sides[end].from == vertex; ++end) {
        }
        const side *at = &sides[first];
        do {
            at = find_side(sides, count, vertex, at->third);
            assert_non_null(at);
            ++steps;
        } while (at != &sides[first] && steps < count);
        if (steps != end - first) {
            fail_msg("vertex %u has %zu triangles, of which %zu are around it", vertex, end - first, steps);
        }
    }
    assert_int_equal(vertices, vertex_count);
}

/* Bits of coordinates. */
typedef struct vertex_place {
    uint32_t at[3];
} vertex_place;

static int compare_places(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(vertex_place));
}

static void check_places(const svo_mesh *mesh)
{
    vertex_place *places = malloc(mesh->vertex_count * sizeof *places + 1);
    assert_non_null(places);
    memcpy(places, mesh->positions, mesh->vertex_count * sizeof *places);
    qsort(places, mesh->vertex_count, sizeof *places, compare_places);
    for (size_t i = 1; i < mesh->vertex_count; ++i) {
        if (compare_places(&places[i - 1], &places[i]) == 0) {
            float at[3];
            memcpy(at, places[i].at, sizeof at);
            fail_msg("two vertices are at %.9g, %.9g, %.9g", (double)at[0], (double)at[1], (double)at[2]);
        }
    }
    free(places);
}

static double find_volume(const svo_mesh *mesh)
{
    double volume = 0.0;
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        double at[3][3];
        for (size_t corner = 0; corner < 3; ++corner) {
            for (size_t axis = 0; axis < 3; ++axis) {
                /* From a vertex on, so that little is lost. */
                at[corner][axis] = (double)mesh->positions[3 * (size_t)mesh->indices[3 * t + corner] + axis] -
                                   (double)mesh->positions[axis];
            }
        }
        volume += (at[0][0] * (at[1][1] * at[2][2] - at[1][2] * at[2][1]) +
                   at[0][1] * (at[1][2] * at[2][0] - at[1][0] * at[2][2]) +
                   at[0][2] * (at[1][0] * at[2][1] - at[1][1] * at[2][0])) /
                  6.0;
    }
    return volume;
}

surface_measures surface_check(const svo_surface *surface)
{
    const svo_mesh *mesh = svo_surface_get_mesh(surface);
    svo_surface_info info = SVO_SURFACE_INFO_INIT;
    assert_int_equal(svo_surface_get_info(surface, &info), SVO_OK);
    assert_int_equal(info.vertex_count, mesh->vertex_count);
    assert_int_equal(info.triangle_count, mesh->triangle_count);
    if (mesh->triangle_count == 0) {
        assert_int_equal(mesh->vertex_count, 0);
        return (surface_measures){.euler = 0};
    }
    side *sides = list_sides(mesh);
    check_edges(sides, 3 * mesh->triangle_count);
    check_rings(sides, 3 * mesh->triangle_count, mesh->vertex_count);
    check_places(mesh);
    free(sides);
    return (surface_measures){.euler = (long)mesh->vertex_count - (long)mesh->triangle_count / 2,
                              .volume = find_volume(mesh)};
}

static void compare_arrays(const void *a, const void *b, size_t bytes)
{
    assert_int_equal(a == NULL, b == NULL);
    if (a != NULL) {
        assert_memory_equal(a, b, bytes);
    }
}

void surface_compare(const svo_surface *a, const svo_surface *b)
{
    const svo_mesh *left = svo_surface_get_mesh(a);
    const svo_mesh *right = svo_surface_get_mesh(b);
    assert_int_equal(left->vertex_count, right->vertex_count);
    assert_int_equal(left->triangle_count, right->triangle_count);
    compare_arrays(left->positions, right->positions, left->vertex_count * 3 * sizeof(float));
    compare_arrays(left->indices, right->indices, left->triangle_count * 3 * sizeof(uint32_t));
    compare_arrays(left->normals, right->normals, left->vertex_count * 3 * sizeof(float));
    compare_arrays(left->colors, right->colors, left->vertex_count * 4);
}

svo_surface *surface_make(const svo_surface_field *field, const svo_surface_options *options)
{
    svo_surface *made = NULL;
    svo_message message = {""};
    if (svo_surface_create(field, options, &made, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return made;
}
