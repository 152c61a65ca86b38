/* SPDX-License-Identifier: MIT */
/* Cuts a mesh into a static one and an object. */
#include "bench/moving_scene.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Leaves out vertices before and after those of the object. */
static bool cut_vertices(const svo_mesh *mesh, moving_scene *scene)
{
    const size_t corners = scene->object.triangle_count * 3;
    const uint32_t *from = scene->object.indices;
    uint32_t first = UINT32_MAX;
    uint32_t last = 0;
    scene->indices = malloc((corners + 1) * sizeof *scene->indices);
    for (size_t i = 0; i < corners; ++i) {
        first = from[i] < first ? from[i] : first;
        last = from[i] > last ? from[i] : last;
    }
    for (size_t i = 0; i < corners && scene->indices != NULL; ++i) {
        scene->indices[i] = from[i] - first;
    }
    svo_mesh *object = &scene->object;
    object->indices = scene->indices;
    object->vertex_count = last - first + 1;
    object->positions = mesh->positions != NULL ? mesh->positions + (size_t)first * 3 : NULL;
    object->positions_double = mesh->positions_double != NULL ? mesh->positions_double + (size_t)first * 3 : NULL;
    object->normals = mesh->normals != NULL ? mesh->normals + (size_t)first * 3 : NULL;
    object->colors = mesh->colors != NULL ? mesh->colors + (size_t)first * 4 : NULL;
    object->uvs = mesh->uvs != NULL ? mesh->uvs + (size_t)first * 2 : NULL;
    return scene->indices != NULL;
}

static double coordinate(const svo_mesh *mesh, size_t vertex, int axis)
{
    const size_t at = vertex * 3 + (size_t)axis;
    return mesh->positions_double != NULL ? mesh->positions_double[at] : (double)mesh->positions[at];
}

static double area_of(const svo_mesh *mesh, size_t triangle)
{
    const uint32_t *corners = mesh->indices + triangle * 3;
    double squares = 0.0;
    for (int k = 0; k < 3; ++k) {
        double edges[2][2];
        for (int corner = 0; corner < 2; ++corner) {
            for (int axis = 0; axis < 2; ++axis) {
                const int at = (k + axis) % 3;
                edges[corner][axis] = coordinate(mesh, corners[corner + 1], at) - coordinate(mesh, corners[0], at);
            }
        }
        const double normal = edges[0][0] * edges[1][1] - edges[0][1] * edges[1][0];
        squares += normal * normal;
    }
    return 0.5 * sqrt(squares);
}

/* How many of the last triangles have a share of the area. */
static size_t count_moved(const svo_mesh *mesh, double share)
{
    const size_t triangles = mesh->triangle_count;
    double total = 0.0;
    double moved = 0.0;
    size_t count = 0;
    for (size_t t = 0; t < triangles; ++t) {
        total += area_of(mesh, t);
    }
    while (count + 1 < triangles && (count == 0 || moved < share * total)) {
        moved += area_of(mesh, triangles - ++count);
    }
    return count;
}

/* Cuts the mesh, which has indices, in two. */
static bool cut(const svo_mesh *mesh, double share, moving_scene *scene)
{
    const size_t triangles = mesh->triangle_count;
    const size_t moved = count_moved(mesh, share);
    scene->fixed = *mesh;
    scene->fixed.triangle_count = triangles - moved;
    scene->object = *mesh;
    scene->object.triangle_count = moved;
    scene->object.indices = mesh->indices + (triangles - moved) * 3;
    if (mesh->triangle_materials != NULL) {
        scene->object.triangle_materials = mesh->triangle_materials + (triangles - moved);
    }
    return cut_vertices(mesh, scene);
}

/* A cube around the mesh with some room. */
static void choose_grid(const svo_mesh *mesh, svo_moving_options *to)
{
    double low[3] = {INFINITY, INFINITY, INFINITY};
    double high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < mesh->vertex_count * 3; ++i) {
        const double x = coordinate(mesh, i / 3, (int)(i % 3));
        low[i % 3] = fmin(low[i % 3], x);
        high[i % 3] = fmax(high[i % 3], x);
    }
    to->edge = 1.02 * fmax(high[0] - low[0], fmax(high[1] - low[1], high[2] - low[2]));
    for (int k = 0; k < 3; ++k) {
        to->origin[k] = low[k] - 0.01 * to->edge;
    }
}

bool moving_scene_cut(const svo_mesh *mesh, double share, unsigned depth, moving_scene *scene)
{
    *scene = (moving_scene){.options = SVO_MOVING_OPTIONS_INIT};
    choose_grid(mesh, &scene->options);
    scene->options.max_area = 1e3 * scene->options.edge * scene->options.edge;
    scene->step = 0.5 * scene->options.edge / (double)(1u << depth);
    return cut(mesh, share, scene);
}

bool moving_scene_open(svo_device *device, unsigned depth, cl_command_queue queue, moving_scene *scene)
{
    uint32_t object = 0;
    return svo_moving_create(device, &scene->fixed, depth, &scene->options, queue, &scene->moving) == SVO_OK &&
           svo_moving_add(scene->moving, &scene->object, NULL, &object) == SVO_OK;
}

bool moving_scene_update(moving_scene *scene, size_t round, svo_moving_report *report)
{
    const double shift = round % 2 != 0 ? scene->step : 0.0;
    const double transform[12] = {1, 0, 0, shift, 0, 1, 0, shift, 0, 0, 1, shift};
    return svo_moving_set_transform(scene->moving, 0, transform) == SVO_OK &&
           svo_moving_update(scene->moving, NULL, report) == SVO_OK;
}

bool moving_scene_build(const moving_scene *scene, svo_device *device, svo_frontend *frontend, unsigned depth,
                        cl_command_queue queue, svo_tree **tree)
{
    svo_mesh mesh;
    svo_moving_info info = SVO_MOVING_INFO_INIT;
    svo_plan *plan = NULL;
    if (svo_moving_get_info(scene->moving, &info) != SVO_OK || svo_moving_get_mesh(scene->moving, &mesh) != SVO_OK) {
        return false;
    }
    svo_plan_options pinned = {
        .struct_size = sizeof pinned, .need = info.need, .edge = scene->options.edge, .weight_log2 = info.weight_log2};
    memcpy(pinned.origin, scene->options.origin, sizeof pinned.origin);
    const bool is_built = svo_plan_create(device, &mesh, depth, &pinned, &plan) == SVO_OK &&
                          svo_build(plan, frontend, queue, tree, NULL) == SVO_OK;
    svo_plan_destroy(&plan);
    return is_built;
}

void moving_scene_release(moving_scene *scene)
{
    svo_moving_destroy(&scene->moving);
    free(scene->indices);
    scene->indices = NULL;
}
