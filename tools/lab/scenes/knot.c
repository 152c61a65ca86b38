/* SPDX-License-Identifier: MIT */
/*
 * knot: a tube around the (p, q) torus knot, closed and without a seam; the seed picks the knot and the phase of the
 * colors. The tube's frame is the gradient of the torus, which is smooth and closes on itself.
 */
#include "list.h"
#include "parts.h"

typedef struct knot_shape {
    double p, q; /* turns around the axis and through the hole */
    double radius; /* of the tube */
    double phase; /* phase of the colors, in turns */
} knot_shape;

static vector3 knot_center(const knot_shape *shape, double u)
{
    const double ring = 1 + 0.45 * cosine_of_turns(shape->q * u);
    return vector(ring * cosine_of_turns(shape->p * u), ring * sine_of_turns(shape->p * u),
                  0.45 * sine_of_turns(shape->q * u));
}

static vector3 knot_color(double turns)
{
    return vector(0.55 + 0.40 * cosine_of_turns(turns), 0.50 + 0.35 * cosine_of_turns(turns - 0.36),
                  0.55 + 0.40 * cosine_of_turns(turns - 0.64));
}

static surface_point knot_point(const void *context, double u, double v)
{
    const knot_shape *shape = context;
    const vector3 center = knot_center(shape, u);
    const double step = 0x1p-14;
    const vector3 along = vector_normalize(vector_subtract(knot_center(shape, u + step), knot_center(shape, u - step)));
    /* Out of the torus' surface: a frame that cannot flip. */
    const double swing = cosine_of_turns(shape->q * u);
    const vector3 rough =
        vector(swing * cosine_of_turns(shape->p * u), swing * sine_of_turns(shape->p * u), sine_of_turns(shape->q * u));
    const vector3 side = vector_normalize(vector_cross(along, rough));
    const vector3 out = vector_cross(side, along);
    surface_point point;
    point.normal =
        vector_normalize(vector_add(vector_scale(out, cosine_of_turns(v)), vector_scale(side, -sine_of_turns(v))));
    point.position = vector_add(center, vector_scale(point.normal, shape->radius));
    const double stripe = 1 - 0.22 * smooth_ramp(0.2, 0.8, cosine_of_turns(3 * v + 24 * u));
    point.color = vector_scale(knot_color(shape->phase + u), stripe);
    return point;
}

/* The sides and segments whose product is nearest to the requested count, near the ratio that gives square cells. */
static patch_grid knot_grid(uint32_t triangles, double segments_per_side)
{
    const uint32_t cells = (triangles + 1) / 2;
    const uint32_t ideal = detail_segments(sqrt(cells / segments_per_side), 1, 3);
    patch_grid best = {.columns = 16, .rows = 3, .wrap_u = true, .wrap_v = true};
    uint64_t best_error = UINT64_MAX;
    for (uint32_t rows = ideal - ideal / 4; rows <= ideal + ideal / 4; ++rows) {
        const uint32_t columns = (cells + rows / 2) / rows;
        const int64_t difference = (int64_t)2 * rows * columns - (int64_t)triangles;
        const uint64_t error = (uint64_t)(difference < 0 ? -difference : difference);
        if (rows >= 3 && columns >= 16 && error < best_error) {
            best.columns = columns;
            best.rows = rows;
            best_error = error;
        }
    }
    return best;
}

void scene_knot(scene_builder *builder, const scene_request *request)
{
    static const double turns[4][2] = {{3, 4}, {2, 3}, {2, 5}, {3, 5}};
    const uint32_t kind = request->seed % 4;
    const knot_shape shape = {
        .p = turns[kind][0], .q = turns[kind][1], .radius = 0.17, .phase = 0.1 * (double)(request->seed % 10)};
    part_patch(builder, knot_grid(request->triangles, 7 * shape.q), knot_point, &shape);
}
