/* SPDX-License-Identifier: MIT */
/*
 * Pictures of a lit tree: first hits and shadows by exact rays (surface.clh, direct.clh); with SVO_PICTURE_SCREEN
 * openness, indirect and specular light that were gathered before (screen.clh).
 *
 * A pixel has params.samples camera rays. Light is linear; svo_shade_tone (rays/shade.clh) makes it the share of white
 * that a screen shows, which is then coded by the sRGB curve (IEC 61966-2-1).
 *
 * Launch: one work-item per 2 x 2 pixels, tiles of 16 x 16 pixels per group, one dimension, as many tiles as the host
 * likes. Reads tree, light and sources; writes one RGBA8 word or four floats per pixel. No atomics, no local memory.
 */
#include "light/screen.clh"
#include "rays/shade.clh"

/* ---- what a screen shows ---- */

static float3 svo_picture_shown(const svo_lit_picture *picture, float3 radiance)
{
    return svo_shade_shown(picture->params.pixel_flags, picture->params.exposure * radiance);
}

/* Along a ray that meets nothing. */
static float3 svo_picture_background(const svo_lit_picture *picture, float3 direction)
{
    const float3 own = picture->params.view == SVO_LIT_VIEW_AO
                           ? (float3)(1.0f)
                           : svo_picture_shown(picture, svo_light_sky(&picture->light, direction));
    return svo_pixel_background(picture->params.pixel_flags, vload3(0, picture->params.background), own);
}

static void svo_picture_store(const svo_lit_picture *picture, float4 pixel, __global uint *pixels, size_t place)
{
    if ((picture->params.pixel_flags & SVO_PIXEL_LINEAR) != 0u) {
        svo_pixel_store_linear(pixels, place, pixel);
        return;
    }
    const float3 share = clamp(pixel.xyz, (float3)(0.0f), (float3)(1.0f));
    const float3 curved = 1.055f * powr(share, (float3)(1.0f / 2.4f)) - 0.055f;
    const float3 coded = select(curved, 12.92f * share, share <= 0.0031308f);
    pixels[place] = svo_pixel_bytes(coded, pixel.w);
}

/* ---- pixels ---- */

/* What screen.cl gathered for a band of the picture. */
typedef struct svo_picture_screen {
    __global const svo_gather_point *cells;
    __global const float4 *light; /* irradiance, and openness as the fourth */
    __global const float4 *specular; /* of surfaces that mirror */
    svo_screen_params params;
} svo_picture_screen;

/* What was gathered at a surface. */
typedef struct svo_picture_light {
    float3 irradiance; /* in the view of openness that, three times */
    float3 specular;
} svo_picture_light;

/* The same for a place of the picture. */
static svo_picture_light svo_picture_gathered(const svo_lit_picture *picture, const svo_picture_screen *screen,
                                              float2 place, const svo_lit_surface *surface)
{
#ifdef SVO_PICTURE_SCREEN
    const svo_screen_surface shown = {surface->point, surface->face, svo_screen_normal(picture, surface)};
    const svo_screen_cells cells = svo_screen_cells_of(screen->cells, screen->params, place, &shown);
    const float4 light = svo_screen_light(&cells, screen->light);
    const bool is_openness = picture->params.view == SVO_LIT_VIEW_AO;
    svo_picture_light gathered = {is_openness ? (float3)(light.w) : light.xyz, (float3)(0.0f)};
    if (svo_lit_reflects(picture, surface)) {
        gathered.specular = svo_screen_light(&cells, screen->specular).xyz;
    }
    return gathered;
#else
    const svo_picture_light none = {(float3)(0.0f), (float3)(0.0f)};
    (void)picture;
    (void)screen;
    (void)place;
    (void)surface;
    return none;
#endif
}

/* What a view shows of a surface: its radiance, or its openness. direct: its irradiance by the sources. */
static float3 svo_picture_radiance(const svo_lit_picture *picture, const svo_lit_surface *surface, float3 direct,
                                   const svo_picture_light *gathered)
{
    const float3 specular = surface->specular * gathered->specular;
    switch (picture->params.view) {
    case SVO_LIT_VIEW_AO:
        return gathered->irradiance;
    case SVO_LIT_VIEW_DIRECT:
        return surface->albedo * direct / M_PI_F;
    case SVO_LIT_VIEW_INDIRECT:
        return surface->albedo * gathered->irradiance / M_PI_F;
    case SVO_LIT_VIEW_SPECULAR:
        return specular;
    default:
        return surface->emission + surface->albedo * (direct + gathered->irradiance) / M_PI_F + specular;
    }
}

/* What a view shows of what the ray of a place of the picture meets; false: it meets nothing. */
SVO_INLINED bool svo_picture_look(const svo_lit_picture *picture, const svo_picture_screen *screen, float2 place,
                                  const svo_ray *ray, svo_alpha_ray set, svo_direct_samples samples, float3 *radiance)
{
    svo_lit_surface surface;
    float3 direct;
    if (!svo_direct_see(picture, ray, svo_lit_start(picture->params.sample_width), set, samples, &surface, &direct)) {
        return false;
    }
    svo_lit_seen(picture, &surface);
    const svo_picture_light gathered = svo_picture_gathered(picture, screen, place, &surface);
    *radiance = svo_picture_radiance(picture, &surface, direct, &gathered);
    return true;
}

/* The lower half of the bits, each with a zero above it. */
static uint svo_picture_even(uint bits)
{
    bits = (bits | bits << 8) & 0x00ff00ffu;
    bits = (bits | bits << 4) & 0x0f0f0f0fu;
    bits = (bits | bits << 2) & 0x33333333u;
    return (bits | bits << 1) & 0x55555555u;
}

/* The shares of white that a pixel shows, or its light. Rays to sources are spread over the picture in Morton order, so
   that pixels near each other err in different ways. */
SVO_INLINED float4 svo_picture_pixel(const svo_lit_picture *picture, const svo_picture_screen *screen, uint x, uint y)
{
    const uint samples = picture->params.samples;
    float3 sum = (float3)(0.0f);
    uint met = 0u;
    for (uint sample = 0; sample < samples; ++sample) {
        const float2 place = (float2)((float)x, (float)y) + svo_pixel_place(sample, samples);
        float3 radiance;
        const svo_ray ray = svo_screen_ray(picture, place);
        const svo_alpha_ray set = {sample, samples};
        const svo_direct_samples to_sources = {(svo_picture_even(x) | svo_picture_even(y) << 1) * samples + sample, 0u,
                                               picture->params.source_rays_log2};
        const bool meets = svo_picture_look(picture, screen, place, &ray, set, to_sources, &radiance);
        if (!meets) {
            sum += svo_picture_background(picture, vload3(0, ray.direction));
        } else {
            sum += picture->params.view == SVO_LIT_VIEW_AO ? radiance : svo_picture_shown(picture, radiance);
        }
        met += meets ? 1u : 0u; /* in the else branch, Intel's driver for CPUs would count all samples */
    }
    return svo_pixel_mean(picture->params.pixel_flags, sum, met, samples);
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_picture(SVO_LIT_PARAMETERS, __global const svo_gather_point *cells, __global const float4 *cell_light,
                    __global const float4 *cell_specular, svo_screen_params screen_params, __global uint *pixels)
{
    /* item bits: 5 4 3 | 2 1 0 are y | x inside the tile, in pairs of pixels. */
    const uint item = (uint)get_local_id(0);
    const uint tile = (uint)(get_global_id(0) / SVO_GROUP_ITEMS) + params.first_tile;
    const uint tiles_across = (params.width + 15u) / 16u;
    const uint x = tile % tiles_across * 16u + 2u * (item & 7u);
    const uint y = tile / tiles_across * 16u + 2u * (item >> 3);
    SVO_LIT_MAKE(picture);
    const svo_picture_screen screen = {cells, cell_light, cell_specular, screen_params};
    for (uint pixel = 0; pixel < 4u; ++pixel) {
        const uint column = x + (pixel & 1u);
        const uint row = y + (pixel >> 1);
        if (column < params.width && row < params.height) {
            svo_picture_store(&picture, svo_picture_pixel(&picture, &screen, column, row), pixels,
                              (size_t)row * params.width + column);
        }
    }
}
