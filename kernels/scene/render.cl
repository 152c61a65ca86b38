/* SPDX-License-Identifier: MIT */
/*
 * Pictures of a scene: rays through its voxels (scene.clh), Lambert shading by lights from given directions, with
 * shadows, and by a sky that neighbors darken. The light and the tone curve are those of kernels/rays/render.cl. So is
 * how what shows in part is seen, with -DSVO_CLEAR_NODES, for scenes that have some. -DSVO_PACKED: some tree has
 * packed payload, which is read where it is.
 *
 * Launch: one work-item per pixel, tiles of 8 x 8 pixels per group, one dimension, in bands of tiles by
 * its offset. Reads the scene, its colors and normals as far as its trees have them, and the lights; writes one
 * RGBA8 word or four floats per pixel. No atomics, no local memory.
 */
#include "shared/layout.h"

#include "rays/part.clh"
#include "rays/shade.clh"
#include "scene/walk.clh"

/* What a kernel draws from. */
typedef struct svo_scene_view {
    svo_scene scene;
    __global const uchar *colors;
    __global const short *normals;
    __constant const svo_scene_picture *picture;
    __constant const svo_scene_light *lights;
} svo_scene_view;

/* A surface that a ray met. */
typedef struct svo_scene_surface {
    float3 point; /* outside of it, where rays to lights begin */
    float3 normal; /* unit, never away from the eye */
    float3 color; /* linear */
    float node_width; /* world */
} svo_scene_surface;

/* The light of a pixel's last sample, which the next one near it takes: light is most of a picture's cost. */
typedef struct svo_scene_lit {
    float3 point;
    float3 normal; /* zero before the first */
    float3 light;
} svo_scene_lit;

static svo_ray svo_scene_make_ray(float3 origin, float3 direction, float range)
{
    svo_ray ray;
    vstore3(origin, 0, ray.origin);
    vstore3(direction, 0, ray.direction);
    ray.t_min = 0.0f;
    ray.t_max = range;
    return ray;
}

static float3 svo_scene_constant(__constant const float *values)
{
    return (float3)(values[0], values[1], values[2]);
}

/* The part of a ray that the picture's plane leaves. */
static svo_ray svo_scene_clip(const svo_scene_view *view, float3 origin, float3 direction)
{
    const float2 part = svo_ray_part(vload4(0, view->picture->clip), origin, direction);
    svo_ray ray = svo_scene_make_ray(origin, direction, part.y);
    ray.t_min = part.x;
    return ray;
}

/* That a tree stores for a node. */
static float3 svo_scene_own_normal(const svo_scene_view *view, __global const svo_scene_tree *tree, uint node)
{
#ifdef SVO_PACKED
    if ((tree->flags & SVO_SCENE_TREE_PACKED_NORMALS) != 0u) {
        return svo_unpack_normal(view->normals + 3u * (size_t)tree->normal_begin, node) / 32767.0f;
    }
#endif
    const uint index = (tree->flags & SVO_SCENE_TREE_ONE_NORMAL) != 0u ? 0u : node;
    return convert_float3(vload3((size_t)tree->normal_begin + index, view->normals)) / 32767.0f;
}

/* The voxel's normal where it has one of some length, else its face's, as kernels/rays/render.cl chooses it. */
static float3 svo_scene_shading_normal(const svo_scene_view *view, __global const svo_scene_instance *instance,
                                       const svo_voxel_hit *hit, float3 direction)
{
    __global const svo_scene_tree *tree = view->scene.trees + instance->tree;
    float3 normal = svo_scene_face_normal(instance, hit->face);
    if ((tree->flags & SVO_SCENE_TREE_NORMALS) != 0u) {
        const float3 own = svo_scene_own_normal(view, tree, hit->node);
        normal = dot(own, own) > 0.04f ? svo_scene_normal(instance, own) : normal;
    }
    return dot(normal, normal) == 0.0f ? -direction : svo_shade_facing(normal, direction);
}

static float3 svo_scene_color(const svo_scene_view *view, uint tree_index, uint node)
{
    __global const svo_scene_tree *tree = view->scene.trees + tree_index;
    if ((tree->flags & SVO_SCENE_TREE_COLORS) == 0u) {
        return (float3)(SVO_SHADE_CLAY);
    }
#ifdef SVO_PACKED
    if ((tree->flags & SVO_SCENE_TREE_PACKED_COLORS) != 0u) {
        return svo_shade_decode(svo_unpack_color(view->colors + 4u * (size_t)tree->color_begin, node));
    }
#endif
    const uint index = (tree->flags & SVO_SCENE_TREE_ONE_COLOR) != 0u ? 0u : node;
    return svo_shade_decode(vload4((size_t)tree->color_begin + index, view->colors));
}

static svo_scene_surface svo_scene_surface_of(const svo_scene_view *view, const svo_scene_search *search, float3 origin,
                                              float3 direction)
{
    __global const svo_scene_instance *instance = view->scene.instances + search->instance;
    __global const svo_ray_params *params = view->scene.tree_params + instance->tree;
    svo_scene_surface surface;
    surface.normal = svo_scene_shading_normal(view, instance, &search->voxel, direction);
    surface.color = svo_scene_color(view, instance->tree, search->voxel.node);
    surface.node_width = instance->widest * (float)(1u << (params->snap_bits - search->voxel.level)) / params->scale[0];
    /* Off the voxels' steps, so that a surface does not occlude itself. */
    surface.point =
        origin + direction * (search->t - 0.5f * surface.node_width) + surface.normal * (1.75f * surface.node_width);
    return surface;
}

/* A ray of a sample: from the camera, or from the surface that this one met. */
typedef struct svo_scene_query {
    svo_ray ray;
    float footprint;
    uint flags;
    svo_alpha_ray alpha;
    float3 light; /* that arrives unless the ray meets something */
} svo_scene_query;

/* Short rays tell how open the hemisphere above a surface is. */
static float svo_scene_open_range(const svo_scene_view *view, const svo_scene_surface *surface)
{
    return max(view->picture->occlusion_range, 6.0f * surface->node_width);
}

/* The next ray from a surface, and behind it in the list: first the short ones, then those to lights. Lights without
   shadows add theirs to *light. Returns whether there is one. */
static bool svo_scene_next_query(const svo_scene_view *view, const svo_scene_surface *surface, uint *next,
                                 svo_scene_query *query, float3 *light)
{
    if (*next < SVO_SHADE_OCCLUSION_RAYS) {
        query->ray = svo_scene_make_ray(surface->point, svo_shade_occlusion_direction(surface->normal, (int)*next),
                                        svo_scene_open_range(view, surface));
        query->footprint = SVO_SHADE_OCCLUSION_FOOTPRINT;
        query->flags = 0u;
        query->alpha.index = *next;
        query->alpha.count = SVO_SHADE_OCCLUSION_RAYS;
        ++*next;
        return true;
    }
    while (*next < SVO_SHADE_OCCLUSION_RAYS + view->picture->light_count) {
        __constant const svo_scene_light *source = view->lights + (*next - SVO_SHADE_OCCLUSION_RAYS);
        const float3 direction = svo_scene_constant(source->direction);
        const float facing = dot(surface->normal, direction);
        const float3 arriving = facing * svo_scene_constant(source->color);
        ++*next;
        if (facing > 0.0f && source->shadows == 0u) {
            *light += arriving;
        } else if (facing > 0.0f) {
            query->ray = svo_scene_clip(view, surface->point, direction);
            query->footprint = 0.0f;
            query->flags = SVO_SCENE_FLAG_ANY;
            query->alpha.index = 0u;
            query->alpha.count = 1u;
            query->light = arriving;
            return true;
        }
    }
    return false;
}

/* Whether a surface takes the light of the last sample. */
static bool svo_scene_is_alike(const svo_scene_surface *surface, const svo_scene_lit *lit)
{
    const float3 step = surface->point - lit->point;
    return !(dot(surface->normal, lit->normal) < 0.9f ||
             dot(step, step) > 6.0f * surface->node_width * surface->node_width);
}

/* The surface that a sample's ray meets, with its light in *lit; false: it meets none. All rays of a sample are traced
   in one place, so that there is one copy of the traversal, with one stack. */
static bool svo_scene_look(const svo_scene_view *view, svo_scene_query query, svo_scene_surface *surface,
                           svo_scene_lit *lit)
{
    float open = 0.0f; /* of the hemisphere, times the short rays */
    uint next = 0u; /* 0: the ray is the camera's; else one more than its number in the list */
    do {
        svo_scene_search search;
#ifdef SVO_CLEAR_NODES
        search.alpha = query.alpha;
#endif
        const bool is_met = svo_scene_search_ray(&view->scene, &query.ray, query.footprint, query.flags, &search);
        if (next == 0u) {
            if (!is_met) {
                return false;
            }
            *surface = svo_scene_surface_of(view, &search, vload3(0, query.ray.origin), vload3(0, query.ray.direction));
            if (svo_scene_is_alike(surface, lit)) {
                return true;
            }
            lit->point = surface->point;
            lit->normal = surface->normal;
        } else if (next <= SVO_SHADE_OCCLUSION_RAYS) {
            const float range = svo_scene_open_range(view, surface);
            open += (is_met ? min(search.t, range) : range) / range;
        } else if (!is_met) {
            lit->light += query.light;
        }
        if (next == SVO_SHADE_OCCLUSION_RAYS) {
            lit->light = svo_shade_sky(dot(surface->normal, svo_scene_constant(view->picture->up)),
                                       open / (float)SVO_SHADE_OCCLUSION_RAYS);
        }
    } while (svo_scene_next_query(view, surface, &next, &query, &lit->light));
    return true;
}

/* One ray of a pixel. *met: counts those that met something. */
static float3 svo_scene_sample(const svo_scene_view *view, uint x, uint y, uint sample, svo_scene_lit *lit, uint *met)
{
    __constant const svo_scene_picture *picture = view->picture;
    const float2 place = (float2)((float)x, (float)y) + svo_pixel_place(sample, picture->samples);
    const float3 direction =
        normalize(svo_scene_constant(picture->corner) + place.x * svo_scene_constant(picture->across) +
                  place.y * svo_scene_constant(picture->down));
    const svo_scene_query camera = {svo_scene_clip(view, svo_scene_constant(picture->eye), direction),
                                    picture->footprint,
                                    0u,
                                    {sample, picture->samples},
                                    (float3)(0.0f)};
    svo_scene_surface surface;
    if (!svo_scene_look(view, camera, &surface, lit)) {
        return svo_pixel_background(picture->pixel_flags, svo_scene_constant(picture->background),
                                    svo_shade_background(place.y / (float)picture->height));
    }
    ++*met;
    return svo_shade_shown(picture->pixel_flags, SVO_SHADE_EXPOSURE * (surface.color * lit->light));
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_scene_render(SVO_SCENE_PARAMETERS, __global const uchar *colors, __global const short *normals,
                   __constant const svo_scene_picture *picture, __constant const svo_scene_light *lights,
                   __global uint *pixels)
{
    /* item bits: 5 4 3 | 2 1 0 are y | x inside the tile. */
    const uint item = (uint)get_local_id(0);
    const uint tile = (uint)(get_global_id(0) / SVO_GROUP_ITEMS);
    const uint tiles_across = (picture->width + 7u) / 8u;
    const uint x = tile % tiles_across * 8u + (item & 7u);
    const uint y = tile / tiles_across * 8u + (item >> 3);
    if (x >= picture->width || y >= picture->height) {
        return;
    }
    svo_scene_view view;
    SVO_SCENE_MAKE(scene);
    view.scene = scene;
#ifdef SVO_CLEAR_NODES
    view.scene.colors = colors;
#endif
    view.colors = colors;
    view.normals = normals;
    view.picture = picture;
    view.lights = lights;
    svo_scene_lit lit;
    lit.point = (float3)(0.0f);
    lit.normal = (float3)(0.0f);
    lit.light = (float3)(0.0f);
    float3 sum = (float3)(0.0f);
    uint met = 0u;
    for (uint sample = 0u; sample < picture->samples; ++sample) {
        sum += svo_scene_sample(&view, x, y, sample, &lit, &met);
    }
    svo_shade_store(picture->pixel_flags, svo_pixel_mean(picture->pixel_flags, sum, met, picture->samples), pixels,
                    (size_t)y * picture->width + x);
}
