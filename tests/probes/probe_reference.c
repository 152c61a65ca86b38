/* SPDX-License-Identifier: MIT */
#include "probe_reference.h"

#include <math.h>
#include <stdlib.h>

#define CROSSINGS_MAX (2 * SVO_PROBES_RESOLUTION_MAX * 4 + 16)
/* Comparisons of lengths, in leaf edges, that are even up to this are close. */
#define EVEN 2e-3L
/* The width of the widest texel, in distances and columns of the map. */
#define LEANING 4.559L

typedef long double real;

typedef struct walk {
    const probe_map *map;
    real origin[3], direction[3]; /* from the probe, leaf edges; unit */
    real t_min;
    real turns[3]; /* ts at which the octant changes */
    bool close;
} walk;

static real dot(const real a[3], const real b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void at(const walk *w, real t, real out[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        out[axis] = w->origin[axis] + t * w->direction[axis];
    }
}

static real radius(const walk *w, real t)
{
    real point[3];
    at(w, t, point);
    return sqrtl(dot(point, point));
}

/* a < b, and whether that is hard to tell. */
static bool is_less(walk *w, real a, real b)
{
    w->close = w->close || fabsl(a - b) < EVEN;
    return a < b;
}

static int compare(const void *a, const void *b)
{
    const real x = *(const real *)a;
    const real y = *(const real *)b;
    return (x > y) - (x < y);
}

/* The point of a direction on the map's square. */
static void map_point(const real v[3], real p[2])
{
    const real sum = fabsl(v[0]) + fabsl(v[1]) + fabsl(v[2]);
    const real x = v[0] / sum;
    const real y = v[1] / sum;
    p[0] = v[2] >= 0 ? x : (1 - fabsl(y)) * (x >= 0 ? 1 : -1);
    p[1] = v[2] >= 0 ? y : (1 - fabsl(x)) * (y >= 0 ? 1 : -1);
}

static void unmap(real x, real y, real v[3])
{
    v[2] = 1 - fabsl(x) - fabsl(y);
    v[0] = v[2] >= 0 ? x : (1 - fabsl(y)) * (x >= 0 ? 1 : -1);
    v[1] = v[2] >= 0 ? y : (1 - fabsl(x)) * (y >= 0 ? 1 : -1);
}

/* Adds the t at which n . (o + t d) = 0. */
static void cross(const walk *w, const real n[3], real *list, size_t *count)
{
    const real along = dot(n, w->direction);
    if (along != 0) {
        list[(*count)++] = -dot(n, w->origin) / along;
    }
}

/* All planes that bound a texel in any octant: of |p| = b, |x| = b L where z is positive, |y| = (1 - b) L elsewhere. */
static size_t cross_all(const walk *w, real *list)
{
    const int half = (int)w->map->info.resolution / 2;
    size_t count = 0;
    for (int axis = 0; axis < 3; ++axis) {
        if (w->direction[axis] != 0) {
            list[count++] = w->turns[axis];
        }
    }
    for (int octant = 0; octant < 8; ++octant) {
        const real sign[3] = {octant & 1 ? -1 : 1, octant & 2 ? -1 : 1, octant & 4 ? -1 : 1};
        for (int i = 1; i < half; ++i) {
            for (int axis = 0; axis < 2; ++axis) {
                const real share = (real)i / half;
                real n[3] = {-share * sign[0], -share * sign[1], -share * sign[2]};
                n[axis] += sign[axis];
                cross(w, n, list, &count);
            }
        }
    }
    return count;
}

typedef struct surface {
    real distance;
    real point[3], normal[3];
    real width, cosine;
} surface;

static bool open_texel(const probe_map *map, int column, int row, surface *out)
{
    const int resolution = (int)map->info.resolution;
    const uint32_t word = map->texels[2 * ((size_t)row * map->info.resolution + (size_t)column)];
    float normal[3];
    real v[3];
    if ((word & 0xffffu) == SVO_PROBE_NOTHING) {
        return false;
    }
    unmap((2.0L * column + 1) / resolution - 1, (2.0L * row + 1) / resolution - 1, v);
    const real length = sqrtl(dot(v, v));
    out->distance = (real)svo_probe_distance(&map->info, word & 0xffffu) / (real)map->info.leaf_edge;
    svo_probe_normal(word, normal);
    for (int axis = 0; axis < 3; ++axis) {
        out->point[axis] = v[axis] / length * out->distance;
        out->normal[axis] = (real)normal[axis];
    }
    out->width = out->distance * 2 / resolution * powl(length, -1.5L);
    out->cosine = fabsl(dot(out->normal, v)) / length;
    return true;
}

/* The column and the row of the ray between two ts. */
static void texel_of(const walk *w, real t, int *column, int *row)
{
    const int resolution = (int)w->map->info.resolution;
    real v[3];
    real p[2];
    at(w, t, v);
    map_point(v, p);
    *column = (int)floorl((p[0] + 1) * resolution / 2);
    *row = (int)floorl((p[1] + 1) * resolution / 2);
    *column = *column < 0 ? 0 : *column >= resolution ? resolution - 1 : *column;
    *row = *row < 0 ? 0 : *row >= resolution ? resolution - 1 : *row;
}

static bool is_joined(walk *w, const surface *one, const int before[2])
{
    surface other;
    real gap[3];
    if (before[0] < 0 || !open_texel(w->map, before[0], before[1], &other)) {
        return false;
    }
    for (int axis = 0; axis < 3; ++axis) {
        gap[axis] = other.point[axis] - one->point[axis];
    }
    const real least = fminl(fabsl(dot(gap, one->normal)), fabsl(dot(gap, other.normal)));
    return is_less(w, least, 0.1L + 0.3L * one->width);
}

/* Tests a texel between two ts; before: the texel before. Returns whether the ray ends. */
static bool test_texel(walk *w, const int texel[2], const int before[2], const real t[2], probe_answer *out)
{
    surface one;
    const real nearest = fminl(radius(w, t[0]), radius(w, t[1]));
    const real farthest = fmaxl(radius(w, t[0]), radius(w, t[1]));
    if (!open_texel(w->map, texel[0], texel[1], &one) ||
        is_less(w, farthest, one.distance * (1 - LEANING / w->map->info.resolution))) {
        return false;
    }
    const bool first = t[0] <= w->t_min;
    const real facing = dot(one.normal, w->direction);
    const real lift = dot(one.normal, w->origin) - dot(one.normal, one.point);
    const real enter = lift + t[0] * facing;
    const real leave = lift + t[1] * facing;
    w->close = w->close || fabsl(facing) < EVEN;
    const real reach = one.distance + 1 + one.width / fmaxl(one.cosine, 0.1L);
    const real below = 0.1L + 0.1L * one.width;
    if (is_less(w, farthest, one.distance) && (is_less(w, enter, 0) || is_less(w, 0, leave))) {
        return false;
    }
    const bool held = !is_less(w, reach, nearest);
    if (held && (facing < 0 ? is_less(w, 0, leave) : is_less(w, first ? -0.02L : 0, enter))) {
        return false;
    }
    out->state = SVO_PROBE_UNKNOWN;
    out->t = (double)fmaxl(facing < 0 && enter < 0 ? fminl(-lift / facing, t[0]) : t[0], w->t_min);
    if (!held || facing >= 0 || is_less(w, enter, first ? 0.02L : -below) || (!first && !is_joined(w, &one, before))) {
        return true;
    }
    out->state = SVO_PROBE_HIT;
    out->t = (double)fmaxl(-lift / facing, w->t_min);
    out->texel = (uint32_t)texel[1] * w->map->info.resolution + (uint32_t)texel[0];
    return true;
}

static bool turns_at(const walk *w, real t)
{
    return t == w->turns[0] || t == w->turns[1] || t == w->turns[2];
}

static probe_answer follow(walk *w, const real *list, size_t count, real t_max)
{
    const real leaf_edge = (real)w->map->info.leaf_edge;
    probe_answer out = {.state = SVO_PROBE_MISS, .t = INFINITY};
    int before[2] = {-1, -1};
    real t[2] = {w->t_min, w->t_min};
    size_t next = 0;
    bool brief = false; /* a texel whose corner the ray passes */
    while (t[0] < t_max) {
        int texel[2];
        while (next < count && list[next] <= t[0]) {
            ++next;
        }
        t[1] = next < count && list[next] < t_max ? list[next] : t_max;
        texel_of(w, (t[0] + t[1]) / 2, &texel[0], &texel[1]);
        /* Planes bound texels in one octant; in others they do not count. */
        for (size_t k = next; k < count && t[1] < t_max && !turns_at(w, t[1]); ++k) {
            const real end = k + 1 < count && list[k + 1] < t_max ? list[k + 1] : t_max;
            int beyond[2];
            texel_of(w, (t[1] + end) / 2, &beyond[0], &beyond[1]);
            if (beyond[0] != texel[0] || beyond[1] != texel[1]) {
                break;
            }
            t[1] = end;
        }
        const bool after_brief = brief;
        brief = t[1] - t[0] < EVEN;
        if (radius(w, t[0]) < 0.01L) {
            before[0] = texel[0];
            before[1] = texel[1];
        }
        if (test_texel(w, texel, before, t, &out)) {
            w->close = w->close || brief || after_brief;
            break;
        }
        before[0] = texel[0];
        before[1] = texel[1];
        t[0] = t[1];
    }
    out.t *= (double)leaf_edge;
    out.close = w->close;
    return out;
}

probe_answer probe_reference_trace(const probe_map *map, const svo_ray *ray)
{
    const real leaf_edge = (real)map->info.leaf_edge;
    walk w = {.map = map, .t_min = (real)ray->t_min / leaf_edge};
    real *list = malloc(CROSSINGS_MAX * 2 * sizeof *list);
    probe_answer out = {.close = true};
    for (int axis = 0; axis < 3; ++axis) {
        w.origin[axis] = ((real)ray->origin[axis] - (real)map->position[axis]) / leaf_edge;
        w.direction[axis] = (real)ray->direction[axis];
        w.turns[axis] = w.direction[axis] != 0 ? -w.origin[axis] / w.direction[axis] : -INFINITY;
    }
    if (list != NULL) {
        const size_t count = cross_all(&w, list);
        qsort(list, count, sizeof *list, compare);
        out = follow(&w, list, count, (real)ray->t_max / leaf_edge);
    }
    free(list);
    return out;
}
