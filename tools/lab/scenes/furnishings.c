/* SPDX-License-Identifier: MIT */
/* Banners, plants, vases and the fountain of the atrium. */
#include "furnishings.h"

#define PROFILE(points) (points), (uint32_t)(sizeof(points) / sizeof((points)[0]))

typedef struct banner {
    vector3 top, across, outwards;
    vector3 field, trim;
    double phase;
} banner;

static vector3 banner_position(const banner *cloth, double u, double v)
{
    const double sway =
        0.09 * v * sine_of_turns(1.5 * u + cloth->phase + 0.4 * v) + 0.04 * sine_of_turns(0.9 * v + 2 * cloth->phase);
    /* The lower edge ends in a swallow's tail. */
    const double tail = 0.35 * smooth_ramp(0.8, 1, v) * (1 - fabs(2 * u - 1));
    const vector3 down = vector(0, -2.7 * v + tail, 0);
    const vector3 aside = vector_scale(cloth->across, 1.3 * (u - 0.5));
    return vector_add(cloth->top, vector_add(down, vector_add(aside, vector_scale(cloth->outwards, sway))));
}

static vector3 banner_color(const banner *cloth, double u, double v)
{
    const double diamond = fabs(u - 0.5) * 1.3 + fabs(v - 0.42) * 2.7 * 0.7;
    const bool edge = u < 0.09 || u > 0.91 || v > 0.94 || (v > 0.10 && v < 0.14);
    const bool emblem = diamond < 0.42 && (diamond > 0.30 || diamond < 0.16);
    return edge || emblem ? cloth->trim : cloth->field;
}

static surface_point banner_point(const void *context, double u, double v)
{
    const banner *cloth = context;
    const double step = 0x1p-8;
    surface_point point;
    point.position = banner_position(cloth, u, v);
    const vector3 along_u = vector_subtract(banner_position(cloth, u + step, v), point.position);
    const vector3 along_v = vector_subtract(banner_position(cloth, u, v + step), point.position);
    point.normal = vector_normalize(vector_cross(along_u, along_v));
    point.color = banner_color(cloth, u, v);
    return point;
}

void furnish_banner(atrium *scene, vector3 top, vector3 outwards, uint32_t kind)
{
    static const vector3 fields[4] = {{0.72, 0.10, 0.13}, {0.12, 0.25, 0.60}, {0.10, 0.42, 0.26}, {0.48, 0.15, 0.45}};
    banner cloth = {.top = top, .outwards = outwards, .field = fields[kind % 4], .trim = vector(0.95, 0.76, 0.32)};
    cloth.across = vector_cross(outwards, vector(0, 1, 0));
    cloth.phase = random_between(&scene->random, 0, 1);
    const patch_grid grid = {.columns = atrium_segments(scene, 22, 4), .rows = atrium_segments(scene, 40, 6)};
    scene->builder->material = ATRIUM_CLOTH;
    part_patch(scene->builder, grid, banner_point, &cloth);
}

typedef struct leaf {
    vector3 base, outwards;
    double length, rise;
    vector3 color;
} leaf;

static surface_point leaf_point(const void *context, double u, double v)
{
    const leaf *blade = context;
    const double width = 0.16 * blade->length * (0.15 + 3.4 * v * (1 - v) * (1 - 0.45 * v)) * (v < 1 ? 1 : 0.1);
    const vector3 side = vector_cross(blade->outwards, vector(0, 1, 0));
    const double reach = blade->length * (0.15 * v + 0.6 * v * v);
    const double height = blade->length * (blade->rise * v - 0.75 * v * v * v + 0.10 * fabs(2 * u - 1));
    const vector3 spine = vector_add(vector_scale(blade->outwards, reach), vector(0, height, 0));
    surface_point point;
    point.position = vector_add(blade->base, vector_add(spine, vector_scale(side, width * (2 * u - 1))));
    point.normal = vector_normalize(vector_add(vector(0, 1, 0), vector_scale(blade->outwards, 1.6 * v - 0.8)));
    const double shade = mix(0.75, 1.1, v) - (fabs(u - 0.5) < 0.15 ? 0.1 : 0);
    point.color = vector_scale(blade->color, shade);
    return point;
}

static void add_leaves(atrium *scene, vector3 base, double length)
{
    const patch_grid grid = {.columns = atrium_segments(scene, 4, 1), .rows = atrium_segments(scene, 9, 3)};
    scene->builder->material = ATRIUM_LEAF;
    for (int k = 0; k < 13; ++k) {
        const double turns = k * 0.381966 + random_between(&scene->random, -0.03, 0.03);
        const double size = length * random_between(&scene->random, 0.75, 1.15);
        leaf blade = {.base = base, .length = size};
        blade.outwards = vector(cosine_of_turns(turns), 0, sine_of_turns(turns));
        blade.rise = random_between(&scene->random, 0.9, 1.5);
        blade.color = vector(0.30 + 0.12 * random_between(&scene->random, 0, 1), 0.55, 0.24);
        part_patch(scene->builder, grid, leaf_point, &blade);
    }
}

static void add_turned(atrium *scene, vector3 base, const profile_point *profile, uint32_t profile_count, double scale,
                       vector3 color)
{
    const turned_body body = {base, profile, profile_count, scale, vector_scale(color, 0.85), color};
    part_turned_body(scene->builder, &body, atrium_segments(scene, 18, 5), atrium_segments(scene, 14, 4));
}

static void add_pot(atrium *scene, vector3 base, double scale)
{
    static const profile_point pot[] = {{0.02, 0.0},  {0.20, 0.0},  {0.26, 0.12}, {0.33, 0.40}, {0.34, 0.50},
                                        {0.38, 0.52}, {0.38, 0.58}, {0.32, 0.58}, {0.28, 0.50}, {0.02, 0.50}};
    scene->builder->material = ATRIUM_TERRACOTTA;
    add_turned(scene, base, PROFILE(pot), scale, vector(0.95, 0.80, 0.70));
}

void furnish_plant(atrium *scene, vector3 base, double scale)
{
    add_pot(scene, base, scale);
    add_leaves(scene, vector_add(base, vector(0, 0.5 * scale, 0)), 1.15 * scale);
}

void furnish_tree(atrium *scene, vector3 base)
{
    static const profile_point trunk[] = {{0.09, 0.4}, {0.06, 0.9}, {0.055, 1.5}, {0.08, 2.0}};
    add_pot(scene, base, 1.5);
    add_turned(scene, base, PROFILE(trunk), 1, vector(0.45, 0.36, 0.28));
    scene->builder->material = ATRIUM_LEAF;
    const vector3 crown = vector_add(base, vector(0, 2.45, 0));
    for (int k = 0; k < 26; ++k) {
        const vector3 offset = vector_scale(random_direction(&scene->random), 0.48);
        const double tint = random_between(&scene->random, 0.8, 1.15);
        const ball tuft = {vector_add(crown, offset), 0.30, vector_scale(vector(0.26, 0.50, 0.20), tint)};
        part_ball(scene->builder, &tuft, atrium_segments(scene, 4, 1));
    }
    for (int k = 0; k < 16; ++k) {
        const vector3 offset = vector_scale(random_direction(&scene->random), 0.76);
        const ball orange = {vector_add(crown, offset), 0.085, vector(0.98, 0.58, 0.12)};
        part_ball(scene->builder, &orange, atrium_segments(scene, 2, 1));
    }
}

void furnish_vase(atrium *scene, vector3 base, double scale, vector3 color)
{
    static const profile_point vase[] = {{0.02, 0.0},  {0.22, 0.0},  {0.20, 0.06}, {0.10, 0.12},
                                         {0.24, 0.32}, {0.34, 0.58}, {0.30, 0.82}, {0.15, 0.98},
                                         {0.14, 1.08}, {0.24, 1.16}, {0.20, 1.15}, {0.05, 1.0}};
    scene->builder->material = ATRIUM_PAINT;
    add_turned(scene, base, PROFILE(vase), scale, color);
}

/* A disc of rippled water. */
typedef struct pool {
    vector3 center;
    double radius;
} pool;

static surface_point water_point(const void *context, double u, double v)
{
    const pool *water = context;
    const double radius = water->radius * mix(0.02, 1, v);
    const double wave = sine_of_turns(7 * v);
    surface_point point;
    point.position =
        vector_add(water->center, vector(radius * cosine_of_turns(u), 0.015 * wave, radius * sine_of_turns(u)));
    point.normal = vector(0, 1, 0);
    point.color = vector_mix(vector(0.75, 0.92, 1.0), vector(0.55, 0.78, 0.92), 0.5 + 0.5 * wave);
    return point;
}

static void add_water(atrium *scene, vector3 center, double radius)
{
    const pool water = {center, radius};
    const patch_grid grid = {
        .columns = atrium_segments(scene, 40, 8), .rows = atrium_segments(scene, 16, 3), .wrap_u = true};
    scene->builder->material = ATRIUM_WATER;
    part_patch(scene->builder, grid, water_point, &water);
}

void furnish_fountain(atrium *scene, vector3 base)
{
    static const profile_point basin[] = {{1.75, 0.0},  {1.78, 0.12}, {1.62, 0.20}, {1.60, 0.48}, {1.74, 0.58},
                                          {1.74, 0.68}, {1.55, 0.70}, {1.46, 0.60}, {1.45, 0.1}};
    static const profile_point stem[] = {{0.36, 0.1},  {0.34, 0.3},  {0.20, 0.45}, {0.15, 0.8},  {0.24, 1.05},
                                         {0.15, 1.2},  {0.30, 1.35}, {0.75, 1.55}, {0.82, 1.68}, {0.72, 1.66},
                                         {0.40, 1.52}, {0.08, 1.50}, {0.10, 1.8},  {0.16, 1.95}, {0.03, 2.15}};
    const vector3 marble = vector(0.96, 0.94, 0.90);
    const uint32_t sides = atrium_segments(scene, 44, 8);
    scene->builder->material = ATRIUM_STONE;
    const turned_body outer = {base, PROFILE(basin), 1, vector_scale(marble, 0.85), marble};
    part_turned_body(scene->builder, &outer, sides, atrium_segments(scene, 18, 6));
    const turned_body inner = {base, PROFILE(stem), 1, vector_scale(marble, 0.85), marble};
    part_turned_body(scene->builder, &inner, atrium_segments(scene, 28, 6), atrium_segments(scene, 34, 10));
    add_water(scene, vector_add(base, vector(0, 0.55, 0)), 1.46);
    add_water(scene, vector_add(base, vector(0, 1.61, 0)), 0.66);
}
