/* SPDX-License-Identifier: MIT */
/* The crossings of solids, compiled as the function CROSSING_PROBE. */
#include "crossing_probe.h"

#include "solid/crossing.clh"

int CROSSING_PROBE(const int32_t *corners, uint32_t axis, const int32_t point[2], int32_t low, int32_t high)
{
    svo_side_view seen;
    const int sense = svo_cross_line(corners, axis, point, &seen);
    return sense != 0 && !svo_crosses_below(&seen, point, low) && svo_crosses_below(&seen, point, high) ? sense : 0;
}

#ifdef CROSSING_SOUND
int crossing_sign(const int64_t a[3], const int32_t b[3])
{
    return svo_sign_of_dot(a, b);
}
#endif
