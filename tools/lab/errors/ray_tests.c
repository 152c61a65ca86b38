/* SPDX-License-Identifier: MIT */
/* Each test intersects one ray with one triangle. */
#include "errors/ray_tests.h"

#include <math.h>

#include "measure/ray_judge.h"

static const float *corner_of(const float_triangles *from, size_t triangle, size_t corner)
{
    return from->vertices + (size_t)from->indices[3 * triangle + corner] * 3;
}

static void cross(const float a[3], const float b[3], float out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

bool ray_test_moller_trumbore(const void *triangles, size_t triangle, const svo_ray *ray, svo_hit *hit)
{
    const float *a = corner_of(triangles, triangle, 0);
    const float *b = corner_of(triangles, triangle, 1);
    const float *c = corner_of(triangles, triangle, 2);
    float first[3];
    float second[3];
    float start[3];
    for (int k = 0; k < 3; ++k) {
        first[k] = b[k] - a[k];
        second[k] = c[k] - a[k];
        start[k] = ray->origin[k] - a[k];
    }
    float across[3];
    cross(ray->direction, second, across);
    const float determinant = dot(first, across);
    if (determinant == 0.0f) {
        return false;
    }
    const float inverse = 1.0f / determinant;
    const float u = dot(start, across) * inverse;
    if (!(u >= 0.0f && u <= 1.0f)) {
        return false;
    }
    float down[3];
    cross(start, first, down);
    const float v = dot(ray->direction, down) * inverse;
    const float t = dot(second, down) * inverse;
    if (!(v >= 0.0f && u + v <= 1.0f && t >= ray->t_min && t <= hit->t)) {
        return false;
    }
    hit->t = t;
    hit->u = u;
    hit->v = v;
    return true;
}

/* The ray's longest axis last; the order of the others keeps the winding. */
static void order_axes(const svo_ray *ray, int axes[3])
{
    const float *d = ray->direction;
    axes[2] = fabsf(d[0]) > fabsf(d[1]) ? (fabsf(d[0]) > fabsf(d[2]) ? 0 : 2) : (fabsf(d[1]) > fabsf(d[2]) ? 1 : 2);
    axes[0] = (axes[2] + 1) % 3;
    axes[1] = (axes[2] + 2) % 3;
    if (d[axes[2]] < 0.0f) {
        const int kept = axes[0];
        axes[0] = axes[1];
        axes[1] = kept;
    }
}

static float edge_function(const float p[3], const float q[3])
{
    return p[0] * q[1] - p[1] * q[0];
}

static float edge_function_in_double(const float p[3], const float q[3])
{
    return (float)((double)p[0] * (double)q[1] - (double)p[1] * (double)q[0]);
}

bool ray_test_watertight(const void *triangles, size_t triangle, const svo_ray *ray, svo_hit *hit)
{
    int axes[3];
    order_axes(ray, axes);
    const float shear[3] = {ray->direction[axes[0]] / ray->direction[axes[2]],
                            ray->direction[axes[1]] / ray->direction[axes[2]], 1.0f / ray->direction[axes[2]]};
    float at[3][3];
    for (size_t i = 0; i < 3; ++i) {
        const float *corner = corner_of(triangles, triangle, i);
        const float along = corner[axes[2]] - ray->origin[axes[2]];
        at[i][0] = corner[axes[0]] - ray->origin[axes[0]] - shear[0] * along;
        at[i][1] = corner[axes[1]] - ray->origin[axes[1]] - shear[1] * along;
        at[i][2] = shear[2] * along;
    }
    float u = edge_function(at[2], at[1]);
    float v = edge_function(at[0], at[2]);
    float w = edge_function(at[1], at[0]);
    if (u == 0.0f || v == 0.0f || w == 0.0f) {
        u = edge_function_in_double(at[2], at[1]);
        v = edge_function_in_double(at[0], at[2]);
        w = edge_function_in_double(at[1], at[0]);
    }
    const float determinant = u + v + w;
    if (((u < 0.0f || v < 0.0f || w < 0.0f) && (u > 0.0f || v > 0.0f || w > 0.0f)) || determinant == 0.0f) {
        return false;
    }
    const float t = (u * at[0][2] + v * at[1][2] + w * at[2][2]) / determinant;
    if (!(t >= ray->t_min && t <= hit->t)) {
        return false;
    }
    hit->t = t;
    hit->u = v / determinant;
    hit->v = w / determinant;
    return true;
}

bool ray_test_exact(const void *triangles, size_t triangle, const svo_ray *ray, svo_hit *hit)
{
    const exact_triangles *exact = triangles;
    oracle_ray wide = ray_widen(ray);
    const double longest = fmax(fabs(wide.direction[0]), fmax(fabs(wide.direction[1]), fabs(wide.direction[2])));
    double t = 0.0;
    for (int k = 0; k < 3; ++k) {
        wide.direction[k] += longest * exact->perturbation[k];
    }
    if (!oracle_ray_meets(exact->mesh, triangle, &wide, &t) || t > (double)hit->t) {
        return false;
    }
    hit->t = (float)t;
    return true;
}
