/* SPDX-License-Identifier: MIT */
/*
 * Second reference of meshes as given: the triangle clipped to the closed voxel in fractions of any size, side after
 * side (Sutherland and Hodgman, "Reentrant Polygon Clipping", 1974). Nothing left means that the triangle misses it.
 * The half-open voxel asks for a point below all three far faces: the mean of the corners of what is left is one
 * exactly when for each axis some corner lies below. Thin coverage has its rule besides, vertex by vertex.
 */
#include <gmp.h>
#include <math.h>
#include <stddef.h>

#include "oracle_exact.h"

#define CORNERS_MAX 9 /* each of six planes adds one at most */

/* Corners relative to the voxel's corner. */
typedef struct polygon {
    mpq_t corners[CORNERS_MAX][3];
    int count;
} polygon;

static void polygon_init(polygon *p)
{
    for (int i = 0; i < CORNERS_MAX * 3; ++i) {
        mpq_init(p->corners[i / 3][i % 3]);
    }
    p->count = 0;
}

static void polygon_clear(polygon *p)
{
    for (int i = 0; i < CORNERS_MAX * 3; ++i) {
        mpq_clear(p->corners[i / 3][i % 3]);
    }
}

/* Rounds an offset to odd: to a whole number of units of 2^-ORACLE_OFFSET_BITS of the power of two above the edge. */
static void round_offset(mpq_t offset, double edge)
{
    mpz_t whole;
    int exponent;
    mpz_init(whole);
    (void)frexp(edge, &exponent);
    exponent -= ORACLE_OFFSET_BITS;
    if (exponent < 0) {
        mpq_mul_2exp(offset, offset, (mp_bitcnt_t)-exponent);
    } else {
        mpq_div_2exp(offset, offset, (mp_bitcnt_t)exponent);
    }
    mpz_fdiv_q(whole, mpq_numref(offset), mpq_denref(offset));
    if (mpz_cmp_ui(mpq_denref(offset), 1) != 0) {
        mpz_setbit(whole, 0);
        mpq_set_z(offset, whole);
    }
    if (exponent < 0) {
        mpq_div_2exp(offset, offset, (mp_bitcnt_t)-exponent);
    } else {
        mpq_mul_2exp(offset, offset, (mp_bitcnt_t)exponent);
    }
    mpz_clear(whole);
}

/* The triangle, moved so that the cell's corner is 0; and the voxel's width. */
static void polygon_set(polygon *p, const oracle_exact_triangle *triangle, const oracle_space *space,
                        const int32_t cell[3], mpq_t width)
{
    mpq_t value;
    mpq_init(value);
    mpq_set_d(width, space->edge);
    mpq_div_2exp(width, width, space->depth);
    for (int i = 0; i < 9; ++i) {
        mpq_ptr out = p->corners[i / 3][i % 3];
        mpq_set_d(out, triangle->vertices[i / 3][i % 3]);
        mpq_set_d(value, space->origin[i % 3]);
        mpq_sub(out, out, value);
        round_offset(out, space->edge);
        mpq_set_si(value, cell[i % 3], 1);
        mpq_mul(value, value, width);
        mpq_sub(out, out, value);
    }
    p->count = 3;
    mpq_clear(value);
}

/* The crossing of the segment a b with the plane where both depths are 0. */
static void add_crossing(polygon *to, mpq_t a[3], mpq_t b[3], const mpq_t a_depth, const mpq_t b_depth)
{
    mpq_t share, step;
    mpq_inits(share, step, NULL);
    mpq_sub(share, a_depth, b_depth);
    mpq_div(share, a_depth, share);
    for (int k = 0; k < 3; ++k) {
        mpq_sub(step, b[k], a[k]);
        mpq_mul(step, step, share);
        mpq_add(to->corners[to->count][k], a[k], step);
    }
    ++to->count;
    mpq_clears(share, step, NULL);
}

/* bound - x where the far side is cut off, else x */
static void set_depth(mpq_t depth, const mpq_t x, bool is_far, const mpq_t bound)
{
    mpq_set(depth, x);
    if (is_far) {
        mpq_sub(depth, bound, x);
    }
}

/* What lies on the inner side of one of the voxel's planes. */
static void cut(polygon *from, polygon *to, int axis, bool is_far, const mpq_t width)
{
    mpq_t a_depth, b_depth;
    mpq_inits(a_depth, b_depth, NULL);
    to->count = 0;
    for (int i = 0; i < from->count; ++i) {
        mpq_t *a = from->corners[i];
        mpq_t *b = from->corners[(i + 1) % from->count];
        set_depth(a_depth, a[axis], is_far, width);
        set_depth(b_depth, b[axis], is_far, width);
        if (mpq_sgn(a_depth) >= 0) {
            for (int k = 0; k < 3; ++k) {
                mpq_set(to->corners[to->count][k], a[k]);
            }
            ++to->count;
        }
        if (mpq_sgn(a_depth) * mpq_sgn(b_depth) < 0) {
            add_crossing(to, a, b, a_depth, b_depth);
        }
    }
    mpq_clears(a_depth, b_depth, NULL);
}

/* Whether for each axis some corner lies below the far face. */
static bool is_below(polygon *p, const mpq_t width)
{
    bool below[3] = {false, false, false};
    for (int i = 0; i < p->count * 3; ++i) {
        below[i % 3] = below[i % 3] || mpq_cmp(p->corners[i / 3][i % 3], width) < 0;
    }
    return below[0] && below[1] && below[2];
}

/* The axis of index 0 .. 12 of a triangle, turned so that its first component that is not 0 is positive. */
static void thin_axis(mpq_t n[3], polygon *triangle, int index)
{
    mpq_t e[3], f[3], value;
    const int from = index < 6 ? 0 : index / 3 - 1; /* edges 0, 1, 2 for indices 3 .. 5, 6 .. 8, 9 .. 11 */
    mpq_init(value);
    for (int k = 0; k < 3; ++k) {
        mpq_inits(e[k], f[k], NULL);
        mpq_sub(e[k], triangle->corners[(from + 1) % 3][k], triangle->corners[from % 3][k]);
        /* What the edge is crossed with: an axis of the box, or the next edge for the normal. */
        mpq_set_si(f[k], k == index % 3, 1);
        if (index == 12) {
            mpq_sub(e[k], triangle->corners[1][k], triangle->corners[0][k]);
            mpq_sub(f[k], triangle->corners[2][k], triangle->corners[0][k]);
        }
    }
    int sign = 0;
    for (int k = 0; k < 3; ++k) {
        mpq_mul(n[k], e[(k + 1) % 3], f[(k + 2) % 3]);
        mpq_mul(value, e[(k + 2) % 3], f[(k + 1) % 3]);
        mpq_sub(n[k], n[k], value);
        if (index < 3) {
            mpq_set_si(n[k], k == index, 1);
        }
        sign = sign == 0 ? mpq_sgn(n[k]) : sign;
    }
    for (int k = 0; k < 3; ++k) {
        if (sign < 0) {
            mpq_neg(n[k], n[k]);
        }
        mpq_clears(e[k], f[k], NULL);
    }
    mpq_clear(value);
}

/* Whether the axis n separates the triangle from the voxel: min >= h or max < -h, with h = width / 2 * max |n_i|. */
static bool thin_separates(mpq_t n[3], polygon *triangle, const mpq_t width)
{
    mpq_t reach, half, offset, value;
    mpq_inits(reach, half, offset, value, NULL);
    mpq_div_2exp(half, width, 1);
    for (int k = 0; k < 3; ++k) {
        mpq_abs(value, n[k]);
        mpq_mul(value, value, half);
        if (mpq_cmp(value, reach) > 0) {
            mpq_set(reach, value);
        }
    }
    const bool is_axis = mpq_sgn(reach) > 0;
    bool some_below = false;
    bool some_above = false;
    for (int vertex = 0; vertex < 3; ++vertex) {
        mpq_set_si(offset, 0, 1);
        for (int k = 0; k < 3; ++k) {
            mpq_sub(value, triangle->corners[vertex][k], half);
            mpq_mul(value, value, n[k]);
            mpq_add(offset, offset, value);
        }
        some_below = some_below || mpq_cmp(offset, reach) < 0;
        mpq_neg(value, reach);
        some_above = some_above || mpq_cmp(offset, value) >= 0;
    }
    mpq_clears(reach, half, offset, value, NULL);
    return is_axis && !(some_below && some_above);
}

static bool thin_touches(polygon *triangle, const mpq_t width)
{
    mpq_t n[3];
    bool touches = true;
    mpq_inits(n[0], n[1], n[2], NULL);
    for (int index = 0; touches && index < 13; ++index) {
        thin_axis(n, triangle, index);
        touches = !thin_separates(n, triangle, width);
    }
    mpq_clears(n[0], n[1], n[2], NULL);
    return touches;
}

bool oracle_exact_clip_touches(const oracle_exact_triangle *triangle, const oracle_space *space, const int32_t cell[3],
                               oracle_coverage coverage)
{
    polygon polygons[2];
    mpq_t width;
    mpq_init(width);
    polygon_init(&polygons[0]);
    polygon_init(&polygons[1]);
    polygon_set(&polygons[0], triangle, space, cell, width);
    bool touches = coverage != ORACLE_THIN || thin_touches(&polygons[0], width);
    for (int side = 0; side < 6; ++side) {
        cut(&polygons[side % 2], &polygons[(side + 1) % 2], side / 2, side % 2 == 1, width);
    }
    touches = touches && polygons[0].count > 0 && (coverage == ORACLE_CLOSED || is_below(&polygons[0], width));
    polygon_clear(&polygons[0]);
    polygon_clear(&polygons[1]);
    mpq_clear(width);
    return touches;
}
