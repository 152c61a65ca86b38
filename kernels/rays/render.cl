/* SPDX-License-Identifier: MIT */
/*
 * Pictures: rays through the tree's voxels, shaded by the sun, with shadows, and by a sky that neighbors darken.
 *
 * On GPUs a work-item draws a pixel (voxels.clh). With -DSVO_CAST_TILES, for CPUs, a work-item draws all pixels of its
 * group, by packets of rays (tile.clh): the same picture, but for rounding.
 *
 * Launch: one group per 8 x 8 pixels, one dimension, of SVO_GROUP_ITEMS or, with tiles, one work-item; in bands of
 * tiles by its offset. Reads the nodes and, with -DSVO_COLOR and -DSVO_NORMAL, the payload; writes one
 * RGBA8 word or four floats per pixel. No atomics, no local memory.
 *
 * What shows in part takes its share of the samples of a pixel, and of the rays that openness is measured by; from an
 * alpha of a half on it hides the sun.
 */
#include "shared/layout.h"

#include "rays/surface.clh"
#include "rays/tile.clh"

/* The colors of a tree that does not show whole: the root, which is the first, has them all. */
static __global const uchar *svo_cast_clear(__global const uchar *colors)
{
#ifdef SVO_COLOR
    return svo_payload_alpha(colors, 0u) != 255u ? colors : 0;
#else
    (void)colors;
    return 0;
#endif
}

#ifndef SVO_CAST_TILES

/* ---- one pixel ---- */

/* How open the hemisphere above a surface is. */
static float svo_cast_openness(const svo_cast_picture *picture, const svo_cast_surface *surface)
{
    svo_cast_ray ray;
    svo_cast_hit hit;
    float open = 0.0f;
    ray.origin = surface->point;
    ray.footprint = SVO_SHADE_OCCLUSION_FOOTPRINT;
    ray.range = svo_cast_occlusion_range(picture, surface);
    ray.alpha.count = SVO_SHADE_OCCLUSION_RAYS;
    for (int k = 0; k < SVO_SHADE_OCCLUSION_RAYS; ++k) {
        ray.direction = svo_shade_occlusion_direction(surface->normal, k);
        ray.alpha.index = (uint)k;
        open += svo_cast(&picture->tree, &ray, &hit) ? hit.distance / ray.range : 1.0f;
    }
    return open / (float)SVO_SHADE_OCCLUSION_RAYS;
}

static bool svo_cast_is_sunlit(const svo_cast_picture *picture, const svo_cast_surface *surface)
{
    svo_cast_ray ray;
    svo_cast_hit blocker;
    ray.direction = svo_params_vector(picture->params->sun);
    const float2 part = svo_cast_part(picture->params, surface->point, ray.direction);
    ray.origin = surface->point + part.x * ray.direction;
    ray.footprint = 0.0f;
    ray.range = fmin(part.y - part.x, SVO_CAST_FAR);
    ray.alpha.index = 0u;
    ray.alpha.count = 1u;
    return dot(surface->normal, ray.direction) > 0.0f && !svo_cast(&picture->tree, &ray, &blocker);
}

static float4 svo_cast_pixel(const svo_cast_picture *picture, uint x, uint y)
{
    const uint samples = picture->params->samples;
    svo_cast_surface lit; /* where light is known */
    float3 light = (float3)(0.0f);
    float3 sum = (float3)(0.0f);
    svo_cast_ray ray;
    svo_cast_hit hit;
    bool is_lit = false;
    uint met = 0u;
    const float3 eye = svo_params_vector(picture->params->eye);
    ray.footprint = picture->params->footprint;
    ray.alpha.count = samples;
    for (uint sample = 0u; sample < samples; ++sample) {
        ray.direction = svo_cast_direction(picture->params, x, y, sample);
        const float2 part = svo_cast_part(picture->params, eye, ray.direction);
        ray.origin = eye + part.x * ray.direction;
        ray.range = fmin(part.y - part.x, SVO_CAST_FAR);
        ray.alpha.index = sample;
        is_lit = is_lit && sample % SVO_CAST_SAMPLES != 0u;
        if (!svo_cast(&picture->tree, &ray, &hit)) {
            sum += svo_cast_background(picture, y);
            continue;
        }
        ++met;
        svo_cast_return(picture->params, part.x, &hit);
        const svo_cast_surface surface = svo_cast_surface_of(picture, &hit, ray.direction);
        if (!is_lit || !svo_cast_shares_light(&surface, &lit)) {
            light = svo_cast_light(picture, &surface, svo_cast_openness(picture, &surface),
                                   svo_cast_is_sunlit(picture, &surface));
            lit = surface;
            is_lit = true;
        }
        sum += svo_cast_shown(picture, hit.place, light);
    }
    return svo_pixel_mean(picture->params->pixel_flags, sum, met, samples);
}

#endif

/* ---- the picture ---- */

#ifdef SVO_CAST_TILES
#define SVO_PIXELS_PER_ITEM SVO_GROUP_ITEMS
#else
#define SVO_PIXELS_PER_ITEM 1
#endif

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS / SVO_PIXELS_PER_ITEM, 1, 1))) void
svo_k_cast(SVO_NODES_PARAMETERS, __global const uchar *colors, __global const short *normals,
           __constant const svo_cast_params *params, __global uint *pixels)
{
    /* item bits: 5 4 3 | 2 1 0 are y | x inside the tile. */
    const uint item = (uint)get_local_id(0);
    const uint tile = (uint)(get_global_id(0) / (SVO_GROUP_ITEMS / SVO_PIXELS_PER_ITEM));
    const uint tiles_across = (params->width + 7u) / 8u;
    const uint x = tile % tiles_across * 8u + (item & 7u);
    const uint y = tile / tiles_across * 8u + (item >> 3);
    svo_cast_picture picture;
    SVO_NODES_MAKE(nodes);
    picture.tree.nodes = nodes;
    picture.tree.depth = params->depth;
    picture.tree.colors = svo_cast_clear(colors);
    picture.colors = colors;
    picture.normals = normals;
    picture.params = params;
#ifdef SVO_CAST_TILES
    svo_tile_draw(&picture, x, y, pixels);
#else
    if (x < params->width && y < params->height) {
        svo_shade_store(params->pixel_flags, svo_cast_pixel(&picture, x, y), pixels, (size_t)y * params->width + x);
    }
#endif
}
