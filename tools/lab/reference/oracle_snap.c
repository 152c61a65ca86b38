/* SPDX-License-Identifier: MIT */
/*
 * Reference for the grid and the snap, without double arithmetic: in 128-bit integers. The grid is defined in doubles,
 * and rounded where its definition rounds; the snap is defined in real numbers. So this file shares neither the
 * contraction of the compiler, nor the rounding mode, nor a mistake in the order of operations of the library.
 */
#include "oracle.h"

#include <float.h>
#include <math.h>

__extension__ typedef __int128 wide;

#define SIGNIFICAND_BITS 53

/* value * 2^exponent, exact */
typedef struct number {
    wide value;
    int exponent;
} number;

static number number_of(double value)
{
    int exponent;
    double fraction = frexp(value, &exponent);

    return (number){(wide)(int64_t)ldexp(fraction, SIGNIFICAND_BITS), exponent - SIGNIFICAND_BITS};
}

static int bit_count(wide magnitude)
{
    int count = 0;

    for (; magnitude > 0; magnitude >>= 1)
        count++;
    return count;
}

/* value / 2^shift to the nearest integer, ties to the even one. */
static wide shift_right_to_even(wide value, int shift)
{
    wide magnitude = value < 0 ? -value : value, quotient, rest, half;

    if (shift <= 0)
        return value;
    if (shift > 125)
        return 0;
    quotient = magnitude >> shift;
    rest = magnitude - (quotient << shift);
    half = (wide)1 << (shift - 1);
    if (rest > half || (rest == half && (quotient & 1)))
        quotient++;
    return value < 0 ? -quotient : quotient;
}

/* The nearest double, ties to even, for values in the normal range. */
static number round_to_double(number exact)
{
    int excess = bit_count(exact.value < 0 ? -exact.value : exact.value) - SIGNIFICAND_BITS;

    if (excess <= 0)
        return exact;
    return (number){shift_right_to_even(exact.value, excess), exact.exponent + excess};
}

static double number_to_double(number rounded)
{
    return ldexp((double)rounded.value, rounded.exponent);
}

/*
 * a - b, exact where their lowest bits are at most 70 bits apart. Else of the lower number only the sign is kept, as
 * the lowest bit below the other, which is moved left by 70 bits: all that rounding the difference can depend on.
 */
static number difference(double a, double b)
{
    number x = number_of(a), y = number_of(-b);
    number *high = x.exponent >= y.exponent ? &x : &y, *low = high == &x ? &y : &x;
    int distance;

    if (high->value == 0 || low->value == 0)
        return high->value == 0 ? *low : *high;
    distance = high->exponent - low->exponent;
    if (distance > 70) {
        low->value = low->value < 0 ? -1 : 1;
        distance = 70;
    }
    return (number){high->value * ((wide)1 << distance) + low->value, high->exponent - distance};
}

/* a - b, rounded to double. */
static double subtract(double a, double b)
{
    return number_to_double(round_to_double(difference(a, b)));
}

/* 2^bits / edge, rounded to double. */
static double divide(unsigned bits, double edge)
{
    number divisor = number_of(edge);
    wide dividend = (wide)1 << 124, quotient = dividend / divisor.value;

    /* A last bit that says "and a little more" settles what would look like a tie. */
    quotient = quotient << 1 | (quotient * divisor.value != dividend);
    return number_to_double(round_to_double((number){quotient, (int)bits - 125 - divisor.exponent}));
}

/* extent * (1 + 2^-20), rounded to double, then up to 24 significant bits. */
static double edge_around(double extent)
{
    number x = number_of(extent), product, edge;
    int excess;

    product = round_to_double((number){x.value * ((1 << 20) + 1), x.exponent - 20});
    excess = bit_count(product.value) - 24;
    edge = (number){product.value >> excess, product.exponent + excess};
    if (edge.value << excess != product.value)
        edge.value++;
    return number_to_double(edge);
}

static bool is_positive_normal(double value)
{
    return value >= DBL_MIN && value <= DBL_MAX;
}

bool oracle_triangle_accepted(const oracle_positions *mesh, size_t triangle_index, uint32_t vertex_indices[3])
{
    for (size_t i = 0; i < 3; i++) {
        size_t corner = 3 * triangle_index + i;
        size_t vertex_index = mesh->indices ? mesh->indices[corner] : corner;

        if (vertex_index >= mesh->vertex_count)
            return false;
        for (size_t k = 0; k < 3; k++)
            if (!isfinite(mesh->positions[3 * vertex_index + k]))
                return false;
        vertex_indices[i] = (uint32_t)vertex_index;
    }
    return true;
}

/* Bounds of the accepted triangles; false if there are none. */
static bool accepted_bounds(const oracle_positions *mesh, double low[3], double high[3])
{
    bool is_first = true;

    for (size_t t = 0; t < mesh->triangle_count; t++) {
        uint32_t vertex_indices[3];

        if (!oracle_triangle_accepted(mesh, t, vertex_indices))
            continue;
        for (size_t i = 0; i < 9; i++) {
            size_t k = i % 3;
            double coordinate = mesh->positions[3 * (size_t)vertex_indices[i / 3] + k];

            low[k] = (is_first && i < 3) || coordinate < low[k] ? coordinate : low[k];
            high[k] = (is_first && i < 3) || coordinate > high[k] ? coordinate : high[k];
        }
        is_first = false;
    }
    return !is_first;
}

bool oracle_grid_given(const double origin[3], double edge, unsigned snap_bits, oracle_grid *grid)
{
    double scale;

    if (!is_positive_normal(edge) || !isfinite(origin[0]) || !isfinite(origin[1]) || !isfinite(origin[2]))
        return false;
    scale = divide(snap_bits, edge);
    if (!is_positive_normal(scale))
        return false;
    *grid = (oracle_grid){{origin[0], origin[1], origin[2]}, edge, scale, snap_bits};
    return true;
}

bool oracle_grid_fit(const oracle_positions *mesh, unsigned snap_bits, oracle_grid *grid)
{
    double low[3], high[3], edge = 0;

    if (!accepted_bounds(mesh, low, high))
        return false;
    for (size_t k = 0; k < 3; k++) {
        double extent = subtract(high[k], low[k]);

        edge = extent > edge ? extent : edge;
    }
    return oracle_grid_given(low, edge == 0 ? 1 : edge_around(edge), snap_bits, grid);
}

/*
 * dividend / divisor, rounded to odd, for a divisor.value from 2^52 on. Returns false for some quotients beyond 2^29.
 *
 * The dividend comes from difference(), with at most 124 bits. Where its lowest bit stands for others, it has 122, and
 * a divisor that is not far above it in position gives quotients beyond 2^29. Multiples of other divisors are even in
 * units of the dividend: the bit is on the same side of all of them as what it stands for.
 */
static bool divide_to_odd(number dividend, number divisor, wide *quotient)
{
    int shift = dividend.exponent - divisor.exponent;
    wide rest;

    if (dividend.value == 0 || shift < -73) {
        *quotient = (dividend.value > 0) - (dividend.value < 0); /* less than 2^124 / 2^(52 + 74) */
        return true;
    }
    if (shift > 0) {
        if (bit_count(dividend.value < 0 ? -dividend.value : dividend.value) + shift > 83)
            return false;
        dividend.value *= (wide)1 << shift;
    } else {
        divisor.value *= (wide)1 << -shift;
    }
    *quotient = dividend.value / divisor.value;
    rest = dividend.value % divisor.value;
    if (rest != 0)
        *quotient = (rest < 0 ? *quotient - 1 : *quotient) | 1;
    return true;
}

bool oracle_snap(const oracle_grid *grid, const double position[3], int32_t snapped[3])
{
    const wide limit = (wide)1 << 29;
    number unit = number_of(grid->edge);
    int32_t result[3];

    unit.exponent -= (int)grid->snap_bits;
    for (int k = 0; k < 3; k++) {
        wide q;

        if (!divide_to_odd(difference(position[k], grid->origin[k]), unit, &q) || q <= -limit || q >= limit)
            return false;
        result[k] = (int32_t)q;
    }
    for (int k = 0; k < 3; k++)
        snapped[k] = result[k];
    return true;
}
