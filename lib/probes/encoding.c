/* SPDX-License-Identifier: MIT */
/*
 * What texels store, on the host: the twin of kernels/probes/octahedral.clh and encoding.clh.
 *
 * Powers are made of square roots and products alone, which every host rounds alike; a library's pow() may differ in
 * its last bit, and with it the codes of a few distances.
 */
#include "probes/encoding.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "shared/probe_layout.h"
#include "svocl/probes.h"

/* ---- distances ---- */

/* Bits of an exponent. */
#define POWER_BITS 44

/* A number's powers by 1/2, 1/4, ... */
typedef struct powers {
    double base, root[POWER_BITS];
} powers;

static powers powers_of(double base)
{
    powers out = {.base = base};
    double root = base;
    for (int i = 0; i < POWER_BITS; ++i) {
        root = sqrt(root);
        out.root[i] = root;
    }
    return out;
}

/* base^exponent, 0 <= exponent <= 1. */
static double power(const powers *of, double exponent)
{
    double product = 1;
    if (exponent >= 1) {
        return of->base;
    }
    for (int i = 0; i < POWER_BITS; ++i) {
        exponent *= 2;
        if (exponent >= 1) {
            exponent -= 1;
            product *= of->root[i];
        }
    }
    return product;
}

void svo_i_probe_thresholds(float farthest, float leaf_edge, uint64_t thresholds[SVO_I_PROBE_CODES])
{
    const powers grown = powers_of(svo_i_probe_growth(farthest, leaf_edge));
    thresholds[0] = 0;
    for (uint32_t code = 1; code < SVO_I_PROBE_CODES; ++code) {
        const double distance = (power(&grown, ((double)code - 0.5) / SVO_PROBE_CODE_MAX) - 1) * (double)leaf_edge;
        const double squared = distance * distance;
        memcpy(&thresholds[code], &squared, sizeof squared);
    }
}

void svo_i_probe_lengths(float farthest, float leaf_edge, uint32_t lengths[SVO_I_PROBE_CODES])
{
    const powers grown = powers_of(svo_i_probe_growth(farthest, leaf_edge));
    for (uint32_t code = 0; code < SVO_I_PROBE_CODES; ++code) {
        const double leaf_edges = power(&grown, (double)code / SVO_PROBE_CODE_MAX) - 1;
        const double parts = leaf_edges * SVO_PROBE_LENGTH_UNIT + 0.5;
        lengths[code] = parts < SVO_PROBE_LENGTH_MAX ? (uint32_t)parts : SVO_PROBE_LENGTH_MAX;
    }
}

double svo_probe_distance(const svo_probe_info *info, uint32_t code)
{
    if (code > SVO_PROBE_CODE_MAX) {
        return INFINITY;
    }
    const powers grown = powers_of(svo_i_probe_growth(info->farthest, info->leaf_edge));
    return (power(&grown, (double)code / SVO_PROBE_CODE_MAX) - 1) * (double)info->leaf_edge;
}

/* ---- directions ---- */

/* 1 for 0. */
static double sign(double v)
{
    return v >= 0 ? 1 : -1;
}

/* The unit direction of a point of the square. */
static void direction_of(double x, double y, float direction[3])
{
    const double z = 1 - fabs(x) - fabs(y);
    const double across = z < 0 ? (1 - fabs(y)) * sign(x) : x;
    const double along = z < 0 ? (1 - fabs(x)) * sign(y) : y;
    const double length = sqrt(across * across + along * along + z * z);
    direction[0] = (float)(across / length);
    direction[1] = (float)(along / length);
    direction[2] = (float)(z / length);
}

void svo_probe_direction(uint32_t resolution, uint32_t column, uint32_t row, float direction[3])
{
    direction_of((2.0 * column + 1) / resolution - 1, (2.0 * row + 1) / resolution - 1, direction);
}

void svo_i_probe_texel_vector(uint32_t resolution, uint32_t column, uint32_t row, int32_t vector[3])
{
    const int32_t edge = (int32_t)resolution;
    const int32_t x = 2 * (int32_t)column + 1 - edge;
    const int32_t y = 2 * (int32_t)row + 1 - edge;
    const int32_t across = edge - (y < 0 ? -y : y);
    const int32_t along = edge - (x < 0 ? -x : x);
    const int32_t z = across + along - edge;
    vector[0] = z >= 0 ? x : x >= 0 ? across : -across;
    vector[1] = z >= 0 ? y : y >= 0 ? along : -along;
    vector[2] = z;
}

/* The column of coordinate a / sum, both of them sums of floats. */
static uint32_t column_of(double a, double sum, uint32_t resolution)
{
    const double column = floor((a / sum + 1) / 2 * resolution);
    return column < 0 ? 0 : column >= resolution ? resolution - 1 : (uint32_t)column;
}

void svo_probe_texel(uint32_t resolution, const float direction[3], uint32_t *column, uint32_t *row)
{
    const double x = (double)direction[0];
    const double y = (double)direction[1];
    const double sum = fabs(x) + fabs(y) + fabs((double)direction[2]);
    const bool folds = direction[2] < 0.0F;
    *column = column_of(folds ? (sum - fabs(y)) * sign(x) : x, sum, resolution);
    *row = column_of(folds ? (sum - fabs(x)) * sign(y) : y, sum, resolution);
}

void svo_probe_normal(uint32_t word, float normal[3])
{
    const int column = (int)(word >> 16 & 0xffu);
    const int row = (int)(word >> 24);
    direction_of((column > 127 ? column - 256 : column) / 127.0, (row > 127 ? row - 256 : row) / 127.0, normal);
}

/* ---- radiance ---- */

/* An unsigned float with 5 bits of exponent. */
static float small_float(uint32_t code, int mantissa_bits)
{
    const uint32_t exponent = code >> mantissa_bits;
    const uint32_t mantissa = code & ((1u << mantissa_bits) - 1);
    return exponent == 0 ? ldexpf((float)mantissa, -14 - mantissa_bits)
                         : ldexpf((float)(mantissa + (1u << mantissa_bits)), (int)exponent - 15 - mantissa_bits);
}

void svo_probe_radiance(uint32_t word, float radiance[3])
{
    radiance[0] = small_float(word & 0x7ffu, 6);
    radiance[1] = small_float(word >> 11 & 0x7ffu, 6);
    radiance[2] = small_float(word >> 22, 5);
}
