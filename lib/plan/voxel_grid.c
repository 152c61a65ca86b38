/* SPDX-License-Identifier: MIT */
/* The grid with voxels of a given width around a mesh, for callers of svo_plan_create. */
#include <math.h>

#include "core/message.h"
#include "core/struct_size.h"
#include "core/voxel_list.h"
#include "plan/grid.h"
#include "svocl/plan.h"

static const char function[] = "svo_mesh_voxel_grid";

/* Grows the bounds by a triangle that builds accept. */
static void add_triangle(const svo_mesh *mesh, size_t triangle, svo_i_bounds *bounds)
{
    double corners[3][3];
    for (size_t corner = 0; corner < 3; ++corner) {
        const size_t place = 3 * triangle + corner;
        const size_t vertex = mesh->indices != NULL ? mesh->indices[place] : place;
        if (vertex >= mesh->vertex_count) {
            return;
        }
        for (unsigned axis = 0; axis < 3; ++axis) {
            corners[corner][axis] = svo_i_mesh_coordinate(mesh, vertex, axis);
            if (!isfinite(corners[corner][axis])) {
                return;
            }
        }
    }
    bounds->any = true;
    for (int i = 0; i < 9; ++i) {
        bounds->low[i % 3] = fmin(bounds->low[i % 3], corners[i / 3][i % 3]);
        bounds->high[i % 3] = fmax(bounds->high[i % 3], corners[i / 3][i % 3]);
    }
}

/* Voxels from the origin to the one that holds the far end, which has its near faces. */
static double count_voxels(double origin, double high, double width)
{
    double count = floor((high - origin) / width) + 1.0;
    if (fma(count, width, origin) <= high) {
        count += 1.0;
    }
    return count;
}

/* Checks what is given, and copies the mesh as far as the caller's struct reaches. */
static svo_status check(const svo_mesh *mesh, double voxel_edge, svo_mesh *given, svo_message *message)
{
    if (!(voxel_edge > 0.0) || !isfinite(ldexp(voxel_edge, SVO_DEPTH_MAX))) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: voxel_edge %g is not above 0, or too large", function,
                          voxel_edge);
    }
    SVO_I_TRY(svo_i_struct_read(message, function, "mesh", mesh, given, SVO_I_STRUCT_SIZES(svo_mesh, texture_count)));
    return given->vertex_count > 0 && given->positions == NULL && given->positions_double == NULL
               ? svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: the mesh has no positions", function)
               : SVO_OK;
}

/* Places the grid along an axis; *levels grows to what its voxels need. */
static svo_status place_axis(const svo_i_bounds *bounds, unsigned axis, double voxel_edge, double *origin,
                             unsigned *levels, svo_message *message)
{
    const double voxels_max = ldexp(1.0, SVO_DEPTH_MAX);
    *origin = svo_i_voxel_plane(bounds->low[axis], voxel_edge);
    if (isnan(*origin)) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: voxel_edge %g is too small for vertices at %c = %g",
                          function, voxel_edge, "xyz"[axis], bounds -> low[axis]);
    }
    const double count = count_voxels(*origin, bounds->high[axis], voxel_edge);
    if (!(count <= voxels_max)) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT,
                          "%s: voxel_edge %g makes %.0f voxels along %c, above the limit of %.0f (depth %d)", function,
                          voxel_edge, count, "xyz"[axis], voxels_max, SVO_DEPTH_MAX);
    }
    while (ldexp(1.0, (int)*levels) < count) {
        ++*levels;
    }
    return SVO_OK;
}

svo_status svo_mesh_voxel_grid(const svo_mesh *mesh, double voxel_edge, double origin[3], double *edge, unsigned *depth,
                               svo_message *message)
{
    svo_mesh given = SVO_MESH_INIT;
    svo_i_bounds bounds = {false, {INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    double place[3] = {0.0, 0.0, 0.0};
    unsigned levels = SVO_DEPTH_MIN;
    const char *missing = mesh == NULL     ? "mesh"
                          : origin == NULL ? "origin"
                          : edge == NULL   ? "edge"
                          : depth == NULL  ? "depth"
                                           : NULL;
    if (missing != NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function, missing);
    }
    SVO_I_TRY(check(mesh, voxel_edge, &given, message));
    for (size_t triangle = 0; triangle < given.triangle_count; ++triangle) {
        add_triangle(&given, triangle, &bounds);
    }
    for (unsigned axis = 0; axis < 3 && bounds.any; ++axis) {
        SVO_I_TRY(place_axis(&bounds, axis, voxel_edge, &place[axis], &levels, message));
    }
    for (unsigned axis = 0; axis < 3; ++axis) {
        origin[axis] = place[axis];
    }
    *edge = ldexp(voxel_edge, (int)levels);
    *depth = levels;
    return SVO_OK;
}
