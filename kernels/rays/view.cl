/* SPDX-License-Identifier: MIT */
/*
 * Pictures of what rays find, one ray per pixel, without lighting: normals, depths, traversal steps, levels, triangles.
 *
 * Launch: one work-item per pixel, tiles of 8 x 8 pixels per group, one dimension, as many tiles as the host likes,
 * from first_tile on.
 * Reads the tree and, with -DSVO_NORMAL, its normals; writes one RGBA8 word per pixel. No atomics, no local memory.
 */
#include "shared/layout.h"

#include "rays/part.clh"
#include "rays/rays.clh"

/* The step count that the last color stands for. */
#define SVO_STEPS_HOT 64.0f

static uint svo_view_pack(float3 color)
{
    const uint3 bytes = convert_uint3(clamp(color, (float3)(0.0f), (float3)(1.0f)) * 255.0f + 0.5f);
    return bytes.x | bytes.y << 8 | bytes.z << 16 | 0xff000000u;
}

/* From dark blue over green and yellow to red. */
static float3 svo_view_heat(float value)
{
    const float heat = clamp(value, 0.0f, 1.0f);
    const float3 peaks = (float3)(0.90f, 0.55f, 0.15f);
    const float3 away = (heat - peaks) / (float3)(0.55f, 0.45f, 0.35f);
    return max((float3)(1.0f) - away * away, (float3)(0.05f, 0.03f, 0.20f));
}

/* A color for each number, by a multiplicative hash (Knuth, "The Art of Computer Programming", volume 3, 6.4). */
static float3 svo_view_mixed(uint number)
{
    uint mixed = (number + 1u) * 2654435769u;
    mixed = (mixed ^ mixed >> 15) * 2246822519u;
    mixed ^= mixed >> 13;
    return (float3)(0.25f) +
           convert_float3((uint3)(mixed & 255u, mixed >> 8 & 255u, mixed >> 16 & 255u)) * (0.75f / 255.0f);
}

/* Values of the range as shares of white. What lies nowhere is transparent white. */
static uint svo_view_share(bool met, float value, float2 range)
{
    const uint byte = convert_uint(clamp((value - range.x) / (range.y - range.x), 0.0f, 1.0f) * 255.0f + 0.5f);
    return met ? byte * 0x010101u | 0xff000000u : 0x00ffffffu;
}

static float3 svo_view_vector(__constant const float *values)
{
    return (float3)(values[0], values[1], values[2]);
}

/* The hit's distance relative to the grid's bounding sphere: near hits are bright. */
static float svo_view_nearness(float3 eye, float distance, float cells)
{
    const float middle = length(eye - 0.5f * cells);
    const float reach = 0.87f * cells;
    const float first = max(middle - reach, 0.0f);
    return 1.0f - 0.9f * (distance - first) / (middle + reach - first);
}

static float3 svo_view_normal(const svo_cast_hit *hit, float3 direction, __global const short *normals)
{
    const float along = hit->axis == 0 ? direction.x : hit->axis == 1 ? direction.y : direction.z;
    const float side = along > 0.0f ? -1.0f : 1.0f;
    const float3 face =
        (float3)(hit->axis == 0 ? side : 0.0f, hit->axis == 1 ? side : 0.0f, hit->axis == 2 ? side : 0.0f);
#ifdef SVO_NORMAL
    const float3 own = convert_float3(vload3(SVO_NORMAL_INDEX(hit->place), normals)) / 32767.0f;
    return dot(own, own) > 0.04f ? normalize(own) : face;
#else
    (void)normals;
    return face;
#endif
}

#ifndef SVO_COMPACT

/* part: of the ray that is seen, in voxels */
static float3 svo_view_triangle(const svo_tree *tree, float4 eye, float3 direction, float2 part)
{
    const float voxel = (float)(1u << (tree->params.snap_bits - tree->params.depth)) / tree->params.scale[0];
    svo_ray ray;
    svo_hit hit;
    ray.origin[0] = eye.x;
    ray.origin[1] = eye.y;
    ray.origin[2] = eye.z;
    ray.direction[0] = direction.x;
    ray.direction[1] = direction.y;
    ray.direction[2] = direction.z;
    ray.t_min = voxel * part.x;
    ray.t_max = voxel * part.y;
    if (!svo_trace_closest(tree, &ray, &hit)) {
        return (float3)(1.0f);
    }
    const float facing = fabs(dot((float3)(hit.normal[0], hit.normal[1], hit.normal[2]), direction));
    return svo_view_mixed(hit.triangle) * (0.45f + 0.55f * facing);
}

#endif

/* The ray begins at a distance from the eye; cut_axis: of the face where it begins in a voxel. */
static float3 svo_view_voxel(const svo_tree *tree, const svo_cast_ray *ray, float first, int cut_axis, uint view,
                             __global const short *normals)
{
    svo_cast_tree cast;
    svo_cast_hit hit;
    cast.nodes = tree->voxels;
    cast.depth = tree->params.depth;
    const bool met = svo_cast(&cast, ray, &hit);
    if (view == SVO_VIEW_KIND_STEPS) {
        return svo_view_heat((float)hit.steps / SVO_STEPS_HOT);
    }
    if (!met) {
        return (float3)(1.0f);
    }
    hit.axis = first > 0.0f && hit.distance == 0.0f ? cut_axis : hit.axis;
    if (view == SVO_VIEW_KIND_NORMAL) {
        return 0.5f + 0.5f * svo_view_normal(&hit, ray->direction, normals);
    }
    if (view == SVO_VIEW_KIND_DEPTH) {
        return (float3)(svo_view_nearness(ray->origin - first * ray->direction, first + hit.distance,
                                          (float)(1u << tree->params.depth)));
    }
    return svo_view_mixed(hit.level * 7u) * (hit.axis == 0 ? 0.8f : hit.axis == 1 ? 1.0f : 0.65f);
}

/* Distances or steps in a range. The ray begins at a distance from the eye. */
static uint svo_view_value(const svo_tree *tree, const svo_cast_ray *ray, float first, uint view, float2 range)
{
    svo_cast_tree cast;
    svo_cast_hit hit;
    cast.nodes = tree->voxels;
    cast.depth = tree->params.depth;
    const bool met = svo_cast(&cast, ray, &hit);
    return view == SVO_VIEW_KIND_STEPS ? svo_view_share(true, (float)hit.steps, range)
                                       : svo_view_share(met, first + hit.distance, range);
}

/* range: in which the views depth and steps are shown, widths of a leaf or steps; empty: that of the view. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_view(SVO_TREE_PARAMETERS, __global const short *normals, __constant const svo_cast_params *params, float4 eye,
           uint view, float2 range, __global uint *picture, uint first_tile)
{
    const uint item = (uint)get_local_id(0);
    const uint tile = (uint)get_group_id(0) + first_tile;
    const uint tiles_across = (params->width + 7u) / 8u;
    const uint x = tile % tiles_across * 8u + (item & 7u);
    const uint y = tile / tiles_across * 8u + (item >> 3);
    if (x >= params->width || y >= params->height) {
        return;
    }
    SVO_TREE_MAKE(tree);
    svo_cast_ray ray;
    const float3 from = svo_view_vector(params->eye);
    ray.footprint = params->footprint;
    ray.direction = normalize(svo_view_vector(params->corner) + ((float)x + 0.5f) * svo_view_vector(params->across) +
                              ((float)y + 0.5f) * svo_view_vector(params->down));
    const float4 clip = vload4(0, params->clip);
    const float2 part = svo_ray_part(clip, from, ray.direction);
    ray.origin = from + part.x * ray.direction;
    ray.range = fmin(part.y - part.x, SVO_CAST_FAR);
    if (range.y > range.x && (view == SVO_VIEW_KIND_DEPTH || view == SVO_VIEW_KIND_STEPS)) {
        picture[(size_t)y * params->width + x] = svo_view_value(&tree, &ray, part.x, view, range);
        return;
    }
#ifdef SVO_COMPACT
    (void)eye;
    const float3 color = svo_view_voxel(&tree, &ray, part.x, svo_part_axis(clip), view, normals);
#else
    const float3 color = view == SVO_VIEW_KIND_TRIANGLES
                             ? svo_view_triangle(&tree, eye, ray.direction, part)
                             : svo_view_voxel(&tree, &ray, part.x, svo_part_axis(clip), view, normals);
#endif
    picture[(size_t)y * params->width + x] = svo_view_pack(color);
}
