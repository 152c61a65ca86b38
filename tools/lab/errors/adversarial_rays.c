/* SPDX-License-Identifier: MIT */
/* Targets lie at eighths of an edge, and directions are eight times the vector to them: with quantized positions all
   values are integer multiples of the unit that float represents exactly. */
#include "errors/adversarial_rays.h"

#include <math.h>

#include "measure/quantization.h"
#include "measure/ray_sets.h"
#include "scenes/maths.h"

#define EIGHTHS       8.0
#define T_MIN         0x1p-12f /* a surface at the origin does not count */
#define GRAZING_SLOPE 1e-3 /* of the ray against the triangle's plane */

const char *ray_target_name(ray_target target)
{
    static const char *const names[TARGET_COUNT] = {"random", "at vertices", "at edges", "grazing"};
    return names[target];
}

static vector3 vertex_of(const svo_mesh *mesh, size_t index)
{
    return vector(quantization_source(mesh, 3 * index), quantization_source(mesh, 3 * index + 1),
                  quantization_source(mesh, 3 * index + 2));
}

/* [0, 1) */
static double random_fraction(random_stream *random)
{
    return (double)(random_bits(random) >> 40) * 0x1p-24;
}

/* The vertices of a random triangle with an area. */
static void pick_triangle(const svo_mesh *mesh, random_stream *random, vector3 corners[3], vector3 *normal)
{
    for (int attempt = 0; attempt < 1000; ++attempt) {
        const size_t triangle = random_index(random, (uint32_t)mesh->triangle_count);
        for (size_t i = 0; i < 3; ++i) {
            corners[i] = vertex_of(mesh, mesh->indices != NULL ? mesh->indices[3 * triangle + i] : 3 * triangle + i);
        }
        *normal = vector_cross(vector_subtract(corners[1], corners[0]), vector_subtract(corners[2], corners[0]));
        if (vector_length(*normal) > 0.0) {
            break;
        }
    }
    *normal = vector_scale(*normal, 1.0 / fmax(vector_length(*normal), 1e-300));
}

static vector3 point_of(ray_target target, const vector3 corners[3], random_stream *random)
{
    if (target == TARGET_VERTICES) {
        return corners[0];
    }
    const double eighths = 1.0 + floor(7.0 * random_fraction(random));
    const vector3 on_edge = vector_mix(corners[0], corners[1], eighths / EIGHTHS);
    return target == TARGET_EDGES ? on_edge : vector_mix(on_edge, corners[2], 0.1 + 0.8 * random_fraction(random));
}

static double round_to(double value, double unit)
{
    return unit > 0.0 ? unit * rint(value / unit) : value;
}

static svo_ray ray_to(vector3 origin, vector3 target, double unit)
{
    const double from[3] = {origin.x, origin.y, origin.z};
    const double to[3] = {target.x, target.y, target.z};
    svo_ray ray = {.t_min = T_MIN, .t_max = INFINITY};
    for (int k = 0; k < 3; ++k) {
        ray.origin[k] = (float)round_to(from[k], unit);
        ray.direction[k] = (float)round_to(EIGHTHS * (to[k] - (double)ray.origin[k]), unit);
    }
    return ray;
}

static svo_ray adversarial_ray(const svo_mesh *mesh, const adversarial_set *set, double extent, random_stream *random)
{
    vector3 corners[3];
    vector3 normal;
    pick_triangle(mesh, random, corners, &normal);
    const vector3 point = point_of(set->target, corners, random);
    const double distance = extent * (set->reach > 0.0 ? set->reach : 0.02 + 0.3 * random_fraction(random));
    const vector3 sideways =
        vector(random_fraction(random) - 0.5, random_fraction(random) - 0.5, random_fraction(random) - 0.5);
    vector3 away = vector_add(normal, vector_scale(sideways, 0.8));
    if (set->target == TARGET_GRAZING) {
        const vector3 edge = vector_subtract(corners[1], corners[2]);
        away = vector_add(vector_scale(edge, 1.0 / vector_length(edge)), vector_scale(normal, GRAZING_SLOPE));
    }
    return ray_to(vector_add(point, vector_scale(away, distance)), point, set->unit);
}

static void bounds_of(const svo_mesh *mesh, double low[3], double high[3])
{
    for (int k = 0; k < 3; ++k) {
        low[k] = HUGE_VAL;
        high[k] = -HUGE_VAL;
    }
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        const vector3 at = vertex_of(mesh, i);
        const double components[3] = {at.x, at.y, at.z};
        for (int k = 0; k < 3; ++k) {
            low[k] = fmin(low[k], components[k]);
            high[k] = fmax(high[k], components[k]);
        }
    }
}

void adversarial_rays(const svo_mesh *mesh, const adversarial_set *set, size_t count, svo_ray *rays)
{
    random_stream random = {UINT64_C(0x5be0cd19137e2179) + (uint64_t)set->target};
    double low[3];
    double high[3];
    bounds_of(mesh, low, high);
    const double extent = fmax(high[0] - low[0], fmax(high[1] - low[1], high[2] - low[2]));
    if (set->target == TARGET_RANDOM) {
        ray_set_incoherent(low, high, count, rays); /* these rarely hit an edge */
        return;
    }
    for (size_t i = 0; i < count; ++i) {
        rays[i] = adversarial_ray(mesh, set, extent, &random);
    }
}
