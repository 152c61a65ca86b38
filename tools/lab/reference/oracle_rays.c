/* SPDX-License-Identifier: MIT */
/* Rays and points against every triangle of a mesh. */
#include "oracle_rays.h"

#include <math.h>

typedef struct vector {
    long double x, y, z;
} vector;

static vector subtract(vector a, vector b)
{
    return (vector){a.x - b.x, a.y - b.y, a.z - b.z};
}

static vector along(vector a, long double scale, vector b)
{
    return (vector){a.x + scale * b.x, a.y + scale * b.y, a.z + scale * b.z};
}

static vector cross(vector a, vector b)
{
    return (vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static long double dot(vector a, vector b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static bool is_snapped(const oracle_ray_scene *scene)
{
    return scene->positions == NULL && scene->positions_double == NULL;
}

/* Units of the vertices per world unit. */
static long double scale_of(const oracle_ray_scene *scene)
{
    return is_snapped(scene) ? scene->scale : 1;
}

/* A world position in the units of the vertices. */
static vector to_units(const oracle_ray_scene *scene, const double position[3])
{
    const vector world = {position[0], position[1], position[2]};
    return is_snapped(scene)
               ? (vector){(world.x - scene->origin[0]) * scene->scale, (world.y - scene->origin[1]) * scene->scale,
                          (world.z - scene->origin[2]) * scene->scale}
               : world;
}

static vector corner_of(const oracle_ray_scene *scene, size_t triangle, size_t corner)
{
    const size_t at = (size_t)scene->indices[3 * triangle + corner] * 3;
    if (scene->positions != NULL) {
        const float *vertex = scene->positions + at;
        return (vector){vertex[0], vertex[1], vertex[2]};
    }
    if (scene->positions_double != NULL) {
        const double *vertex = scene->positions_double + at;
        return (vector){vertex[0], vertex[1], vertex[2]};
    }
    const int32_t *vertex = scene->vertices + at;
    return (vector){vertex[0], vertex[1], vertex[2]};
}

long double oracle_ray_plane(const oracle_ray_scene *scene, size_t triangle, const oracle_ray *ray)
{
    const vector direction = {ray->direction[0], ray->direction[1], ray->direction[2]};
    const vector a = subtract(corner_of(scene, triangle, 0), to_units(scene, ray->origin));
    const vector b = subtract(corner_of(scene, triangle, 1), to_units(scene, ray->origin));
    const vector c = subtract(corner_of(scene, triangle, 2), to_units(scene, ray->origin));
    const vector normal = cross(subtract(b, a), subtract(c, a));
    const long double towards = dot(normal, direction);
    return towards != 0 ? dot(normal, a) / towards / scale_of(scene) : HUGE_VALL;
}

bool oracle_ray_meets(const oracle_ray_scene *scene, size_t triangle, const oracle_ray *ray, double *t)
{
    const vector start = to_units(scene, ray->origin);
    const vector direction = {ray->direction[0], ray->direction[1], ray->direction[2]};
    const vector a = subtract(corner_of(scene, triangle, 0), start);
    const vector b = subtract(corner_of(scene, triangle, 1), start);
    const vector c = subtract(corner_of(scene, triangle, 2), start);
    const long double u = dot(direction, cross(c, b));
    const long double v = dot(direction, cross(a, c));
    const long double w = dot(direction, cross(b, a));
    if (!((u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0))) {
        return false;
    }
    const double found = (double)oracle_ray_plane(scene, triangle, ray);
    if (isinf(found) || !(found >= ray->t_min && found <= ray->t_max)) {
        return false;
    }
    *t = found;
    return true;
}

oracle_ray_hit oracle_ray_closest(const oracle_ray_scene *scene, const oracle_ray *ray)
{
    oracle_ray_hit best = {.hit = false};
    for (size_t triangle = 0; triangle < scene->triangle_count; ++triangle) {
        double t = 0;
        if (oracle_ray_meets(scene, triangle, ray, &t) && (!best.hit || t < best.t)) {
            best = (oracle_ray_hit){.hit = true, .t = t, .triangle = triangle};
        }
    }
    return best;
}

size_t oracle_ray_count(const oracle_ray_scene *scene, const oracle_ray *ray)
{
    size_t count = 0;
    for (size_t triangle = 0; triangle < scene->triangle_count; ++triangle) {
        double t = 0;
        count += oracle_ray_meets(scene, triangle, ray, &t);
    }
    return count;
}

/* Squared distance from p to the segment from a to b. */
static long double segment_distance(vector p, vector a, vector b)
{
    const vector edge = subtract(b, a);
    const long double length = dot(edge, edge);
    long double share = length > 0 ? dot(subtract(p, a), edge) / length : 0;
    share = share < 0 ? 0 : share > 1 ? 1 : share;
    const vector offset = subtract(p, along(a, share, edge));
    return dot(offset, offset);
}

/* Inside the prism over the triangle the plane is nearest, outside of it one of the edges is. */
double oracle_triangle_distance(const oracle_ray_scene *scene, size_t triangle, const double point[3])
{
    const vector p = to_units(scene, point);
    const vector a = corner_of(scene, triangle, 0);
    const vector b = corner_of(scene, triangle, 1);
    const vector c = corner_of(scene, triangle, 2);
    const vector normal = cross(subtract(b, a), subtract(c, a));
    const long double area = dot(normal, normal);
    const bool above = area > 0 && dot(cross(subtract(b, a), subtract(p, a)), normal) >= 0 &&
                       dot(cross(subtract(c, b), subtract(p, b)), normal) >= 0 &&
                       dot(cross(subtract(a, c), subtract(p, c)), normal) >= 0;
    if (above) {
        return (double)(fabsl(dot(subtract(p, a), normal)) / sqrtl(area) / scale_of(scene));
    }
    long double least = segment_distance(p, a, b);
    least = fminl(least, segment_distance(p, b, c));
    least = fminl(least, segment_distance(p, c, a));
    return (double)(sqrtl(least) / scale_of(scene));
}

double oracle_nearest(const oracle_ray_scene *scene, const double point[3], size_t *triangle)
{
    double best = HUGE_VAL;
    for (size_t i = 0; i < scene->triangle_count; ++i) {
        const double distance = oracle_triangle_distance(scene, i, point);
        if (distance < best) {
            best = distance;
            *triangle = i;
        }
    }
    return best;
}

bool oracle_ray_touches(const oracle_ray_scene *scene, size_t triangle, const oracle_ray *ray)
{
    const double t = (double)oracle_ray_plane(scene, triangle, ray);
    double point[3];
    double largest = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        point[axis] = ray->origin[axis] + t * ray->direction[axis];
        largest = fmax(largest, fmax(fabs(point[axis]), fabs(ray->origin[axis])));
    }
    return isfinite(t) && oracle_triangle_distance(scene, triangle, point) <= largest * 0x1p-48;
}
