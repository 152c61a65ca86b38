/* SPDX-License-Identifier: MIT */
/* The crossings of solids, compiled as the functions CROSSING_PROBE. */
#include "crossing_probe.h"

#include <string.h>

#include "shared/decide.clh"
#include "shared/snap.clh"
#include "solid/crossing.clh"

static int cross_snapped(const int32_t *corners, const int32_t *errors, uint32_t axis, const int32_t point[2],
                         int32_t low, int32_t high)
{
    return svo_cross_snapped(corners, errors, axis, point, low, high);
}

static void load(const crossing_pair *pair, svo_decide_params *grid, svo_decided_pair *out)
{
    static const uint32_t indices[3] = {0, 1, 2};
    *grid = (svo_decide_params){.is_double = 1, .depth = pair->depth};
    memcpy(grid->origin, pair->origin, sizeof grid->origin);
    memcpy(grid->edge, &pair->edge, sizeof grid->edge);
    svo_load_pair(pair->vertices, indices, 0, pair->cell, grid, out);
}

static int cross_near(const crossing_pair *pair, uint32_t axis, bool upper)
{
    svo_decide_params grid;
    svo_decided_pair loaded;
    svo_near_triangle triangle;
    load(pair, &grid, &loaded);
    svo_make_near(&loaded, &grid, &triangle);
    return svo_doubles_hold(&grid) ? svo_cross_near(&triangle, axis, upper) : CROSSING_UNDECIDED;
}

static int cross_exactly(const crossing_pair *pair, uint32_t axis, bool upper)
{
    svo_decide_params grid;
    svo_decided_pair loaded;
    svo_exact_triangle placed;
    load(pair, &grid, &loaded);
    const svo_short width = svo_decided_width(&grid);
    svo_place_exactly(&loaded, &grid, width, &placed);
    return svo_cross_exactly(&placed, width, axis, upper);
}

const crossing_functions CROSSING_PROBE = {cross_snapped, cross_near, cross_exactly};

#ifdef CROSSING_SOUND
void crossing_snap(const crossing_pair *pair, int snap_bits, int32_t corners[9], int32_t errors[3])
{
    const svo_snap snap = svo_make_snap(ldexp(1.0, snap_bits) / pair->edge, pair->edge, snap_bits);
    memset(errors, 0, 3 * sizeof errors[0]);
    for (int i = 0; i < 9; ++i) {
        corners[i] = svo_snap_coordinate(&snap, pair->vertices[i], pair->origin[i % 3]);
        errors[i % 3] |= corners[i] & 1;
    }
}

int crossing_sign(const int64_t a[3], const int32_t b[3])
{
    return svo_sign_of_words(svo_dot(a, b), 0);
}
#endif
