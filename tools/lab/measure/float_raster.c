/* SPDX-License-Identifier: MIT */
/*
 * The rasterizing methods: a triangle is projected along its dominant axis, its pixels are found by the rules that
 * Direct3D and common hardware share, and depth is interpolated in float32. Each covered pixel gives one voxel or,
 * expanded (Hasselgren, Akenine-Moller and Ohlsson, "Conservative Rasterization", 2005), every voxel between the least
 * and the largest depth.
 */
#include "measure/float_raster.h"

#include <math.h>

#define SUBPIXELS 256

/* A projected triangle: u, v, t in pixels, in float. */
typedef struct projection {
    float corner[3][3];
    int axis;
    float slope_u, slope_v; /* of t over u and v; 0 where there is no area */
} projection;

/* Sample positions in 1/256 pixel from the corner of a pixel; the first is the center. */
static const int center[1][2] = {{128, 128}};
static const int four_samples[4][2] = {{96, 32}, {224, 96}, {32, 160}, {160, 224}};

static float doubled_area(const projection *p)
{
    return (p->corner[1][0] - p->corner[0][0]) * (p->corner[2][1] - p->corner[0][1]) -
           (p->corner[1][1] - p->corner[0][1]) * (p->corner[2][0] - p->corner[0][0]);
}

static float component(float a1, float b2, float a2, float b1)
{
    return a1 * b2 - a2 * b1;
}

static int dominant_axis(const float_triangle *t)
{
    float size[3];
    for (int k = 0; k < 3; ++k) {
        const int u = (k + 1) % 3;
        const int v = (k + 2) % 3;
        size[k] = fabsf(component(t->vertex[1][u] - t->vertex[0][u], t->vertex[2][v] - t->vertex[0][v],
                                  t->vertex[1][v] - t->vertex[0][v], t->vertex[2][u] - t->vertex[0][u]));
    }
    const int larger = size[1] > size[0] ? 1 : 0;
    return size[2] >= size[larger] ? 2 : larger;
}

static void project(const float_triangle *t, projection *p)
{
    p->axis = dominant_axis(t);
    for (int i = 0; i < 9; ++i) {
        const int k = (p->axis + 1 + i % 3) % 3;
        p->corner[i / 3][i % 3] = (t->vertex[i / 3][k] - t->origin[k]) / t->voxel;
    }
    const float area = doubled_area(p);
    const float rise_1 = p->corner[1][2] - p->corner[0][2];
    const float rise_2 = p->corner[2][2] - p->corner[0][2];
    const float u1 = p->corner[1][0] - p->corner[0][0];
    const float v1 = p->corner[1][1] - p->corner[0][1];
    const float u2 = p->corner[2][0] - p->corner[0][0];
    const float v2 = p->corner[2][1] - p->corner[0][1];
    const bool flat = !(fabsf(area) > 0.0f);
    p->slope_u = flat ? 0.0f : component(rise_1, v2, rise_2, v1) / area;
    p->slope_v = flat ? 0.0f : component(rise_2, u1, rise_1, u2) / area;
}

/* Expanded: each edge moves out by half a pixel along both axes. Hardware would snap afterwards; here float32
   decides. */
static bool covers_expanded(const projection *p, int u, int v)
{
    const float side = doubled_area(p) < 0.0f ? -1.0f : 1.0f;
    for (int i = 0; i < 3; ++i) {
        const float *from = p->corner[i];
        const float *to = p->corner[(i + 1) % 3];
        const float across_u = side * (from[1] - to[1]);
        const float across_v = side * (to[0] - from[0]);
        const float at = across_u * ((float)u + 0.5f - from[0]) + across_v * ((float)v + 0.5f - from[1]);
        if (at + 0.5f * (fabsf(across_u) + fabsf(across_v)) < 0.0f) {
            return false;
        }
    }
    return true;
}

/* The rule: positions on the sub-pixel grid, exact arithmetic from there; a sample on an edge counts only for top
   and left edges. */
static bool covers_sample(const int64_t snapped[3][2], int64_t u, int64_t v)
{
    const int64_t area = (snapped[1][0] - snapped[0][0]) * (snapped[2][1] - snapped[0][1]) -
                         (snapped[1][1] - snapped[0][1]) * (snapped[2][0] - snapped[0][0]);
    if (area == 0) {
        return false;
    }
    const int64_t side = area < 0 ? -1 : 1;
    for (int i = 0; i < 3; ++i) {
        const int64_t *from = snapped[i];
        const int64_t *to = snapped[(i + 1) % 3];
        const int64_t along_u = side * (to[0] - from[0]);
        const int64_t along_v = side * (to[1] - from[1]);
        const int64_t at = along_u * (v - from[1]) - along_v * (u - from[0]);
        const bool owns_edge = along_v < 0 || (along_v == 0 && along_u > 0);
        if (at < 0 || (at == 0 && !owns_edge)) {
            return false;
        }
    }
    return true;
}

static bool covers(float_method method, const projection *p, int u, int v)
{
    if (method == FLOAT_EXPANDED) {
        return covers_expanded(p, u, v);
    }
    int64_t snapped[3][2];
    for (int i = 0; i < 6; ++i) {
        snapped[i / 2][i % 2] = (int64_t)rintf(p->corner[i / 2][i % 2] * SUBPIXELS);
    }
    const int count = method == FLOAT_PIXELS ? 1 : 4;
    const int(*samples)[2] = method == FLOAT_PIXELS ? center : four_samples;
    for (int i = 0; i < count; ++i) {
        if (covers_sample(snapped, (int64_t)u * SUBPIXELS + samples[i][0], (int64_t)v * SUBPIXELS + samples[i][1])) {
            return true;
        }
    }
    return false;
}

static float clamp_to(float value, float low, float high)
{
    return fminf(fmaxf(value, low), high);
}

static void add_column(float_method method, const float_triangle *t, const projection *p, int u, int v,
                       float_list *list)
{
    const float low = fminf(p->corner[0][2], fminf(p->corner[1][2], p->corner[2][2]));
    const float high = fmaxf(p->corner[0][2], fmaxf(p->corner[1][2], p->corner[2][2]));
    const float at = p->corner[0][2] + p->slope_u * ((float)u + 0.5f - p->corner[0][0]) +
                     p->slope_v * ((float)v + 0.5f - p->corner[0][1]);
    const float reach = method == FLOAT_EXPANDED ? 0.5f * (fabsf(p->slope_u) + fabsf(p->slope_v)) : 0.0f;
    const bool flat = !(fabsf(doubled_area(p)) > 0.0f); /* no plane: the whole range */
    const float from = flat ? low : clamp_to(at - reach, low, high);
    const float to = flat ? high : clamp_to(at + reach, low, high);
    const int limit = (1 << t->depth) - 1;
    for (int k = (int)floorf(from); k <= (int)floorf(to); ++k) {
        if (k >= 0 && k <= limit) {
            int voxel[3];
            voxel[(p->axis + 1) % 3] = u;
            voxel[(p->axis + 2) % 3] = v;
            voxel[p->axis] = k;
            float_list_add(list, t, voxel[0], voxel[1], voxel[2]);
        }
    }
}

void float_raster(float_method method, const float_triangle *triangle, float_list *list)
{
    projection p;
    project(triangle, &p);
    const int along_u = (p.axis + 1) % 3;
    const int along_v = (p.axis + 2) % 3;

    for (int v = triangle->first[along_v]; v <= triangle->last[along_v]; ++v) {
        for (int u = triangle->first[along_u]; u <= triangle->last[along_u]; ++u) {
            if (covers(method, &p, u, v)) {
                add_column(method, triangle, &p, u, v, list);
            }
        }
    }
}
