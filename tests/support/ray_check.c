/* SPDX-License-Identifier: MIT */
/* Builds trees for rays and compares hits with the reference, which tests every triangle. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "meshes.h"
#include "ray_check.h"

oracle_ray_scene ray_scene_of(const built *tree)
{
    return (oracle_ray_scene){.positions = tree->arrays.positions,
                              .positions_double = tree->arrays.positions_double,
                              .vertices = tree->arrays.vertices,
                              .indices = tree->arrays.indices,
                              .triangle_count = (size_t)tree->info.list_triangle_count,
                              .origin = {tree->info.origin[0], tree->info.origin[1], tree->info.origin[2]},
                              .scale = tree->info.scale};
}

void build_for_rays(const fixture *opened, const svo_mesh *mesh, unsigned depth, const double origin[3], double edge,
                    built *out)
{
    svo_plan_options options = {.need = SVO_NEED_RAYS, .edge = edge};
    for (int axis = 0; axis < 3 && edge > 0; ++axis) {
        options.origin[axis] = origin[axis];
    }
    fixture_build(opened, mesh, depth, &options, out);
}

void trace_rays(const fixture *opened, const built *tree, const svo_ray *rays, size_t ray_count, uint32_t flags,
                svo_hit *hits)
{
    memset(hits, 0x5a, ray_count * sizeof *hits);
    if (svo_trace_triangles(svo_tree_target(tree->tree), svo_in_host(rays), svo_in_host(hits), ray_count, flags,
                            &(svo_submit){.queue = opened->queue}) != SVO_OK) {
        fail_msg("%s", svo_device_message(opened->device));
    }
}

oracle_ray widen_ray(const svo_ray *ray)
{
    oracle_ray wide = {.t_min = (double)ray->t_min, .t_max = (double)ray->t_max};
    for (int axis = 0; axis < 3; ++axis) {
        wide.origin[axis] = (double)ray->origin[axis];
        wide.direction[axis] = (double)ray->direction[axis];
    }
    return wide;
}

bool is_tied(double a, double b)
{
    return fabs(a - b) <= 0x1p-23 * fmin(fabs(a), fabs(b));
}

static bool is_closest(const built *tree, const svo_ray *ray, const svo_hit *hit, oracle_ray_hit *exact)
{
    const oracle_ray_scene mesh = ray_scene_of(tree);
    const oracle_ray wide = widen_ray(ray);
    *exact = oracle_ray_closest(&mesh, &wide);
    if (!exact->hit || hit->triangle == SVO_NO_TRIANGLE) {
        return !exact->hit && hit->triangle == SVO_NO_TRIANGLE;
    }
    return is_tied((double)hit->t, exact->t);
}

/* The same triangle as the reference, or another with the same t. In long double, a denormal component cannot be told
   from zero. Next to the edge of a triangle, the hit of a ray that leans slightly more to the same side is accepted. */
void assert_is_closest(const char *what, const built *tree, const svo_ray *ray, const svo_hit *hit)
{
    oracle_ray_hit exact;
    oracle_ray_hit other;
    svo_ray leaning = *ray;
    for (int axis = 0; axis < 3; ++axis) {
        const float component = ray->direction[axis];
        const bool denormal = component != 0.0f && fabsf(component) < 0x1p-126f;
        leaning.direction[axis] = denormal ? copysignf(0x1p-40f, component) : component;
    }
    if (!is_closest(tree, ray, hit, &exact) && !is_closest(tree, &leaning, hit, &other)) {
        fail_msg("%s: from %a %a %a along %a %a %a: triangle %d at %.9g, the reference has %d at %.9g", what,
                 (double)ray->origin[0], (double)ray->origin[1], (double)ray->origin[2], (double)ray->direction[0],
                 (double)ray->direction[1], (double)ray->direction[2], (int)hit->triangle, (double)hit->t,
                 exact.hit ? (int)tree->arrays.triangle_ids[exact.triangle] : -1, exact.t);
    }
}

svo_ray random_ray(uint64_t *random, double spread)
{
    svo_ray ray = {.t_min = 0, .t_max = INFINITY};
    for (int axis = 0; axis < 3; ++axis) {
        ray.origin[axis] = (float)(0.5 + (random_unit(random) - 0.5) * spread);
        ray.direction[axis] = (float)(random_unit(random) - (double)ray.origin[axis]);
    }
    return ray;
}

scene *make_scene(const char *name)
{
    scene *made = NULL;
    svo_message message = {""};
    if (scene_create(name, &made, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return made;
}
