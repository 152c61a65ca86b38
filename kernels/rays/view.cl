/* SPDX-License-Identifier: MIT */
/*
 * Pictures of what rays find, one ray per pixel or several, without lighting: normals, depths, traversal steps, levels,
 * triangles. Linear pictures have the numbers themselves, others colors for them.
 *
 * Launch: one work-item per pixel, tiles of 8 x 8 pixels per group, one dimension, in bands of tiles by
 * its offset.
 * Reads the tree and, with -DSVO_NORMAL, its normals; writes one RGBA8 word or four floats per pixel. No atomics, no
 * local memory.
 */
#include "shared/layout.h"

#include "rays/part.clh"
#include "rays/pixel.clh"
#include "rays/rays.clh"

/* The step count that the last color stands for. */
#define SVO_STEPS_HOT 64.0f

/* What a ray found, as a color, or in linear pictures as numbers. */
typedef struct svo_view_seen {
    float3 shown;
    bool met; /* anything; else nothing is shown, except for steps */
} svo_view_seen;

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
    const float3 own = svo_payload_normal(normals, hit->place);
    return dot(own, own) > 0.04f ? normalize(own) : face;
#else
    (void)normals;
    return face;
#endif
}

#ifndef SVO_COMPACT

/* part: of the ray that is seen, in voxels */
static svo_view_seen svo_view_triangle(const svo_tree *tree, float4 eye, float3 direction, float2 part, bool linear)
{
    const float voxel = (float)(1u << (tree->params.snap_bits - tree->params.depth)) / tree->params.scale[0];
    svo_ray ray;
    svo_hit hit;
    svo_view_seen seen;
    ray.origin[0] = eye.x;
    ray.origin[1] = eye.y;
    ray.origin[2] = eye.z;
    ray.direction[0] = direction.x;
    ray.direction[1] = direction.y;
    ray.direction[2] = direction.z;
    ray.t_min = voxel * part.x;
    ray.t_max = voxel * part.y;
    seen.shown = (float3)(0.0f);
    seen.met = svo_trace_closest(tree, &ray, &hit);
    if (seen.met) {
        const float facing = fabs(dot((float3)(hit.normal[0], hit.normal[1], hit.normal[2]), direction));
        seen.shown = linear ? (float3)((float)hit.triangle) : svo_view_mixed(hit.triangle) * (0.45f + 0.55f * facing);
    }
    return seen;
}

#endif

/* hit: with the distance from the eye. */
static float3 svo_view_color(const svo_tree *tree, float3 eye, const svo_cast_hit *hit, float3 direction, uint view,
                             __global const short *normals)
{
    switch (view) {
    case SVO_VIEW_KIND_STEPS:
        return svo_view_heat((float)hit->steps / SVO_STEPS_HOT);
    case SVO_VIEW_KIND_NORMAL:
        return 0.5f + 0.5f * svo_view_normal(hit, direction, normals);
    case SVO_VIEW_KIND_DEPTH:
        return (float3)(svo_view_nearness(eye, hit->distance, (float)(1u << tree->params.depth)));
    default:
        return svo_view_mixed(hit->level * 7u) * (hit->axis == 0 ? 0.8f : hit->axis == 1 ? 1.0f : 0.65f);
    }
}

static float3 svo_view_numbers(const svo_tree *tree, const svo_cast_hit *hit, float3 direction, uint view,
                               __global const short *normals)
{
    const int voxel_log2 = (int)tree->params.snap_bits - (int)tree->params.depth; /* grid units */
    switch (view) {
    case SVO_VIEW_KIND_STEPS:
        return (float3)((float)hit->steps);
    case SVO_VIEW_KIND_NORMAL:
        return svo_view_normal(hit, direction, normals);
    case SVO_VIEW_KIND_DEPTH:
        return (float3)(ldexp(hit->distance, voxel_log2) / tree->params.scale[0]);
    default:
        return (float3)((float)hit->level);
    }
}

/* The ray begins at a distance from the eye; cut_axis: of the face where it begins in a voxel. */
static svo_view_seen svo_view_voxel(const svo_tree *tree, const svo_cast_ray *ray, float first, int cut_axis, uint view,
                                    __global const short *normals, bool linear)
{
    svo_cast_tree cast;
    svo_cast_hit hit;
    svo_view_seen seen;
    cast.nodes = tree->voxels;
    cast.depth = tree->params.depth;
    cast.colors = 0;
    seen.shown = (float3)(0.0f);
    seen.met = svo_cast(&cast, ray, &hit);
    hit.axis = first > 0.0f && hit.distance == 0.0f ? cut_axis : hit.axis;
    hit.distance += first;
    if (seen.met || view == SVO_VIEW_KIND_STEPS) {
        seen.shown =
            linear ? svo_view_numbers(tree, &hit, ray->direction, view, normals)
                   : svo_view_color(tree, ray->origin - first * ray->direction, &hit, ray->direction, view, normals);
    }
    return seen;
}

/* A ray's color or numbers added to those of its pixel. Rays that met nothing are white, or what is asked for. */
static void svo_view_add(__constant const svo_cast_params *params, const svo_view_seen *seen, uint view, float3 *sum,
                         uint *met)
{
    const bool shown = seen->met || view == SVO_VIEW_KIND_STEPS;
    const float3 behind =
        (params->pixel_flags & SVO_PIXEL_LINEAR) != 0u
            ? (float3)(0.0f)
            : svo_pixel_background(params->pixel_flags, svo_view_vector(params->background), (float3)(1.0f));
    *sum += shown ? seen->shown : behind;
    *met += shown ? 1u : 0u;
}

/* Numbers are means of what was met, beside the share of the pixel that was. */
static void svo_view_store(__constant const svo_cast_params *params, float3 sum, uint met, __global uint *picture,
                           size_t place)
{
    if ((params->pixel_flags & SVO_PIXEL_LINEAR) != 0u) {
        svo_pixel_store_linear(picture, place, svo_pixel_mean(SVO_PIXEL_TRANSPARENT, sum, met, params->samples));
    } else {
        const float4 pixel = svo_pixel_mean(params->pixel_flags, sum, met, params->samples);
        picture[place] = svo_pixel_bytes(pixel.xyz, pixel.w);
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_view(SVO_TREE_PARAMETERS, __global const short *normals, __constant const svo_cast_params *params, float4 eye,
           uint view, __global uint *picture)
{
    const uint item = (uint)get_local_id(0);
    const uint tile = (uint)(get_global_id(0) / SVO_GROUP_ITEMS);
    const uint tiles_across = (params->width + 7u) / 8u;
    const uint x = tile % tiles_across * 8u + (item & 7u);
    const uint y = tile / tiles_across * 8u + (item >> 3);
    if (x >= params->width || y >= params->height) {
        return;
    }
    SVO_TREE_MAKE(tree);
    const bool linear = (params->pixel_flags & SVO_PIXEL_LINEAR) != 0u;
    float3 sum = (float3)(0.0f);
    uint met = 0u;
    svo_cast_ray ray;
    const float3 from = svo_view_vector(params->eye);
    const float4 clip = vload4(0, params->clip);
    ray.footprint = params->footprint;
    for (uint sample = 0u; sample < params->samples; ++sample) {
        const float2 place = (float2)((float)x, (float)y) + svo_pixel_place(sample, params->samples);
        ray.direction = normalize(svo_view_vector(params->corner) + place.x * svo_view_vector(params->across) +
                                  place.y * svo_view_vector(params->down));
        const float2 part = svo_ray_part(clip, from, ray.direction);
        ray.origin = from + part.x * ray.direction;
        ray.range = fmin(part.y - part.x, SVO_CAST_FAR);
#ifdef SVO_COMPACT
        (void)eye;
        const svo_view_seen seen = svo_view_voxel(&tree, &ray, part.x, svo_part_axis(clip), view, normals, linear);
#else
        const svo_view_seen seen =
            view == SVO_VIEW_KIND_TRIANGLES
                ? svo_view_triangle(&tree, eye, ray.direction, part, linear)
                : svo_view_voxel(&tree, &ray, part.x, svo_part_axis(clip), view, normals, linear);
#endif
        svo_view_add(params, &seen, view, &sum, &met);
    }
    svo_view_store(params, sum, met, picture, (size_t)y * params->width + x);
}
