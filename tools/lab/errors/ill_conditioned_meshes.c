/* SPDX-License-Identifier: MIT */
/* Coordinates are no multiples of powers of two, so that float32 has to round. */
#include "errors/ill_conditioned_meshes.h"

#include <math.h>

#define SEED      UINT64_C(20260301)
#define UNIT_EDGE 0.31 /* of a triangle at scale ratio 1 */

const char *conditioning_name(conditioning family)
{
    static const char *const names[CONDITIONING_COUNT] = {"aspect ratio", "offset from the origin", "scale ratio"};
    return names[family];
}

static double between(random_stream *random, double low, double high)
{
    return low + (high - low) * (double)(random_bits(random) >> 11) * 0x1p-53;
}

/* A segment of that length in a random direction, and a third vertex at that height over a point of it. */
static void make_triangle(random_stream *random, double length, double height, double corners[9])
{
    const vector3 along = random_direction(random);
    const vector3 other = random_direction(random);
    vector3 across = vector_cross(along, other);
    across = vector_scale(across, 1.0 / fmax(vector_length(across), 1e-9));
    const vector3 first =
        vector(between(random, UNIT_EDGE, 1.0 - UNIT_EDGE), between(random, UNIT_EDGE, 1.0 - UNIT_EDGE),
               between(random, UNIT_EDGE, 1.0 - UNIT_EDGE));
    const vector3 second = vector_add(first, vector_scale(along, length));
    const vector3 third =
        vector_add(vector_mix(first, second, between(random, 0.2, 0.8)), vector_scale(across, height));
    const vector3 all[3] = {first, second, third};
    for (size_t i = 0; i < 3; ++i) {
        corners[3 * i] = all[i].x;
        corners[3 * i + 1] = all[i].y;
        corners[3 * i + 2] = all[i].z;
    }
}

/* A triangle that is one corner of the unit cube: two of them fix the fitted grid, whatever the others are. */
static void pin_grid(double corner, double corners[9])
{
    for (int i = 0; i < 9; ++i) {
        corners[i] = corner;
    }
}

bool ill_conditioned_triangles(conditioning family, double value, size_t triangle_count, triangle_set *out)
{
    random_stream random = {SEED};
    if (!triangle_set_empty(triangle_count, out)) {
        return false;
    }
    const double length = family == CONDITIONING_SCALE ? UNIT_EDGE / value : UNIT_EDGE;
    const double height = family == CONDITIONING_ASPECT ? length / value : 0.6 * length;
    pin_grid(0.0, out->positions);
    pin_grid(1.0, out->positions + 9);
    for (size_t t = 2; t < triangle_count; ++t) {
        make_triangle(&random, length, height, out->positions + t * 9);
    }
    if (family == CONDITIONING_OFFSET) {
        triangle_set_move(out, 1.0, value);
    }
    return true;
}

void ill_conditioned_positions(const svo_mesh *mesh, conditioning family, double value, double *out)
{
    double width = 0.0;
    for (size_t i = 0; i < mesh->vertex_count * 3; ++i) {
        out[i] = (double)mesh->positions[i];
        width = fmax(width, fabs(out[i]));
    }
    for (size_t i = 0; i < mesh->vertex_count * 3; ++i) {
        out[i] = out[i] / width / (family == CONDITIONING_ASPECT && i % 3 == 1 ? value : 1.0) +
                 (family == CONDITIONING_OFFSET ? value : 0.0);
    }
}
