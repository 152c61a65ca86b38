/* SPDX-License-Identifier: MIT */
/* Coherent and incoherent rays for measurements. */
#include "measure/ray_sets.h"

#include <math.h>
#include <stdint.h>

#include "support/query_table.h"

#define SHADOW_OFFSET 1e-4 /* of the distance from the camera */

/* [0, 1), a multiple of 2^-24: Marsaglia, "Xorshift RNGs", 2003. */
static double random_unit(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return (double)(*state >> 40) * 0x1p-24;
}

static void normalize(double vector[3])
{
    const double length = sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
    for (int axis = 0; axis < 3; ++axis) {
        vector[axis] /= length;
    }
}

static svo_ray make_ray(const double origin[3], const double direction[3])
{
    svo_ray ray = {.t_min = 0, .t_max = INFINITY};
    for (int axis = 0; axis < 3; ++axis) {
        ray.origin[axis] = (float)origin[axis];
        ray.direction[axis] = (float)direction[axis];
    }
    return ray;
}

void ray_set_primary(const svo_camera *camera, size_t count, svo_ray *rays)
{
    size_t edge = (size_t)sqrt((double)count);
    edge = edge > 0 ? edge : 1;
    const double tangent = tan(0.5 * (double)camera->vertical_fov);
    const camera_axes axes = ray_table_axes(camera);
    const double eye[3] = {(double)camera->eye[0], (double)camera->eye[1], (double)camera->eye[2]};
    for (size_t i = 0; i < count; ++i) {
        const double across = (2.0 * ((double)(i % edge) + 0.5) / (double)edge - 1.0) * tangent;
        const double down = (2.0 * ((double)(i / edge % edge) + 0.5) / (double)edge - 1.0) * tangent;
        double direction[3];
        for (int axis = 0; axis < 3; ++axis) {
            direction[axis] = axes.forward[axis] + across * axes.right[axis] - down * axes.up[axis];
        }
        normalize(direction);
        rays[i] = make_ray(eye, direction);
    }
}

void ray_set_incoherent(const double low[3], const double high[3], size_t count, svo_ray *rays)
{
    uint64_t state = UINT64_C(0x9e3779b97f4a7c15);
    double radius = 0;
    for (int axis = 0; axis < 3; ++axis) {
        radius += (high[axis] - low[axis]) * (high[axis] - low[axis]);
    }
    radius = radius > 0 ? 0.5 * sqrt(radius) : 1.0; /* a point is met from around it */
    for (size_t i = 0; i < count; ++i) {
        const double height = 2.0 * random_unit(&state) - 1.0;
        const double angle = 6.283185307179586 * random_unit(&state);
        const double ring = sqrt(1.0 - height * height);
        const double on_sphere[3] = {ring * cos(angle), ring * sin(angle), height};
        double origin[3];
        double direction[3];
        for (int axis = 0; axis < 3; ++axis) {
            origin[axis] = 0.5 * (low[axis] + high[axis]) + radius * on_sphere[axis];
            direction[axis] = low[axis] + (high[axis] - low[axis]) * random_unit(&state) - origin[axis];
        }
        normalize(direction);
        rays[i] = make_ray(origin, direction);
    }
}

void ray_set_misses(const double low[3], const double high[3], size_t count, svo_ray *rays)
{
    ray_set_incoherent(low, high, count, rays);
    for (size_t i = 0; i < count; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            rays[i].direction[axis] = -rays[i].direction[axis];
        }
    }
}

bool ray_set_shadow(const svo_camera *camera, const svo_ray *primary, const svo_hit *hits, size_t count, svo_ray *rays)
{
    const camera_axes axes = ray_table_axes(camera);
    double sun[3];
    size_t hit_count = 0;
    for (int axis = 0; axis < 3; ++axis) {
        sun[axis] = 2.0 * axes.up[axis] + axes.right[axis] - axes.forward[axis];
    }
    normalize(sun);
    for (size_t i = 0; i < count; ++i) {
        hit_count += hits[i].triangle != SVO_NO_TRIANGLE;
    }
    for (size_t made = 0, i = 0; made < count && hit_count > 0; i = i + 1 < count ? i + 1 : 0) {
        if (hits[i].triangle != SVO_NO_TRIANGLE) {
            const double t = (double)hits[i].t * (1.0 - SHADOW_OFFSET); /* outside of the surface */
            double origin[3];
            for (int axis = 0; axis < 3; ++axis) {
                origin[axis] = (double)primary[i].origin[axis] + t * (double)primary[i].direction[axis];
            }
            rays[made++] = make_ray(origin, sun);
        }
    }
    return hit_count > 0;
}
