/* SPDX-License-Identifier: MIT */
/*
 * First reference of meshes as given: the separating axis test over 13 axes, as in oracle_sat.c and oracle_thin.c, on
 * integers of any size. Doubles are integers times powers of two, so that vertices and planes are integers in units of
 * one power of two.
 */
#include "exact_axes.h"

#include <limits.h>
#include <math.h>

#define SIGNIFICAND_BITS 53

/* value = significand * 2^exponent_of(value); INT_MAX for 0. */
static int exponent_of(double value)
{
    int exponent;
    (void)frexp(value, &exponent);
    return value == 0.0 ? INT_MAX : exponent - SIGNIFICAND_BITS;
}

/* value in units of 2^least */
static void set_value(mpz_t out, double value, int least)
{
    int exponent;
    mpz_set_d(out, ldexp(frexp(value, &exponent), SIGNIFICAND_BITS));
    if (value != 0.0) {
        mpz_mul_2exp(out, out, (mp_bitcnt_t)(exponent - SIGNIFICAND_BITS - least));
    }
}

static void for_each_number(exact_triangle *exact, void (*call)(mpz_t))
{
    for (int i = 0; i < 9; ++i) {
        call(exact->vertices[i / 3][i % 3]);
        call(exact->edges[i / 3][i % 3]);
    }
    for (int k = 0; k < 3; ++k) {
        call(exact->normal[k]);
        call(exact->direction[k]);
        call(exact->corner[k]);
    }
    call(exact->width);
    call(exact->low);
    call(exact->high);
    call(exact->above);
    call(exact->below);
    call(exact->value);
}

static void init_number(mpz_t number)
{
    mpz_init(number);
}

static void clear_number(mpz_t number)
{
    mpz_clear(number);
}

void exact_triangle_init(exact_triangle *exact)
{
    for_each_number(exact, init_number);
}

void exact_triangle_clear(exact_triangle *exact)
{
    for_each_number(exact, clear_number);
}

static int least_of(int a, int b)
{
    return a < b ? a : b;
}

/* The exponent of the common unit of vertices, origin and width. */
static int common_exponent(const oracle_exact_triangle *triangle, const oracle_space *space)
{
    int least = exponent_of(space->edge) - (int)space->depth;
    for (int i = 0; i < 9; ++i) {
        least = least_of(least, exponent_of(triangle->vertices[i / 3][i % 3]));
        least = least_of(least, exponent_of(space->origin[i % 3]));
    }
    return least;
}

/* Rounds to a multiple of 2^shift, to odd ones of it. */
static void round_to_odd(mpz_t value, mp_bitcnt_t shift)
{
    if (!mpz_divisible_2exp_p(value, shift)) {
        mpz_fdiv_q_2exp(value, value, shift);
        mpz_setbit(value, 0);
        mpz_mul_2exp(value, value, shift);
    }
}

int64_t oracle_exact_rounded(double vertex, double origin, double edge, unsigned bits)
{
    const int least = least_of(exponent_of(edge), least_of(exponent_of(vertex), exponent_of(origin)));
    mpz_t offset;
    mpz_t width;
    mpz_t value;
    mpz_inits(offset, width, value, NULL);
    set_value(offset, vertex, least);
    set_value(value, origin, least);
    set_value(width, edge, least);
    mpz_sub(offset, offset, value);
    mpz_mul_2exp(offset, offset, bits);
    /* floor, then the remainder's double against the width */
    mpz_fdiv_qr(value, offset, offset, width);
    mpz_mul_2exp(offset, offset, 1);
    const int half = mpz_cmp(offset, width);
    if (half > 0 || (half == 0 && mpz_odd_p(value))) {
        mpz_add_ui(value, value, 1);
    }
    const int64_t rounded = (int64_t)mpz_get_si(value);
    mpz_clears(offset, width, value, NULL);
    return rounded;
}

void exact_triangle_set(exact_triangle *exact, const oracle_exact_triangle *triangle, const oracle_space *space)
{
    const int least = common_exponent(triangle, space);
    const int unit = exponent_of(space->edge) + SIGNIFICAND_BITS - ORACLE_OFFSET_BITS;
    for (int i = 0; i < 9; ++i) {
        mpz_ptr out = exact->vertices[i / 3][i % 3];
        set_value(out, triangle->vertices[i / 3][i % 3], least);
        set_value(exact->value, space->origin[i % 3], least);
        mpz_sub(out, out, exact->value);
        round_to_odd(out, unit > least ? (mp_bitcnt_t)(unit - least) : 0);
    }
    set_value(exact->width, space->edge, least + (int)space->depth);
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            mpz_sub(exact->edges[i][k], exact->vertices[(i + 1) % 3][k], exact->vertices[i][k]);
        }
    }
    for (int k = 0; k < 3; ++k) {
        const int u = (k + 1) % 3;
        const int v = (k + 2) % 3;
        mpz_mul(exact->normal[k], exact->edges[0][u], exact->edges[1][v]);
        mpz_submul(exact->normal[k], exact->edges[0][v], exact->edges[1][u]);
    }
}

int64_t exact_triangle_cell(exact_triangle *exact, int vertex, int axis, bool *on_plane)
{
    mpz_fdiv_qr(exact->value, exact->low, exact->vertices[vertex][axis], exact->width);
    *on_plane = mpz_sgn(exact->low) == 0;
    mpz_set_d(exact->low, (double)EXACT_CELL_MAX);
    if (mpz_cmpabs(exact->value, exact->low) >= 0) {
        return mpz_sgn(exact->value) < 0 ? -EXACT_CELL_MAX : EXACT_CELL_MAX;
    }
    return (int64_t)mpz_get_d(exact->value);
}

/* Fills direction. */
static void set_direction(exact_triangle *exact, int axis_index)
{
    if (axis_index < EXACT_NORMAL) {
        for (int k = 0; k < 3; ++k) {
            mpz_set_ui(exact->direction[k], k == axis_index);
        }
    } else if (axis_index == EXACT_NORMAL) {
        for (int k = 0; k < 3; ++k) {
            mpz_set(exact->direction[k], exact->normal[k]);
        }
    } else {
        const int axis = (axis_index - EXACT_AXIS(0, 0)) % 3;
        mpz_t *edge = exact->edges[(axis_index - EXACT_AXIS(0, 0)) / 3];
        mpz_set_ui(exact->direction[axis], 0);
        mpz_neg(exact->direction[(axis + 1) % 3], edge[(axis + 2) % 3]);
        mpz_set(exact->direction[(axis + 2) % 3], edge[(axis + 1) % 3]);
    }
}

/* Turns direction so that its first component that is not 0 is positive. */
static void flip_direction(exact_triangle *exact)
{
    for (int k = 0; k < 3; ++k) {
        if (mpz_sgn(exact->direction[k]) < 0) {
            for (int j = k; j < 3; ++j) {
                mpz_neg(exact->direction[j], exact->direction[j]);
            }
        }
        if (mpz_sgn(exact->direction[k]) != 0) {
            return;
        }
    }
}

/* Fills low and high: the extent of the triangle along direction, from the corner of the box. */
static void set_extent(exact_triangle *exact, const exact_box *box)
{
    for (int k = 0; k < 3; ++k) {
        mpz_set_d(exact->corner[k], (double)box->corner[k]);
        mpz_mul(exact->corner[k], exact->corner[k], exact->width);
    }
    for (int vertex = 0; vertex < 3; ++vertex) {
        mpz_set_ui(exact->value, 0);
        for (int k = 0; k < 3; ++k) {
            mpz_sub(exact->above, exact->vertices[vertex][k], exact->corner[k]);
            mpz_addmul(exact->value, exact->above, exact->direction[k]);
        }
        if (vertex == 0 || mpz_cmp(exact->value, exact->low) < 0) {
            mpz_set(exact->low, exact->value);
        }
        if (vertex == 0 || mpz_cmp(exact->value, exact->high) > 0) {
            mpz_set(exact->high, exact->value);
        }
    }
}

/* Along direction the box reaches from below to above. */
static bool box_is_apart(exact_triangle *exact, int64_t size, oracle_coverage coverage)
{
    mpz_set_ui(exact->above, 0);
    mpz_set_ui(exact->below, 0);
    for (int k = 0; k < 3; ++k) {
        mpz_ptr reach = mpz_sgn(exact->direction[k]) > 0 ? exact->above : exact->below;
        mpz_add(reach, reach, exact->direction[k]);
    }
    const bool rises = mpz_sgn(exact->above) > 0;
    const bool falls = mpz_sgn(exact->below) < 0;
    mpz_set_d(exact->value, (double)size);
    mpz_mul(exact->value, exact->value, exact->width);
    mpz_mul(exact->above, exact->above, exact->value);
    mpz_mul(exact->below, exact->below, exact->value);
    const int over = mpz_cmp(exact->low, exact->above);
    const int under = mpz_cmp(exact->high, exact->below);
    return over > 0 || under < 0 || (coverage != ORACLE_CLOSED && ((over == 0 && rises) || (under == 0 && falls)));
}

/* Twice the extent from the center of the voxel, beside twice its reach. */
static bool thin_is_apart(exact_triangle *exact)
{
    mpz_set_ui(exact->above, 0);
    mpz_set_ui(exact->value, 0);
    for (int k = 0; k < 3; ++k) {
        mpz_add(exact->value, exact->value, exact->direction[k]);
        if (mpz_cmpabs(exact->direction[k], exact->above) > 0) {
            mpz_abs(exact->above, exact->direction[k]);
        }
    }
    if (mpz_sgn(exact->above) == 0) {
        return false;
    }
    mpz_mul(exact->value, exact->value, exact->width);
    mpz_mul(exact->above, exact->above, exact->width);
    mpz_neg(exact->below, exact->above);
    mpz_mul_2exp(exact->low, exact->low, 1);
    mpz_mul_2exp(exact->high, exact->high, 1);
    mpz_sub(exact->low, exact->low, exact->value);
    mpz_sub(exact->high, exact->high, exact->value);
    return mpz_cmp(exact->low, exact->above) >= 0 || mpz_cmp(exact->high, exact->below) < 0;
}

bool exact_triangle_is_apart(exact_triangle *exact, int axis_index, const exact_box *box, oracle_coverage coverage)
{
    set_direction(exact, axis_index);
    if (coverage == ORACLE_THIN) {
        flip_direction(exact);
    }
    set_extent(exact, box);
    return coverage == ORACLE_THIN ? thin_is_apart(exact) : box_is_apart(exact, box->size, coverage);
}

bool oracle_exact_touches(const oracle_exact_triangle *triangle, const oracle_space *space, const int32_t cell[3],
                          oracle_coverage coverage)
{
    const exact_box box = {{cell[0], cell[1], cell[2]}, 1};
    exact_triangle exact;
    exact_triangle_init(&exact);
    exact_triangle_set(&exact, triangle, space);
    bool touches = true;
    for (int axis_index = 0; touches && axis_index < EXACT_AXES; ++axis_index) {
        touches = !exact_triangle_is_apart(&exact, axis_index, &box, coverage);
    }
    exact_triangle_clear(&exact);
    return touches;
}
