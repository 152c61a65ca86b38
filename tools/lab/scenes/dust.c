/* SPDX-License-Identifier: MIT */
/*
 * dust: a spiral galaxy of triangles far smaller than a voxel: the load case of long leaf lists. One triangle in
 * sixteen falls into one of four cells of 2^-14 of the scene's width, so their lists are very long at any depth.
 * Exactly the requested count.
 */
#include "list.h"
#include "parts.h"

#define DENSE_CELLS 4

typedef struct dust_grain {
    vector3 center;
    vector3 color;
    double spread; /* half the width of the place it is put in */
} dust_grain;

/* The sum of four uniform numbers: bell-shaped, within -1 and 1. */
static double bell(random_stream *stream)
{
    double sum = 0;
    for (int k = 0; k < 4; ++k) {
        sum += random_between(stream, -0.25, 0.25);
    }
    return sum;
}

/* Two arms that wind once around the center, denser and thicker inside. */
static dust_grain arm_grain(random_stream *stream)
{
    const double along = random_between(stream, 0, 1);
    const double radius = 0.06 + 0.9 * along * along;
    const double arm = random_between(stream, 0, 1) < 0.5 ? 0 : 0.5;
    const double turns = arm + 1.1 * sqrt(radius) + 0.16 * bell(stream);
    const double reach = radius * (1 + 0.25 * bell(stream));
    dust_grain grain = {.spread = 0};
    grain.center =
        vector(reach * cosine_of_turns(turns), 0.07 * bell(stream) * (1.2 - radius), reach * sine_of_turns(turns));
    const vector3 inner = vector(0.98, 0.86, 0.62);
    const vector3 outer = vector(0.40, 0.52, 0.88);
    grain.color = vector_mix(inner, outer, clamp_to(1.5 * radius, 0, 1));
    if (random_between(stream, 0, 1) < 0.06) {
        grain.color = vector(0.92, 0.42, 0.55);
    }
    return grain;
}

static dust_grain bulge_grain(random_stream *stream)
{
    const double radius = 0.28 * bell(stream);
    dust_grain grain = {.spread = 0};
    const vector3 direction = random_direction(stream);
    grain.center = vector_scale(vector(direction.x, 0.7 * direction.y, direction.z), radius);
    grain.color = vector_mix(vector(1.0, 0.93, 0.75), vector(0.95, 0.70, 0.45), clamp_to(4 * fabs(radius), 0, 1));
    return grain;
}

/* The middles of the dense cells lie half a cell off every coarser grid line around the center. */
static dust_grain dense_grain(random_stream *stream)
{
    const double cell = 0x1p-13;
    const double quarter = floor(random_between(stream, 0, DENSE_CELLS)) / DENSE_CELLS;
    dust_grain grain = {.spread = 0.25 * cell};
    grain.center = vector((floor(0.5 * cosine_of_turns(quarter + 0.125) / cell) + 0.5) * cell, 0.5 * cell,
                          (floor(0.5 * sine_of_turns(quarter + 0.125) / cell) + 0.5) * cell);
    grain.color = vector(1, 1, 1);
    return grain;
}

static void add_grain(scene_builder *builder, random_stream *stream, const dust_grain *grain)
{
    vector3 center = grain->center;
    center.x += random_between(stream, -1, 1) * grain->spread;
    center.y += random_between(stream, -1, 1) * grain->spread;
    center.z += random_between(stream, -1, 1) * grain->spread;
    const double radius = random_between(stream, 0x1p-17, 0x1p-15);
    vector3 corners[3];
    for (int k = 0; k < 3; ++k) {
        corners[k] = vector_add(center, vector_scale(random_direction(stream), radius));
    }
    surface_point point = {.color = grain->color};
    point.normal = vector_normalize(
        vector_cross(vector_subtract(corners[1], corners[0]), vector_subtract(corners[2], corners[0])));
    uint32_t vertices[3];
    for (int k = 0; k < 3; ++k) {
        point.position = corners[k];
        vertices[k] = builder_vertex(builder, &point);
    }
    builder_triangle(builder, vertices[0], vertices[1], vertices[2]);
}

void scene_dust(scene_builder *builder, const scene_request *request)
{
    random_stream stream = {.state = request->seed};
    for (uint32_t triangle = 0; triangle < request->triangles; ++triangle) {
        const dust_grain grain = triangle % 16 == 0  ? dense_grain(&stream)
                                 : triangle % 4 == 1 ? bulge_grain(&stream)
                                                     : arm_grain(&stream);
        add_grain(builder, &stream, &grain);
    }
}
