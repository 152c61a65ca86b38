/* SPDX-License-Identifier: MIT */
/* Picking: the click at a pixel of a 640 x 480 picture becomes a ray, the ray a triangle, the triangle an object. */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#include "svocl/svocl.h"

#define WIDTH  640
#define HEIGHT 480

/* Two octahedra of eight triangles each, one above the other: object 0 and object 1. */
static const float positions[] = {1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1,
                                  1, 2, 0, -1, 2, 0, 0, 3, 0, 0, 1,  0, 0, 2, 1, 0, 2, -1};
static const uint32_t octahedron[24] = {0, 2, 4, 2, 1, 4, 3, 0, 4, 1, 3, 4, 2, 0, 5, 1, 2, 5, 0, 3, 5, 3, 1, 5};
#define OBJECT_TRIANGLES 8u

/* A camera at (0, 0, 3) that looks along -z; pixels count from the upper left corner. */
static svo_ray ray_of_click(double x, double y)
{
    const double tangent = tan(0.5 * 1.0);
    svo_ray ray = {.origin = {0, 0, 3}, .direction = {0, 0, -1}, .t_min = 0, .t_max = INFINITY};
    ray.direction[0] = (float)((2 * (x + 0.5) / WIDTH - 1) * tangent * WIDTH / HEIGHT);
    ray.direction[1] = (float)((1 - 2 * (y + 0.5) / HEIGHT) * tangent);
    return ray;
}

static void report(const char *x, const char *y, const svo_ray *ray, const svo_hit *hit)
{
    if (hit->triangle == SVO_NO_TRIANGLE) {
        printf("%s, %s: nothing\n", x, y);
        return;
    }
    double point[3];
    double squared = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double moved = (double)hit->t * (double)ray->direction[axis];
        point[axis] = (double)ray->origin[axis] + moved;
        squared += moved * moved;
    }
    printf("%s, %s: object %u, triangle %u at %.3f, %.3f, %.3f, seen from %.3f away\n", x, y,
           hit->triangle / OBJECT_TRIANGLES, hit->triangle % OBJECT_TRIANGLES, point[0], point[1], point[2],
           sqrt(squared));
}

int main(int argument_count, char **arguments)
{
    if (argument_count != 3) {
        fprintf(stderr, "usage: %s X Y\n", arguments[0]);
        return 2;
    }
    uint32_t indices[2 * 24];
    for (uint32_t i = 0; i < 2 * 24; ++i) {
        indices[i] = octahedron[i % 24] + i / 24 * 6;
    }
    const svo_mesh mesh = {.struct_size = sizeof(svo_mesh),
                           .positions = positions,
                           .vertex_count = 12,
                           .indices = indices,
                           .triangle_count = (size_t)2 * OBJECT_TRIANGLES};
    const svo_plan_options options = {.struct_size = sizeof options, .need = SVO_NEED_RAYS};
    const svo_ray ray = ray_of_click(strtod(arguments[1], NULL), strtod(arguments[2], NULL));
    svo_message message = {""};
    svo_device *device = NULL;
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    svo_hit hit;

    bool done = svo_device_create_default(NULL, &device, &message) == SVO_OK;
    /* A tool keeps the tree and traces one ray per click; no ray passes between adjacent triangles. */
    done = done && svo_plan_create(device, &mesh, 4, &options, &plan) == SVO_OK &&
           svo_build(plan, NULL, NULL, &tree, NULL) == SVO_OK &&
           svo_trace_triangles(svo_tree_target(tree), svo_in_host(&ray), svo_in_host(&hit), 1, SVO_TRACE_CLOSEST,
                               NULL) == SVO_OK;
    if (done)
        report(arguments[1], arguments[2], &ray, &hit);
    else
        fprintf(stderr, "%s\n", device == NULL || message.text[0] != '\0' ? message.text : svo_device_message(device));

    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    svo_device_destroy(&device);
    return done ? 0 : 1;
}
