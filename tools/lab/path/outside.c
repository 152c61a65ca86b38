/* SPDX-License-Identifier: MIT */
/* The radiance that comes from outside, in double precision: what kernels/light/sky.clh is compared with. */
#include "path/outside.h"

#include <math.h>

#define PI 3.14159265358979323846

/* The column or row at an index that may be beyond the last one. */
static size_t wrapped(double index, uint32_t columns)
{
    const double turn = fmod(index, columns);
    return (size_t)(turn < 0 ? turn + columns : turn);
}

static size_t clamped(double index, uint32_t rows)
{
    return (size_t)fmin(fmax(index, 0), rows - 1.0);
}

void path_outside(const svo_light_setup *setup, vector3 direction, double radiance[3])
{
    for (int channel = 0; channel < 3; ++channel) {
        radiance[channel] = (double)setup->sky[channel];
    }
    if (setup->sky_map == NULL) {
        return;
    }
    const double length = sqrt(vector_dot(direction, direction));
    const double cosine = fmin(fmax(direction.y / length, -1), 1);
    const double x = (0.5 + atan2(direction.x, -direction.z) / (2 * PI)) * setup->sky_width - 0.5;
    const double y = acos(cosine) / PI * setup->sky_height - 0.5;
    for (int corner = 0; corner < 4; ++corner) {
        const double right = corner % 2;
        const double lower = corner >= 2;
        const double share =
            (right > 0 ? x - floor(x) : 1 - x + floor(x)) * (lower > 0 ? y - floor(y) : 1 - y + floor(y));
        const size_t texel = clamped(floor(y) + lower, setup->sky_height) * setup->sky_width +
                             wrapped(floor(x) + right, setup->sky_width);
        for (size_t channel = 0; channel < 3; ++channel) {
            radiance[channel] += share * (double)setup->sky_map[3 * texel + channel];
        }
    }
}
