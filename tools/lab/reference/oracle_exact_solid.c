/* SPDX-License-Identifier: MIT */
/*
 * Solids of meshes as given, in integers of any size: oracle_solid.c's moved lines, and heights that are divided. The
 * unit is that of exact_axes.h, halved.
 */
#include <math.h>
#include <stdlib.h>

#include "exact_axes.h"

/* Numbers of one triangle and one line. */
typedef struct line {
    exact_triangle exact;
    unsigned u, v, axis;
    mpz_t at[2]; /* the line's u and v */
    mpz_t du, dv, area, height, value;
} line;

static void line_init(line *l)
{
    exact_triangle_init(&l->exact);
    mpz_inits(l->at[0], l->at[1], l->du, l->dv, l->area, l->height, l->value, NULL);
}

static void line_clear(line *l)
{
    exact_triangle_clear(&l->exact);
    mpz_clears(l->at[0], l->at[1], l->du, l->dv, l->area, l->height, l->value, NULL);
}

static void line_set_axis(line *l, unsigned axis)
{
    l->axis = axis;
    l->u = (axis + 1) % 3;
    l->v = (axis + 2) % 3;
}

/* The center of a cell along an axis, in units halved. */
static void set_center(line *l, mpz_t out, int32_t cell)
{
    mpz_set_d(out, 2.0 * (double)cell + 1.0);
    mpz_mul(out, out, l->exact.width);
}

/* On which side of edge i the line lies, moved by epsilon along u and -epsilon^2 along v; 0: the edge has no length. */
static int side_of(line *l, int i)
{
    mpz_t *from = l->exact.vertices[i];
    mpz_t *edge = l->exact.edges[i];
    mpz_mul_2exp(l->du, from[l->u], 1);
    mpz_sub(l->du, l->at[0], l->du);
    mpz_mul_2exp(l->dv, from[l->v], 1);
    mpz_sub(l->dv, l->at[1], l->dv);
    mpz_mul(l->value, edge[l->u], l->dv);
    mpz_submul(l->value, edge[l->v], l->du);
    const int side = mpz_sgn(l->value);
    const int moved = mpz_sgn(edge[l->v]) != 0 ? -mpz_sgn(edge[l->v]) : -mpz_sgn(edge[l->u]);
    return side != 0 ? side : moved;
}

/* The height of the plane over the line in half voxels, rounded down and clamped. The area is not 0. */
static int64_t height_of(line *l)
{
    mpz_t *normal = l->exact.normal;
    mpz_t *corner = l->exact.vertices[0];
    /* 2 n_axis (height - corner) = n_u (2 corner_u - u) + n_v (2 corner_v - v) */
    mpz_mul_2exp(l->du, corner[l->u], 1);
    mpz_sub(l->du, l->du, l->at[0]);
    mpz_mul_2exp(l->dv, corner[l->v], 1);
    mpz_sub(l->dv, l->dv, l->at[1]);
    mpz_mul(l->height, normal[l->u], l->du);
    mpz_addmul(l->height, normal[l->v], l->dv);
    mpz_mul_2exp(l->value, corner[l->axis], 1);
    mpz_addmul(l->height, normal[l->axis], l->value);
    mpz_mul(l->area, normal[l->axis], l->exact.width);
    mpz_fdiv_q(l->height, l->height, l->area);
    mpz_set_d(l->value, (double)EXACT_CELL_MAX);
    if (mpz_cmpabs(l->height, l->value) >= 0) {
        return mpz_sgn(l->height) < 0 ? -EXACT_CELL_MAX : EXACT_CELL_MAX;
    }
    return (int64_t)mpz_get_d(l->height);
}

/* See oracle_exact_crossing. The triangle and the axis are set. */
static int cross(line *l, int32_t column, int32_t row, int64_t *half_voxels)
{
    set_center(l, l->at[0], column);
    set_center(l, l->at[1], row);
    const int first = side_of(l, 0);
    if (first == 0 || side_of(l, 1) != first || side_of(l, 2) != first) {
        return 0;
    }
    *half_voxels = height_of(l);
    return first;
}

int oracle_exact_crossing(const oracle_exact_triangle *triangle, const oracle_space *space, unsigned axis,
                          const int32_t cell[3], int64_t *half_voxels)
{
    line l;
    line_init(&l);
    exact_triangle_set(&l.exact, triangle, space);
    line_set_axis(&l, axis);
    const int sense = cross(&l, cell[l.u], cell[l.v], half_voxels);
    line_clear(&l);
    return sense;
}

/* ---- all columns ---- */

typedef struct crossing {
    uint32_t column; /* row * edge + column */
    uint32_t below; /* centers of the column's voxels at or below it */
    int32_t sense;
} crossing;

typedef struct sweep {
    const oracle_positions *mesh;
    const oracle_space *space;
    oracle_rule rule;
    oracle_solid *out;
    uint32_t edge; /* voxels per axis */
    line line;
    crossing *crossings;
    size_t count, capacity;
} sweep;

static bool add(sweep *s, const crossing *found)
{
    if (s->count == s->capacity) {
        const size_t capacity = s->capacity * 2 + 1024;
        crossing *grown = realloc(s->crossings, capacity * sizeof *grown);
        if (grown == NULL) {
            return false;
        }
        s->crossings = grown;
        s->capacity = capacity;
    }
    s->crossings[s->count++] = *found;
    return true;
}

/* The cells whose centers may lie within the triangle's bounds; one more on each side, for what rounding does. */
static void find_range(const sweep *s, const oracle_exact_triangle *triangle, unsigned axis, int32_t range[2])
{
    double low = (double)INFINITY;
    double high = -(double)INFINITY;
    for (int i = 0; i < 3; ++i) {
        const double width = s->space->edge / (double)s->edge;
        const double at = (triangle->vertices[i][axis] - s->space->origin[axis]) / width;
        low = fmin(low, floor(at) - 2.0);
        high = fmax(high, floor(at) + 2.0);
    }
    range[0] = (int32_t)fmin(fmax(low, 0.0), s->edge);
    range[1] = (int32_t)fmax(fmin(high, s->edge - 1.0), -1.0);
}

static bool add_triangle(sweep *s, const oracle_exact_triangle *triangle)
{
    line *l = &s->line;
    int32_t columns[2];
    int32_t rows[2];
    int64_t half = 0;
    bool good = true;
    find_range(s, triangle, l->u, columns);
    find_range(s, triangle, l->v, rows);
    for (int32_t row = rows[0]; row <= rows[1]; ++row) {
        for (int32_t column = columns[0]; column <= columns[1]; ++column) {
            const int sense = cross(l, column, row, &half);
            const int64_t below = half < 0 ? 0 : (half + 1) / 2; /* center k is at 2 k + 1 */
            const crossing found = {(uint32_t)row * s->edge + (uint32_t)column,
                                    below > s->edge ? s->edge : (uint32_t)below, sense};
            good = good && (sense == 0 || add(s, &found));
        }
    }
    return good;
}

/* By column, then from the far end on. */
static int compare(const void *a, const void *b)
{
    const crossing *p = a;
    const crossing *q = b;
    if (p->column != q->column) {
        return p->column < q->column ? -1 : 1;
    }
    return p->below == q->below ? 0 : p->below > q->below ? -1 : 1;
}

/* The voxels of a column from first to below end. */
static void set_inside(sweep *s, uint32_t column, uint32_t first, uint32_t end)
{
    const line *l = &s->line;
    uint64_t at[3];
    at[l->u] = column % s->edge;
    at[l->v] = column / s->edge;
    for (at[l->axis] = first; at[l->axis] < end; ++at[l->axis]) {
        const uint64_t index = at[0] + ((at[1] + (at[2] << s->out->depth)) << s->out->depth);
        s->out->inside[l->axis][index / 64] |= (uint64_t)1 << index % 64;
    }
}

/* Sums up the crossings of one column, from the first on; returns the first of the next. */
static size_t sum_column(sweep *s, size_t first)
{
    const uint32_t column = s->crossings[first].column;
    uint32_t end = s->edge;
    int64_t sum = 0;
    for (; first < s->count && s->crossings[first].column == column; ++first) {
        const crossing *next = &s->crossings[first];
        if (s->rule == ORACLE_PARITY ? sum % 2 != 0 : sum != 0) {
            set_inside(s, column, next->below, end);
        }
        end = next->below;
        sum += next->sense;
    }
    if (s->rule == ORACLE_PARITY ? sum % 2 != 0 : sum != 0) {
        set_inside(s, column, 0, end);
    }
    s->out->open_columns[s->line.axis] += sum != 0 ? 1 : 0;
    return first;
}

static bool sweep_axis(sweep *s, unsigned axis)
{
    uint32_t corners[3];
    oracle_exact_triangle triangle;
    line_set_axis(&s->line, axis);
    s->count = 0;
    for (size_t t = 0; t < s->mesh->triangle_count; ++t) {
        if (!oracle_triangle_accepted(s->mesh, t, corners)) {
            continue;
        }
        for (int i = 0; i < 9; ++i) {
            triangle.vertices[i / 3][i % 3] = s->mesh->positions[(size_t)corners[i / 3] * 3 + (size_t)i % 3];
        }
        exact_triangle_set(&s->line.exact, &triangle, s->space);
        if (!add_triangle(s, &triangle)) {
            return false;
        }
    }
    if (s->count > 0) {
        qsort(s->crossings, s->count, sizeof *s->crossings, compare);
    }
    for (size_t first = 0; first < s->count;) {
        first = sum_column(s, first);
    }
    return true;
}

bool oracle_exact_solid_make(const oracle_positions *mesh, const oracle_space *space, oracle_rule rule,
                             oracle_solid *out)
{
    sweep s = {.mesh = mesh, .space = space, .rule = rule, .out = out};
    bool good = space->depth >= 1 && space->depth <= 10;
    *out = (oracle_solid){.depth = space->depth};
    if (!good) {
        return false;
    }
    s.edge = UINT32_C(1) << space->depth;
    line_init(&s.line);
    for (unsigned axis = 0; axis < 3; ++axis) {
        out->inside[axis] = calloc((((size_t)1 << 3 * space->depth) + 63) / 64, sizeof(uint64_t));
        good = good && out->inside[axis] != NULL;
    }
    for (unsigned axis = 0; good && axis < 3; ++axis) {
        good = sweep_axis(&s, axis);
    }
    line_clear(&s.line);
    free(s.crossings);
    if (!good) {
        oracle_solid_free(out);
    }
    return good;
}
