/* SPDX-License-Identifier: MIT */
/*
 * The two overlap tests in float32, and the loop over the triangles of a tree.
 *
 * Schwarz and Seidel, "Fast Parallel Surface and Solid Voxelization on GPUs", 2010: a box meets a triangle when it
 * meets the plane and its three projections meet the projected triangle. Akenine-Moller, "Fast 3D Triangle-Box Overlap
 * Testing", 2001: thirteen separating axes after moving the box's center to the origin.
 */
#include "measure/float_methods.h"

#include <math.h>
#include <stdlib.h>

#include "measure/float_raster.h"

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

static void fetch(const svo_tree_info *info, const svo_tree_arrays *arrays, uint64_t index, float_triangle *out)
{
    const int limit = (1 << info->depth) - 1;
    const double unit = info->edge / (double)(1u << info->depth);
    *out = (float_triangle){.voxel = (float)unit, .depth = info->depth, .id = arrays->triangle_ids[index]};
    for (int k = 0; k < 3; ++k) {
        int32_t low = INT32_MAX;
        int32_t high = INT32_MIN;
        for (size_t corner = 0; corner < 3; ++corner) {
            const int32_t q = arrays->vertices[(size_t)arrays->indices[index * 3 + corner] * 3 + (size_t)k];
            low = q < low ? q : low;
            high = q > high ? q : high;
            out->vertex[corner][k] = (float)(info->origin[k] + (double)q / info->scale);
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
