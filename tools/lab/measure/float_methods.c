/* SPDX-License-Identifier: MIT */
/*
 * The float32 methods, and the loop over the triangles of a tree.
 *
 * Overlap tests. Schwarz and Seidel, "Fast Parallel Surface and Solid Voxelization on GPUs", 2010: a box meets a
 * triangle when it meets the plane and its three projections meet the projected triangle. Akenine-Moller, "Fast 3D
 * Triangle-Box Overlap Testing", 2001: thirteen separating axes after moving the box's center to the origin.
 *
 * Rasterizing methods. A triangle is projected along its dominant axis, its pixels are found by the rules that Direct3D
 * and common hardware share, and depth is interpolated in float32. Each covered pixel gives one voxel or, expanded
 * (Hasselgren, Akenine-Moller and Ohlsson, "Conservative Rasterization", 2005), every voxel between the least and the
 * largest depth.
 */
#include "measure/float_methods.h"

#include <math.h>
#include <stdlib.h>

/* ---- pairs ---- */

/* One triangle in world coordinates, the grid as floats, and the voxels to test: the exact bounds and one more voxel
   on each side. */
typedef struct float_triangle {
    float vertex[3][3];
    float origin[3];
    float voxel; /* edge of a voxel */
    int first[3], last[3];
    unsigned depth;
    uint32_t id;
} float_triangle;

static void float_list_add(float_list *list, const float_triangle *triangle, int x, int y, int z)
{
    if (list->count == list->capacity && !list->failed) {
        const size_t capacity = list->capacity > 0 ? list->capacity * 2 : 4096;
        oracle_pair *grown = realloc(list->pairs, capacity * sizeof *grown);
        if (grown == NULL) {
            list->failed = true;
            return;
        }
        list->pairs = grown;
        list->capacity = capacity;
    }
    if (!list->failed) {
        const uint64_t code = oracle_voxel_code((uint32_t)x, (uint32_t)y, (uint32_t)z, triangle->depth);
        list->pairs[list->count++] = (oracle_pair){code, triangle->id};
    }
}

/* ---- rasterizing methods ---- */

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

/* Appends the voxels that the method finds for one triangle. */
static void float_raster(float_method method, const float_triangle *triangle, float_list *list)
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

/* ---- overlap tests ---- */

const char *float_method_name(float_method method)
{
    static const char *const names[FLOAT_METHOD_COUNT] = {"Schwarz-Seidel", "box-centered", "pixel centers",
                                                          "4 samples", "expanded"};
    return names[method];
}

oracle_coverage float_method_coverage(float_method method)
{
    return method == FLOAT_PLANES || method == FLOAT_CENTERED ? ORACLE_CLOSED : ORACLE_HALF_OPEN;
}

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void subtract(const float a[3], const float b[3], float out[3])
{
    for (int k = 0; k < 3; ++k) {
        out[k] = a[k] - b[k];
    }
}

static void cross(const float a[3], const float b[3], float out[3])
{
    for (int k = 0; k < 3; ++k) {
        const int u = (k + 1) % 3;
        const int v = (k + 2) % 3;
        out[k] = a[u] * b[v] - a[v] * b[u];
    }
}

static void normal_of(const float_triangle *triangle, float normal[3])
{
    float first[3];
    float second[3];
    subtract(triangle->vertex[1], triangle->vertex[0], first);
    subtract(triangle->vertex[2], triangle->vertex[0], second);
    cross(first, second, normal);
}

static float least(float a, float b, float c)
{
    return fminf(a, fminf(b, c));
}

static float most(float a, float b, float c)
{
    return fmaxf(a, fmaxf(b, c));
}

static bool bounds_meet(const float_triangle *t, const float corner[3])
{
    for (int k = 0; k < 3; ++k) {
        if (least(t->vertex[0][k], t->vertex[1][k], t->vertex[2][k]) > corner[k] + t->voxel ||
            most(t->vertex[0][k], t->vertex[1][k], t->vertex[2][k]) < corner[k]) {
            return false;
        }
    }
    return true;
}

/* The three edges projected along axis: the box must not lie entirely outside any of them. */
static bool projection_meets(const float_triangle *t, const float normal[3], const float corner[3], int axis)
{
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    const float side = normal[axis] < 0.0f ? -1.0f : 1.0f;
    for (int i = 0; i < 3; ++i) {
        const float *from = t->vertex[i];
        const float *to = t->vertex[(i + 1) % 3];
        const float across_u = -(to[v] - from[v]) * side;
        const float across_v = (to[u] - from[u]) * side;
        const float offset = -(across_u * from[u] + across_v * from[v]) + fmaxf(0.0f, t->voxel * across_u) +
                             fmaxf(0.0f, t->voxel * across_v);
        if (across_u * corner[u] + across_v * corner[v] + offset < 0.0f) {
            return false;
        }
    }
    return true;
}

static bool planes_meet(const float_triangle *t, const float normal[3], const float corner[3])
{
    if (!bounds_meet(t, corner)) {
        return false;
    }
    float nearer[3];
    float farther[3];
    for (int k = 0; k < 3; ++k) {
        const float critical = normal[k] > 0.0f ? t->voxel : 0.0f;
        nearer[k] = critical - t->vertex[0][k];
        farther[k] = t->voxel - critical - t->vertex[0][k];
    }
    const float at = dot(normal, corner);
    if ((at + dot(normal, nearer)) * (at + dot(normal, farther)) > 0.0f) {
        return false;
    }
    return projection_meets(t, normal, corner, 0) && projection_meets(t, normal, corner, 1) &&
           projection_meets(t, normal, corner, 2);
}

static bool is_apart(const float local[3][3], const float axis[3], float half)
{
    const float a = dot(axis, local[0]);
    const float b = dot(axis, local[1]);
    const float c = dot(axis, local[2]);
    const float radius = half * (fabsf(axis[0]) + fabsf(axis[1]) + fabsf(axis[2]));
    return least(a, b, c) > radius || most(a, b, c) < -radius;
}

static bool centered_meets(const float_triangle *t, const float corner[3])
{
    const float half = t->voxel * 0.5f;
    float local[3][3];
    for (int i = 0; i < 9; ++i) {
        local[i / 3][i % 3] = t->vertex[i / 3][i % 3] - (corner[i % 3] + half);
    }
    for (int k = 0; k < 3; ++k) {
        float unit[3] = {0.0f, 0.0f, 0.0f};
        unit[k] = 1.0f;
        if (is_apart(local, unit, half)) {
            return false;
        }
        for (int i = 0; i < 3; ++i) {
            float edge[3];
            float axis[3];
            subtract(local[(i + 1) % 3], local[i], edge);
            cross(unit, edge, axis);
            if (is_apart(local, axis, half)) {
                return false;
            }
        }
    }
    float first[3];
    float second[3];
    float normal[3];
    subtract(local[1], local[0], first);
    subtract(local[2], local[0], second);
    cross(first, second, normal);
    return !is_apart(local, normal, half);
}

static void test_voxels(float_method method, const float_triangle *t, float_list *list)
{
    float normal[3];
    normal_of(t, normal);
    for (int z = t->first[2]; z <= t->last[2]; ++z) {
        for (int y = t->first[1]; y <= t->last[1]; ++y) {
            for (int x = t->first[0]; x <= t->last[0]; ++x) {
                const float corner[3] = {t->origin[0] + (float)x * t->voxel, t->origin[1] + (float)y * t->voxel,
                                         t->origin[2] + (float)z * t->voxel};
                if (method == FLOAT_PLANES ? planes_meet(t, normal, corner) : centered_meets(t, corner)) {
                    float_list_add(list, t, x, y, z);
                }
            }
        }
    }
}

/* A vertex's coordinate as the caller gave it, rounded to float. */
static float coordinate(const svo_tree_arrays *arrays, size_t vertex, size_t axis)
{
    return arrays->positions_double != NULL ? (float)arrays->positions_double[vertex * 3 + axis]
                                            : arrays->positions[vertex * 3 + axis];
}

static void fetch(const svo_tree_info *info, const svo_tree_arrays *arrays, uint64_t index, float_triangle *out)
{
    const int limit = (1 << info->depth) - 1;
    const double unit = ldexp(1.0 / info->scale, (int)(info->snap_bits - info->depth));
    *out = (float_triangle){.voxel = (float)unit, .depth = info->depth, .id = arrays->triangle_ids[index]};
    for (int k = 0; k < 3; ++k) {
        int32_t low = INT32_MAX;
        int32_t high = INT32_MIN;
        for (size_t corner = 0; corner < 3; ++corner) {
            const size_t vertex = arrays->indices[index * 3 + corner];
            const int32_t q = arrays->vertices[vertex * 3 + (size_t)k];
            low = q < low ? q : low;
            high = q > high ? q : high;
            out->vertex[corner][k] = coordinate(arrays, vertex, (size_t)k);
        }
        const int first = (low >> (info->snap_bits - info->depth)) - 1;
        const int last = (high >> (info->snap_bits - info->depth)) + 1;
        out->origin[k] = (float)info->origin[k];
        out->first[k] = first < 0 ? 0 : first;
        out->last[k] = last > limit ? limit : last;
    }
}

static void drop_doubles(oracle_pairs *pairs)
{
    size_t kept = 0;
    for (size_t i = 0; i < pairs->count; ++i) {
        const bool again = kept > 0 && pairs->pairs[kept - 1].code == pairs->pairs[i].code &&
                           pairs->pairs[kept - 1].triangle == pairs->pairs[i].triangle;
        if (!again) {
            pairs->pairs[kept++] = pairs->pairs[i];
        }
    }
    pairs->count = kept;
}

void float_method_list(float_method method, const svo_tree_info *info, const svo_tree_arrays *arrays, uint64_t begin,
                       uint64_t end, float_list *list)
{
    for (uint64_t i = begin; i < end && !list->failed; ++i) {
        float_triangle triangle;
        fetch(info, arrays, i, &triangle);
        if (method == FLOAT_PLANES || method == FLOAT_CENTERED) {
            test_voxels(method, &triangle, list);
        } else {
            float_raster(method, &triangle, list);
        }
    }
}

bool float_method_sort(float_list *list, oracle_pairs *out)
{
    const bool failed = list->failed;
    *out = (oracle_pairs){list->pairs, list->count};
    *list = (float_list){0};
    if (failed || (out->count > 0 && !oracle_pairs_sort(out->pairs, out->count))) {
        oracle_pairs_free(out);
        return false;
    }
    drop_doubles(out);
    return true;
}

bool float_method_run(float_method method, const svo_tree_info *info, const svo_tree_arrays *arrays, oracle_pairs *out)
{
    float_list list = {0};
    float_method_list(method, info, arrays, 0, info->list_triangle_count, &list);
    return float_method_sort(&list, out);
}
