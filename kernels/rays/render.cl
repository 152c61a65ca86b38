/* SPDX-License-Identifier: MIT */
/*
 * Pictures: rays through the tree's voxels (voxels.clh), shaded.
 *
 * Launch: one work-item per pixel, tiles of 8 x 8 pixels per group, one dimension, rounded up to whole tiles.
 * Reads the nodes and, with -DSVO_COLOR and -DSVO_NORMAL, the payload; writes one RGBA8 word per pixel.
 * No atomics, no local memory.
 */
#include "shared/layout.h"

#include "rays/voxels.clh"

/* Ambient occlusion by four short rays: how open the hemisphere above the point is, nearer voxels counting more. 0 ..
   1. */
static float svo_cast_openness(const svo_cast_tree *tree, float3 point, float3 normal, float range)
{
    const float3 helper = fabs(normal.y) < 0.7f ? (float3)(0.0f, 1.0f, 0.0f) : (float3)(1.0f, 0.0f, 0.0f);
    const float3 side = normalize(cross(normal, helper));
    const float3 other = cross(normal, side);
    const float2 circle[4] = {(float2)(0.85f, 0.2f), (float2)(-0.2f, 0.85f), (float2)(-0.85f, -0.2f),
                              (float2)(0.2f, -0.85f)};
    float open = 0.0f;
    for (int k = 0; k < 4; ++k) {
        svo_cast_ray ray;
        ray.origin = point;
        ray.direction = normalize(0.6f * normal + circle[k].x * side + circle[k].y * other);
        ray.footprint = 0.12f;
        ray.range = range;
        svo_cast_hit hit;
        open += svo_cast(tree, &ray, &hit) ? hit.distance / range : 1.0f;
    }
    return 0.25f * open;
}

static float3 svo_cast_background(__constant const svo_cast_params *params, float row)
{
    const float3 above = (float3)(0.80f, 0.86f, 0.93f);
    const float3 below = (float3)(0.93f, 0.92f, 0.90f);
    return mix(above, below, row / (float)params->height);
}

static float3 svo_params_vector(__constant const float *values)
{
    return (float3)(values[0], values[1], values[2]);
}

/* The node's normal where it is long enough, else the face's; never pointing away from the eye. Sheets have two sides,
   so a normal that points clearly away is negated. One that points slightly away belongs to a silhouette; it is made
   perpendicular to the ray, so that points offset along it stay outside the surface. */
static float3 svo_cast_normal(const svo_cast_hit *hit, float3 direction, __global const short *normals)
{
    const float towards = hit->axis == 0 ? direction.x : hit->axis == 1 ? direction.y : direction.z;
    const float side = towards > 0.0f ? -1.0f : 1.0f;
    float3 normal = (float3)(0.0f);
    normal.x = hit->axis == 0 ? side : 0.0f;
    normal.y = hit->axis == 1 ? side : 0.0f;
    normal.z = hit->axis == 2 ? side : 0.0f;
#ifdef SVO_NORMAL
    const float3 own = convert_float3(vload3(SVO_NORMAL_INDEX(hit->place), normals)) / 32767.0f;
    normal = dot(own, own) > 0.04f ? normalize(own) : normal;
#else
    (void)normals;
#endif
    const float away = dot(normal, direction);
    if (away > 0.7f) {
        return -normal;
    }
    return away > 0.0f ? normalize(normal - away * direction) : normal;
}

/* Stored colors are squared to linear light: close to sRGB and cheap. */
static float3 svo_cast_albedo(const svo_cast_hit *hit, __global const uchar *colors)
{
#ifdef SVO_COLOR
    const float3 stored = convert_float3(vload4(SVO_COLOR_INDEX(hit->place), colors).xyz) / 255.0f;
    return stored * stored;
#else
    (void)hit;
    (void)colors;
    return (float3)(0.55f, 0.54f, 0.52f);
#endif
}

/* The light that reaches a point of a surface: the sky's, and the sun's unless it is occluded. */
static float3 svo_cast_light(const svo_cast_tree *tree, float3 point, float3 normal, float node_width,
                             __constant const svo_cast_params *params)
{
    const float3 sun = svo_params_vector(params->sun);
    float direct = dot(normal, sun);
    if (direct > 0.0f) {
        svo_cast_ray to_sun;
        to_sun.origin = point;
        to_sun.direction = sun;
        to_sun.footprint = 0.0f;
        to_sun.range = SVO_CAST_FAR;
        svo_cast_hit blocker;
        direct = svo_cast(tree, &to_sun, &blocker) ? 0.0f : direct;
    }
    const float open = svo_cast_openness(tree, point, normal, fmax(params->occlusion_range, 6.0f * node_width));
    const float sky = 0.5f + 0.5f * dot(normal, svo_params_vector(params->up));
    const float3 ambient =
        mix((float3)(0.30f, 0.27f, 0.25f), (float3)(0.52f, 0.58f, 0.68f), sky) * mix(0.3f, 1.0f, open);
    return ambient + fmax(direct, 0.0f) * (float3)(1.05f, 0.98f, 0.86f);
}

/* The light of a pixel's last sample, reused by the next one: light is most of a picture's cost. */
typedef struct svo_cast_lit {
    float3 point;
    float3 normal; /* zero before the first */
    float3 light;
} svo_cast_lit;

static float3 svo_cast_shade(const svo_cast_tree *tree, const svo_cast_ray *ray, const svo_cast_hit *hit,
                             svo_cast_lit *lit, __global const uchar *colors, __global const short *normals,
                             __constant const svo_cast_params *params)
{
    const float3 normal = svo_cast_normal(hit, ray->direction, normals);
    const float node_width = (float)(1u << (tree->depth - hit->level));
    /* Offset from the voxels' steps, so that a surface does not occlude itself. */
    const float3 point =
        ray->origin + ray->direction * (hit->distance - 0.5f * node_width) + normal * (1.75f * node_width);
    const float3 step = point - lit->point;
    if (dot(normal, lit->normal) < 0.9f || dot(step, step) > 6.0f * node_width * node_width) {
        lit->point = point;
        lit->normal = normal;
        lit->light = svo_cast_light(tree, point, normal, node_width, params);
    }
    return svo_cast_albedo(hit, colors) * lit->light;
}

static uint svo_pack_color(float3 light)
{
    /* Highlights are compressed, not clipped; the square root inverts the squares of svo_cast_albedo. */
    const float3 soft = light / (1.0f + 0.12f * light * light);
    const uint3 bytes = convert_uint3(sqrt(clamp(soft, (float3)(0.0f), (float3)(1.0f))) * 255.0f + 0.5f);
    return bytes.x | bytes.y << 8 | bytes.z << 16 | 0xff000000u;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_cast(SVO_NODES_PARAMETERS, __global const uchar *colors, __global const short *normals,
           __constant const svo_cast_params *params, __global uint *picture)
{
    /* item bits: 5 4 3 | 2 1 0 are y | x inside the tile. */
    const uint item = (uint)get_local_id(0);
    const uint tile = (uint)get_group_id(0);
    const uint tiles_across = (params->width + 7u) / 8u;
    const uint x = tile % tiles_across * 8u + (item & 7u);
    const uint y = tile / tiles_across * 8u + (item >> 3);
    if (x >= params->width || y >= params->height) {
        return;
    }
    SVO_NODES_MAKE(nodes);
    svo_cast_tree tree;
    tree.nodes = nodes;
    tree.depth = params->depth;
    svo_cast_ray ray;
    ray.origin = svo_params_vector(params->eye);
    ray.range = SVO_CAST_FAR;
    ray.footprint = params->footprint / (float)params->samples;
    svo_cast_lit lit;
    lit.point = (float3)(0.0f);
    lit.normal = (float3)(0.0f);
    lit.light = (float3)(0.0f);
    float3 sum = (float3)(0.0f);
    for (uint sample = 0u; sample < params->samples * params->samples; ++sample) {
        const float column = (float)x + ((float)(sample % params->samples) + 0.5f) / (float)params->samples;
        const float row = (float)y + ((float)(sample / params->samples) + 0.5f) / (float)params->samples;
        ray.direction = normalize(svo_params_vector(params->corner) + column * svo_params_vector(params->across) +
                                  row * svo_params_vector(params->down));
        svo_cast_hit hit;
        sum += svo_cast(&tree, &ray, &hit) ? svo_cast_shade(&tree, &ray, &hit, &lit, colors, normals, params)
                                           : svo_cast_background(params, row);
    }
    picture[(size_t)y * params->width + x] = svo_pack_color(sum / (float)(params->samples * params->samples));
}
