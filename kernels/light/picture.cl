/* SPDX-License-Identifier: MIT */
/*
 * Pictures of a lit tree: first hits and shadows by exact rays (surface.clh, direct.clh), openness, indirect and
 * specular light by cones (gather.clh).
 *
 * A pixel has SVO_PICTURE_SAMPLES^2 camera rays. Those of 2 x 2 pixels that meet one plane within a leaf's edge share
 * what cones gather there, which is nearly all of a picture's time. Light is linear; svo_shade_tone (rays/shade.clh)
 * makes it the share of white that a screen shows, which is then coded by the sRGB curve (IEC 61966-2-1).
 *
 * Launch: one work-item per 2 x 2 pixels, tiles of 16 x 16 pixels per group, one dimension, as many tiles as the host
 * likes. Reads tree, light and sources; writes one RGBA8 word per pixel. No atomics, no local memory.
 */
#include "light/direct.clh"
#include "light/published.clh"
#include "rays/shade.clh"

#define SVO_PICTURE_SAMPLES 2u /* along each side of a pixel */

/* Samples share what cones gather if their normals' cosine is at least this, and they are no farther apart than this,
   in leaf edges: along the plane, and off it. */
#define SVO_PICTURE_ALIKE 0.97f
#define SVO_PICTURE_NEAR  1.0f
#define SVO_PICTURE_OFF   0.25f

/* Surfaces of 2 x 2 pixels for which the gathered is kept. */
#define SVO_PICTURE_KEPT 4u

/* ---- what cones bring ---- */

/* What cones gathered at the surfaces of an item's pixels. */
typedef struct svo_picture_cache {
    float3 points[SVO_PICTURE_KEPT];
    float3 faces[SVO_PICTURE_KEPT];
    svo_gather_result gathered[SVO_PICTURE_KEPT];
    uint count; /* of all that were gathered; the last ones are kept */
} svo_picture_cache;

/* Where a surface finds what was gathered near it; SVO_PICTURE_KEPT: nowhere. */
static uint svo_picture_find(const svo_lit_picture *picture, const svo_lit_surface *surface,
                             const svo_picture_cache *cache)
{
    const float edge = picture->light.params.voxel_edge;
    for (uint k = 0; k < min(cache->count, SVO_PICTURE_KEPT); ++k) {
        const float3 apart = surface->point - cache->points[k];
        if (dot(surface->face, cache->faces[k]) >= SVO_PICTURE_ALIKE &&
            dot(apart, apart) <= SVO_PICTURE_NEAR * SVO_PICTURE_NEAR * edge * edge &&
            fabs(dot(apart, surface->face)) <= SVO_PICTURE_OFF * edge) {
            return k;
        }
    }
    return SVO_PICTURE_KEPT;
}

static bool svo_picture_has_cones(const svo_lit_picture *picture)
{
    const uint view = picture->params.view;
    return view == SVO_LIT_VIEW_AO || (view != SVO_LIT_VIEW_DIRECT && picture->gather.with_light != 0u);
}

/* Cones leave the triangle's own plane: the payload's normal differs from leaf to leaf, which would show. */
static svo_gather_result svo_picture_gather(const svo_lit_picture *picture, const svo_lit_surface *surface,
                                            float3 direction)
{
    const bool shines = picture->params.view == SVO_LIT_VIEW_FULL || picture->params.view == SVO_LIT_VIEW_SPECULAR;
    const bool reflects =
        shines && (surface->specular.x > 0.0f || surface->specular.y > 0.0f || surface->specular.z > 0.0f);
    const float3 reflected = direction - 2.0f * dot(direction, surface->normal) * surface->normal;
    svo_gather_point point;
    vstore3(surface->point, 0, point.position);
    vstore3(surface->face, 0, point.normal);
    vstore3(reflects ? reflected : (float3)(0.0f), 0, point.reflected);
    point.exponent = surface->exponent;
#ifdef SVO_LIGHT_BRICKS
    if (picture->gather.published != 0u) {
        return svo_gather_published(&picture->light, &point, &picture->gather);
    }
#endif
    return svo_gather_by(&picture->light, &point, &picture->gather);
}

/* ---- what a screen shows ---- */

/* The radiance of a surface in a view. */
static float3 svo_picture_radiance(const svo_lit_picture *picture, const svo_lit_surface *surface,
                                   const svo_gather_result *gathered)
{
    const uint view = picture->params.view;
    const float3 indirect = vload3(0, gathered->irradiance);
    const float3 specular = surface->specular * vload3(0, gathered->specular);
    const float3 direct =
        view == SVO_LIT_VIEW_DIRECT || view == SVO_LIT_VIEW_FULL ? svo_direct_light(picture, surface) : (float3)(0.0f);
    switch (view) {
    case SVO_LIT_VIEW_DIRECT:
        return surface->albedo * direct / M_PI_F;
    case SVO_LIT_VIEW_INDIRECT:
        return surface->albedo * indirect / M_PI_F;
    case SVO_LIT_VIEW_SPECULAR:
        return specular;
    default:
        return surface->emission + surface->albedo * (direct + indirect) / M_PI_F + specular;
    }
}

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
    return svo_lit_ray(vload3(0, picture->params.eye), direction, INFINITY);
}

/* What cones gather at a surface; nothing in views without them. */
static svo_gather_result svo_picture_cones(const svo_lit_picture *picture, const svo_lit_surface *surface,
                                           float3 direction, svo_picture_cache *cache)
{
    if (!svo_picture_has_cones(picture)) {
        return svo_gather_dark();
    }
    uint place = svo_picture_find(picture, surface, cache);
    if (place == SVO_PICTURE_KEPT) {
        place = cache->count++ % SVO_PICTURE_KEPT;
        cache->points[place] = surface->point;
        cache->faces[place] = surface->face;
        cache->gathered[place] = svo_picture_gather(picture, surface, direction);
    }
    return cache->gathered[place];
}

/* The share of white that a pixel shows. */
static float3 svo_picture_pixel(const svo_lit_picture *picture, uint x, uint y, svo_picture_cache *cache)
{
    const uint samples = SVO_PICTURE_SAMPLES * SVO_PICTURE_SAMPLES;
    float3 sum = (float3)(0.0f);
    for (uint sample = 0; sample < samples; ++sample) {
        const svo_ray ray = svo_picture_ray(picture, x, y, sample);
        svo_lit_surface surface;
        if (!svo_lit_find(picture, &ray, &surface)) {
            sum += svo_picture_background(picture);
            continue;
        }
        const svo_gather_result gathered = svo_picture_cones(picture, &surface, vload3(0, ray.direction), cache);
        sum += picture->params.view == SVO_LIT_VIEW_AO
                   ? (float3)(gathered.openness)
                   : svo_picture_shown(picture, svo_picture_radiance(picture, &surface, &gathered));
    }
    return sum / (float)samples;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_picture(SVO_TREE_PARAMETERS, SVO_LIGHT_PARAMETERS, __global const uchar *colors,
                    __global const short *normals, __global const ushort *materials,
                    __global const svo_finish *finishes, __global const svo_light_source *sources,
                    svo_gather_params gather, svo_lit_picture_params params, __global uint *pixels)
{
    /* item bits: 5 4 3 | 2 1 0 are y | x inside the tile, in pairs of pixels. */
    const uint item = (uint)get_local_id(0);
    const uint tile = (uint)get_group_id(0) + params.first_tile;
    const uint tiles_across = (params.width + 15u) / 16u;
    const uint x = tile % tiles_across * 16u + 2u * (item & 7u);
    const uint y = tile / tiles_across * 16u + 2u * (item >> 3);
    SVO_TREE_MAKE(tree);
    SVO_LIGHT_MAKE(light);
    svo_lit_picture picture;
    picture.tree = tree;
    picture.light = light;
    picture.colors = colors;
    picture.normals = normals;
    picture.materials = materials;
    picture.finishes = finishes;
    picture.sources = sources;
    picture.gather = gather;
    picture.params = params;
    svo_picture_cache cache;
    cache.count = 0;
    for (uint pixel = 0; pixel < 4u; ++pixel) {
        const uint column = x + (pixel & 1u);
        const uint row = y + (pixel >> 1);
        if (column < params.width && row < params.height) {
            pixels[(size_t)row * params.width + column] =
                svo_picture_encode(svo_picture_pixel(&picture, column, row, &cache));
        }
    }
}
