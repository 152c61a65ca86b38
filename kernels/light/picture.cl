/* SPDX-License-Identifier: MIT */
/*
 * Pictures of a lit tree: first hits and shadows by exact rays (surface.clh, direct.clh), openness, indirect and
 * specular light by cones (shading.clh).
 *
 * A pixel has SVO_PICTURE_SAMPLES^2 camera rays. Those of 2 x 2 pixels that meet one plane within a leaf's edge share
 * what cones gather there, which is nearly all of a picture's time. Light is linear; svo_shade_tone (rays/shade.clh)
 * makes it the share of white that a screen shows, which is then coded by the sRGB curve (IEC 61966-2-1).
 *
 * Launch: one work-item per 2 x 2 pixels, tiles of 16 x 16 pixels per group, one dimension, as many tiles as the host
 * likes. Reads tree, light and sources; writes one RGBA8 word per pixel. No atomics, no local memory.
 */
#include "light/shading.clh"
#include "rays/part.clh"
#include "rays/shade.clh"

#define SVO_PICTURE_SAMPLES 2u /* along each side of a pixel */

/* Samples share what cones gather within this many leaf edges. */
#define SVO_PICTURE_NEAR 1.0f

/* ---- what a screen shows ---- */

static float3 svo_picture_shown(const svo_lit_picture *picture, float3 radiance)
{
    return svo_shade_tone(picture->params.exposure * radiance);
}

static float3 svo_picture_background(const svo_lit_picture *picture)
{
    return picture->params.view == SVO_LIT_VIEW_AO ? (float3)(1.0f)
                                                   : svo_picture_shown(picture, vload3(0, picture->params.sky));
}

static uint svo_picture_encode(float3 shown)
{
    const float3 share = clamp(shown, (float3)(0.0f), (float3)(1.0f));
    const float3 curved = 1.055f * powr(share, (float3)(1.0f / 2.4f)) - 0.055f;
    const float3 coded = select(curved, 12.92f * share, share <= 0.0031308f);
    const uint3 bytes = convert_uint3(clamp(coded, (float3)(0.0f), (float3)(1.0f)) * 255.0f + 0.5f);
    return bytes.x | bytes.y << 8 | bytes.z << 16 | 0xff000000u;
}

/* ---- pixels ---- */

static svo_ray svo_picture_ray(const svo_lit_picture *picture, uint x, uint y, uint sample)
{
    const float column = (float)x + ((float)(sample % SVO_PICTURE_SAMPLES) + 0.5f) / (float)SVO_PICTURE_SAMPLES;
    const float row = (float)y + ((float)(sample / SVO_PICTURE_SAMPLES) + 0.5f) / (float)SVO_PICTURE_SAMPLES;
    const float3 direction = normalize(vload3(0, picture->params.corner) + column * vload3(0, picture->params.across) +
                                       row * vload3(0, picture->params.down));
    const float3 eye = vload3(0, picture->params.eye);
    const float2 part = svo_ray_part(vload4(0, picture->params.clip), eye, direction);
    svo_ray ray = svo_lit_ray(eye, direction, part.y);
    ray.t_min = part.x;
    return ray;
}

/* The share of white that a pixel shows. */
SVO_INLINED float3 svo_picture_pixel(const svo_lit_picture *picture, uint x, uint y, svo_lit_cache *cache)
{
    const uint samples = SVO_PICTURE_SAMPLES * SVO_PICTURE_SAMPLES;
    float3 sum = (float3)(0.0f);
    for (uint sample = 0; sample < samples; ++sample) {
        const svo_ray ray = svo_picture_ray(picture, x, y, sample);
        float3 radiance;
        if (!svo_lit_look(picture, &ray, cache, &radiance)) {
            sum += svo_picture_background(picture);
        } else {
            sum += picture->params.view == SVO_LIT_VIEW_AO ? radiance : svo_picture_shown(picture, radiance);
        }
    }
    return sum / (float)samples;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void svo_k_light_picture(SVO_LIT_PARAMETERS,
                                                                                               __global uint *pixels)
{
    /* item bits: 5 4 3 | 2 1 0 are y | x inside the tile, in pairs of pixels. */
    const uint item = (uint)get_local_id(0);
    const uint tile = (uint)get_group_id(0) + params.first_tile;
    const uint tiles_across = (params.width + 15u) / 16u;
    const uint x = tile % tiles_across * 16u + 2u * (item & 7u);
    const uint y = tile / tiles_across * 16u + 2u * (item >> 3);
    SVO_LIT_MAKE(picture);
    SVO_LIT_CACHE(cache, SVO_PICTURE_NEAR);
    for (uint pixel = 0; pixel < 4u; ++pixel) {
        const uint column = x + (pixel & 1u);
        const uint row = y + (pixel >> 1);
        if (column < params.width && row < params.height) {
            pixels[(size_t)row * params.width + column] =
                svo_picture_encode(svo_picture_pixel(&picture, column, row, &cache));
        }
    }
}
