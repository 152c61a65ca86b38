/* SPDX-License-Identifier: MIT */
/*
 * Light of a picture by few rays or cones: gathered at the middle of each 2 x 2 pixels, and smoothed over surfaces.
 *
 *   svo_k_screen_points  per cell: the surface that its middle shows and what it mirrors, as a point for
 *                        svo_k_gather_rays; without a normal where nothing is
 *   svo_k_screen_guide   per cell: the mean light of the cells around it, and its standard errors
 *   svo_k_screen_filter  per cell: one step of an edge-avoiding wavelet filter (Dammertz et al., "Edge-Avoiding A-Trous
 *                        Wavelet Transform for Fast Global Illumination Filtering", 2010). Neighbors count by how far
 *                        they lie on the cell's plane, and by how much the light around them differs beside its
 *                        standard error (after Schied et al., "Spatiotemporal Variance-Guided Filtering", 2017). By
 *                        their own light, cells that find rare light would not give it to those that do not
 *
 * Launch: one work-item per cell of a band, screen.columns x screen.rows from row screen.first_row on. No atomics, no
 * local memory.
 */
#include "light/screen.clh"

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_screen_points(SVO_LIT_PARAMETERS, __global svo_gather_point *points, svo_screen_params screen)
{
    const uint item = (uint)get_global_id(0);
    if (item >= screen.columns * screen.rows) {
        return;
    }
    SVO_LIT_MAKE(picture);
    const uint2 cell = (uint2)(item % screen.columns, screen.first_row + item / screen.columns);
    svo_ray ray = svo_screen_ray(&picture, 2.0f * convert_float2(cell) + 1.0f);
    svo_gather_point point = {{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}, 0.0f, {0u, 0u}};
    svo_lit_met met;
    svo_lit_through through = svo_lit_start(params.sample_width);
    const svo_alpha_ray alone = {0u, 1u};
    uint found = SVO_LIT_ON;
    while (found == SVO_LIT_ON) {
        found = svo_lit_search(&picture, &ray, false, alone, &through, &met);
    }
    if (found == SVO_LIT_MET) {
        svo_lit_surface surface;
        svo_lit_place(&picture, &ray, &met, through.widening, &surface);
        vstore3(surface.point, 0, point.position);
        const float3 normal = svo_screen_normal(&picture, &surface);
        vstore3(normal, 0, point.normal);
        if (any(normal != surface.face)) {
            svo_screen_put_face(surface.face, &point);
        }
        svo_lit_seen(&picture, &surface);
        if (svo_lit_reflects(&picture, &surface)) {
            vstore3(svo_lit_mirrored(&surface, vload3(0, ray.direction)), 0, point.reflected);
            point.exponent = surface.exponent;
        }
    }
    points[item] = point;
}

/* Of the cubic spline, 16 in all. */
static float svo_screen_spline(uint away)
{
    return away == 0u ? 6.0f : away == 1u ? 4.0f : 1.0f;
}

static float svo_screen_brightness(float4 light)
{
    return 0.2126f * light.x + 0.7152f * light.y + 0.0722f * light.z;
}

/* The light of a cell before a step: irradiance and openness, or specular light. from: of the step before it; NULL:
   what was gathered. */
static float4 svo_screen_gathered(__global const svo_gather_result *gathered, __global const float4 *from,
                                  svo_screen_params screen, size_t cell)
{
    __global const svo_gather_result *of = gathered + cell;
    const float3 light = vload3(0, screen.is_specular != 0u ? of->specular : of->irradiance);
    return from != NULL ? from[cell] : (float4)(light, of->openness);
}

/* Of irradiance or specular light, and of openness: the means x and y, brightness for light, and their standard errors
   z and w. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_screen_guide(__global const svo_gather_result *gathered, __global float4 *guide, svo_screen_params screen)
{
    const uint item = (uint)get_global_id(0);
    if (item >= screen.columns * screen.rows) {
        return;
    }
    const int2 at = (int2)((int)(item % screen.columns), (int)(item / screen.columns));
    float2 means = (float2)(0.0f);
    float2 squares = (float2)(0.0f);
    float count = 0.0f;
    for (int k = 0; k < 9; ++k) {
        const int2 near = at + (int2)(k % 3 - 1, k / 3 - 1);
        if (near.x >= 0 && near.x < (int)screen.columns && near.y >= 0 && near.y < (int)screen.rows) {
            const size_t cell = (size_t)near.y * screen.columns + (size_t)near.x;
            __global const svo_gather_result *of = gathered + cell;
            const float4 light = svo_screen_gathered(gathered, NULL, screen, cell);
            const float2 error =
                (float2)(screen.is_specular != 0u ? of->specular_error : of->irradiance_error, of->openness_error);
            means += (float2)(svo_screen_brightness(light), light.w);
            squares += error * error;
            count += 1.0f;
        }
    }
    guide[item] = (float4)(means / count, sqrt(squares / count));
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_screen_filter(__global const svo_gather_point *points, __global const svo_gather_result *gathered,
                    __global const float4 *guide, __global const float4 *from, __global float4 *to,
                    svo_screen_params screen)
{
    const uint item = (uint)get_global_id(0);
    if (item >= screen.columns * screen.rows) {
        return;
    }
    const int2 at = (int2)((int)(item % screen.columns), (int)(item / screen.columns));
    const svo_screen_surface surface = svo_screen_surface_of(points + item);
    const float4 own = svo_screen_gathered(gathered, from, screen, item);
    if (!(dot(surface.normal, surface.normal) > 0.0f)) {
        to[item] = own;
        return;
    }
    const float4 guided = guide[item];
    float4 sum = (float4)(0.0f);
    float light_weights = 0.0f;
    float openness_weights = 0.0f;
    for (int k = 0; k < 25; ++k) {
        const int2 away = (int2)(k % 5 - 2, k / 5 - 2);
        const int2 near = at + (int)screen.step * away;
        if (near.x < 0 || near.x >= (int)screen.columns || near.y < 0 || near.y >= (int)screen.rows) {
            continue;
        }
        const size_t cell = (size_t)near.y * screen.columns + (size_t)near.x;
        const float4 light = svo_screen_gathered(gathered, from, screen, cell);
        const uint2 far = abs(away);
        const float spline = svo_screen_spline(far.x) * svo_screen_spline(far.y);
        const float alike = k == 12 ? spline : spline * svo_screen_alike(&surface, points + cell);
        const float4 other = guide[cell];
        const float2 differs =
            fabs(other.xy - guided.xy) / (screen.tolerance * fmax(other.zw, guided.zw) + (float2)(1e-6f));
        const float light_weight = alike * exp(-differs.x);
        const float openness_weight = alike * exp(-differs.y);
        sum.xyz += light_weight * light.xyz;
        sum.w += openness_weight * light.w;
        light_weights += light_weight;
        openness_weights += openness_weight;
    }
    to[item] = (float4)(sum.xyz / light_weights, sum.w / openness_weights);
}
