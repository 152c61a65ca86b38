/* SPDX-License-Identifier: MIT */
/*
 * needles: slivers from a hundred to a million times longer than wide, in every direction, in a ball: the hard case for
 * rasterizers, whose projected triangles cover pixels without covering their centers. Exactly the requested count.
 */
#include "list.h"
#include "parts.h"

static vector3 needle_color(double slimness)
{
    const vector3 blunt = vector(0.98, 0.80, 0.35);
    const vector3 middle = vector(0.85, 0.30, 0.35);
    const vector3 slim = vector(0.30, 0.40, 0.80);
    return slimness < 0.5 ? vector_mix(blunt, middle, 2 * slimness) : vector_mix(middle, slim, 2 * slimness - 1);
}

static void add_needle(scene_builder *builder, random_stream *stream)
{
    const vector3 along = random_direction(stream);
    const vector3 across = vector_normalize(vector_cross(along, random_direction(stream)));
    /* One draw per statement: C leaves the evaluation order of arguments open. */
    const vector3 outwards = random_direction(stream);
    const vector3 middle = vector_scale(outwards, 0.6 * sqrt(random_between(stream, 0, 1)));
    const double length = random_between(stream, 0.05, 0.7);
    /* The aspect is 2^e * f: nearly log-uniform from 100 to 1,000,000 without an exponential function. */
    double aspect = 100 * random_between(stream, 1, 2);
    const uint32_t doublings = (uint32_t)floor(random_between(stream, 0, 13));
    for (uint32_t k = 0; k < doublings; ++k) {
        aspect *= 2;
    }
    aspect = clamp_to(aspect, 1e2, 1e6);
    const vector3 half = vector_scale(along, 0.5 * length);
    surface_point point;
    point.normal = vector_normalize(vector_cross(along, across));
    point.color = needle_color(doublings / 13.0);
    point.position = vector_subtract(middle, half);
    const uint32_t tail = builder_vertex(builder, &point);
    point.position = vector_add(middle, half);
    const uint32_t tip = builder_vertex(builder, &point);
    point.position = vector_add(vector_subtract(middle, half), vector_scale(across, length / aspect));
    const uint32_t edge = builder_vertex(builder, &point);
    builder_triangle(builder, tail, tip, edge);
}

void scene_needles(scene_builder *builder, const scene_request *request)
{
    random_stream stream = {.state = request->seed};
    for (uint32_t needle = 0; needle < request->triangles; ++needle) {
        add_needle(builder, &stream);
    }
}
