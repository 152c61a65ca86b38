/* SPDX-License-Identifier: MIT */
/* Systematic sampling of the summed area, then uniform inside the triangle (Turk, "Generating Random Points in
   Triangles", Graphics Gems, 1990). */
#include "path/surface_points.h"

#include <math.h>
#include <stdlib.h>

#include "scenes/maths.h"

typedef struct corners {
    vector3 at[3];
} corners;

static vector3 position_of(const svo_mesh *mesh, size_t vertex)
{
    if (mesh->positions == NULL) {
        const double *own = mesh->positions_double + 3 * vertex;
        return vector(own[0], own[1], own[2]);
    }
    const float *own = mesh->positions + 3 * vertex;
    return vector((double)own[0], (double)own[1], (double)own[2]);
}

/* False for a triangle with an index out of range. */
static bool read_corners(const svo_mesh *mesh, size_t triangle, corners *out)
{
    for (size_t corner = 0; corner < 3; ++corner) {
        const size_t place = 3 * triangle + corner;
        const size_t vertex = mesh->indices != NULL ? mesh->indices[place] : place;
        if (vertex >= mesh->vertex_count) {
            return false;
        }
        out->at[corner] = position_of(mesh, vertex);
    }
    return true;
}

/* Twice the area times the unit normal. */
static vector3 cross_edges(const corners *of)
{
    return vector_cross(vector_subtract(of->at[1], of->at[0]), vector_subtract(of->at[2], of->at[0]));
}

/* Twice the area of the triangles up to each one. A refused triangle has none. */
static void sum_areas(const svo_mesh *mesh, double *sums)
{
    double sum = 0;
    for (size_t triangle = 0; triangle < mesh->triangle_count; ++triangle) {
        corners of;
        const double doubled_area = read_corners(mesh, triangle, &of) ? vector_length(cross_edges(&of)) : 0;
        sum += isfinite(doubled_area) ? doubled_area : 0;
        sums[triangle] = sum;
    }
}

/* The first triangle whose sum is above a value. */
static size_t find_triangle(const double *sums, size_t count, double value)
{
    size_t low = 0;
    size_t high = count - 1;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (sums[middle] > value) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    return low;
}

static void place_point(const corners *of, double first, double second, svo_gather_point *point)
{
    const double root = sqrt(first);
    const vector3 normal = vector_normalize(cross_edges(of));
    const vector3 edge_point = vector_mix(of->at[1], of->at[2], second);
    const vector3 position = vector_mix(of->at[0], edge_point, root);
    *point = (svo_gather_point){.position = {(float)position.x, (float)position.y, (float)position.z},
                                .normal = {(float)normal.x, (float)normal.y, (float)normal.z}};
}

bool surface_points(const svo_mesh *mesh, size_t point_count, uint32_t seed, svo_gather_point *points)
{
    random_stream stream = {.state = seed};
    double *sums = mesh->triangle_count > 0 ? malloc(mesh->triangle_count * sizeof *sums) : NULL;
    if (sums == NULL) {
        return false;
    }
    sum_areas(mesh, sums);
    const double whole = sums[mesh->triangle_count - 1];
    for (size_t i = 0; i < point_count && whole > 0; ++i) {
        corners of;
        const double part = ((double)i + random_between(&stream, 0, 1)) / (double)point_count;
        const size_t triangle = find_triangle(sums, mesh->triangle_count, part * whole);
        const double first = random_between(&stream, 0, 1);
        const double second = random_between(&stream, 0, 1);
        if (read_corners(mesh, triangle, &of)) {
            place_point(&of, first, second, &points[i]);
        }
    }
    free(sums);
    return whole > 0;
}
