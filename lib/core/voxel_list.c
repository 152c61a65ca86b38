/* SPDX-License-Identifier: MIT */
/*
 * The order of lists of voxels: a stable radix sort, least significant digit first (Knuth, "The Art of Computer
 * Programming", volume 3, 5.2.5). Keys are computed anew in each pass, which costs less than the memory to keep them.
 */
#include "core/voxel_list.h"

#include <math.h>
#include <string.h>

#include "shared/nodes.clh"

#define DIGIT_BITS 11u
#define DIGITS     (1u << DIGIT_BITS)
#define PLACE_MAX  0x1p50 /* whole numbers up to here are doubles, and so are their neighbors */

static void cell_of(const svo_voxel *voxel, const int32_t low[3], uint32_t cell[3])
{
    cell[0] = (uint32_t)(voxel->x - low[0]);
    cell[1] = (uint32_t)(voxel->y - low[1]);
    cell[2] = (uint32_t)(voxel->z - low[2]);
}

uint64_t svo_i_voxel_code(const svo_voxel *voxel, const int32_t low[3])
{
    uint32_t cell[3];
    cell_of(voxel, low, cell);
    return svo_interleave(cell);
}

static uint64_t key_of(const svo_voxel *voxel, const int32_t low[3], uint32_t bits, svo_i_voxel_order order)
{
    uint32_t cell[3];
    cell_of(voxel, low, cell);
    switch (order) {
    case SVO_I_VOXEL_ROWS:
        return ((uint64_t)cell[0] << bits | cell[2]) << bits | cell[1];
    case SVO_I_VOXEL_SLICES:
        return ((uint64_t)cell[1] << bits | cell[2]) << bits | cell[0];
    default:
        return svo_interleave(cell);
    }
}

void svo_i_voxel_sort(svo_voxel *voxels, svo_voxel *spare, size_t count, const int32_t low[3], uint32_t bits,
                      svo_i_voxel_order order)
{
    svo_voxel *from = voxels;
    svo_voxel *to = spare;
    for (uint32_t shift = 0; shift < 3 * bits; shift += DIGIT_BITS) {
        size_t slots[DIGITS] = {0};
        for (size_t i = 0; i < count; ++i) {
            ++slots[key_of(&from[i], low, bits, order) >> shift & (DIGITS - 1)];
        }
        size_t sum = 0;
        for (size_t digit = 0; digit < DIGITS; ++digit) {
            const size_t here = slots[digit];
            slots[digit] = sum;
            sum += here;
        }
        for (size_t i = 0; i < count; ++i) {
            to[slots[key_of(&from[i], low, bits, order) >> shift & (DIGITS - 1)]++] = from[i];
        }
        svo_voxel *sorted = to;
        to = from;
        from = sorted;
    }
    if (from != voxels) {
        memcpy(voxels, from, count * sizeof *voxels);
    }
}

uint32_t svo_i_voxel_bits(const int32_t low[3], const int32_t high[3])
{
    uint32_t bits = 0;
    for (int axis = 0; axis < 3; ++axis) {
        while (high[axis] - low[axis] > 1 << bits) {
            ++bits;
        }
    }
    return bits;
}

double svo_i_voxel_plane(double value, double width)
{
    double place = floor(value / width);
    if (!(fabs(place) < PLACE_MAX)) {
        return NAN;
    }
    while (place * width > value) {
        place -= 1.0;
    }
    while ((place + 1.0) * width <= value) {
        place += 1.0;
    }
    return place * width + 0.0; /* + 0.0 turns -0 into 0; their hashes differ */
}
