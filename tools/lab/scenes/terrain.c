/* SPDX-License-Identifier: MIT */
/*
 * terrain: a heightfield of ridged fractal noise (Musgrave, in Ebert et al., "Texturing and Modeling", 1994) around a
 * lake, colored by height and slope. Exactly the requested count: the last row of cells may be incomplete.
 */
#include "list.h"
#include "parts.h"

#define LAKE_LEVEL 0.06

static double terrain_height(uint32_t seed, double x, double z)
{
    /* Bent coordinates make the ridges meander. */
    const double bend_x = 0.15 * noise(seed + 7u, vector(2 * x, 0.5, 2 * z));
    const double bend_z = 0.15 * noise(seed + 8u, vector(2 * x, 0.5, 2 * z));
    double sum = 0;
    double amplitude = 0.5;
    double frequency = 2.2;
    double weight = 1;
    for (uint32_t octave = 0; octave < 9; ++octave) {
        const vector3 at = vector((x + bend_x) * frequency, 0.37 * octave, (z + bend_z) * frequency);
        const double ridge = 1 - fabs(noise(seed + 31u * octave, at));
        const double sharp = ridge * ridge * weight;
        sum += sharp * amplitude;
        weight = clamp_to(sharp * 1.6, 0, 1);
        amplitude *= 0.48;
        frequency *= 2.05;
    }
    /* A bowl in front of the mountains, where the lake lies. */
    const double dx = x - 0.1;
    const double dz = z - 0.35;
    const double bowl = smooth_ramp(0.1, 0.75, sqrt(dx * dx * 0.6 + dz * dz));
    /* Foothills in front, so that they do not hide the rest. */
    const double foothills = mix(0.30, 1, smooth_ramp(0.8, -0.2, z));
    return (sum - 0.18) * 0.62 * mix(0.12, 1, bowl) * foothills;
}

static double land_or_lake(uint32_t seed, double x, double z)
{
    const double height = terrain_height(seed, x, z);
    return height > LAKE_LEVEL ? height : LAKE_LEVEL;
}

static vector3 terrain_color(uint32_t seed, vector3 position, double steepness, double depth)
{
    const double grain = 0.06 * fractal_noise(seed + 90u, vector_scale(position, 40), 3);
    if (depth > 0) {
        const double deep = smooth_ramp(0, 0.05, depth);
        return vector_mix(vector(0.32, 0.58, 0.62), vector(0.10, 0.27, 0.42), deep);
    }
    const vector3 sand = vector(0.78, 0.70, 0.52);
    const vector3 grass = vector(0.33, 0.46, 0.20);
    const vector3 rock = vector(0.47, 0.42, 0.38);
    const vector3 snow = vector(0.95, 0.96, 0.98);
    const double height = position.y + grain * 0.5;
    vector3 color = vector_mix(sand, grass, smooth_ramp(LAKE_LEVEL + 0.004, LAKE_LEVEL + 0.02, height));
    color = vector_mix(color, rock, smooth_ramp(0.15, 0.25, height));
    color = vector_mix(color, rock, smooth_ramp(0.25, 0.5, steepness));
    color = vector_mix(color, snow, smooth_ramp(0.24, 0.31, height) * (1 - smooth_ramp(0.45, 0.75, steepness)));
    return vector_scale(color, 1 + grain);
}

static surface_point terrain_point(uint32_t seed, double x, double z)
{
    const double step = 0x1p-11;
    const double slope_x = (land_or_lake(seed, x + step, z) - land_or_lake(seed, x - step, z)) / (2 * step);
    const double slope_z = (land_or_lake(seed, x, z + step) - land_or_lake(seed, x, z - step)) / (2 * step);
    const double height = terrain_height(seed, x, z);
    surface_point point;
    point.position = vector(x, height > LAKE_LEVEL ? height : LAKE_LEVEL, z);
    point.normal = vector_normalize(vector(-slope_x, 1, -slope_z));
    point.color = terrain_color(seed, point.position, 1 - point.normal.y, LAKE_LEVEL - height);
    return point;
}

void scene_terrain(scene_builder *builder, const scene_request *request)
{
    const uint32_t columns = detail_segments(sqrt(request->triangles / 2.0), 1, 1);
    const uint32_t per_row = 2 * columns;
    const uint32_t rows = (request->triangles + per_row - 1) / per_row;
    const double cell = 2.0 / columns;
    /* From the back row to the front, so that an incomplete row is the front edge. */
    for (uint32_t row = 0; row <= rows; ++row) {
        for (uint32_t column = 0; column <= columns; ++column) {
            const surface_point point = terrain_point(request->seed, cell * column - 1, cell * row - 1);
            builder_vertex(builder, &point);
        }
    }
    for (uint32_t triangle = 0; triangle < request->triangles; ++triangle) {
        const uint32_t corner = triangle / per_row * (columns + 1) + triangle % per_row / 2;
        if (triangle % 2 == 0) {
            builder_triangle(builder, corner, corner + columns + 1, corner + columns + 2);
        } else {
            builder_triangle(builder, corner, corner + columns + 2, corner + 1);
        }
    }
}
