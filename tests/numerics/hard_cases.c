/* SPDX-License-Identifier: MIT */
#include "hard_cases.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

/* ---- numbers ---- */

static uint64_t random_state;

void hard_cases_seed(uint64_t seed)
{
    random_state = seed;
}

uint64_t hard_random(void)
{
    uint64_t z = random_state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return z ^ z >> 31;
}

int hard_between(int low, int high)
{
    return low + (int)(hard_random() % (uint64_t)(high - low + 1));
}

static double uniform(void)
{
    return (double)(hard_random() >> 11) * 0x1p-53;
}

/* ---- grids and triangles ---- */

/* Grids without their depth. */
static const oracle_space spaces[HARD_SPACES] = {
    {{0.0, 0.0, 0.0}, 1.0, 0},          {{0.1, -0.2, 0.3}, 0.7, 0},
    {{-1.0, 1.5, 0.0}, 3.0, 0},         {{0.0, 1.0 / 3.0, -1.0 / 7.0}, 1.0 / 3.0, 0},
    {{1e6, -1e6, 1e6}, 1.0, 0},         {{-0.81, -0.5, 0.25}, 1.62, 0},
    {{0.0, 0.0, 0.0}, 0x1.000012p0, 0}, {{-1e-40, 0.0, 1e-40}, 1e-38, 0},
    {{0.0, -1e300, 1e300}, 1e301, 0},
};

/* The double next to plane `at` of an axis; between planes for values with a fraction. */
static double position_at(const oracle_space *space, int axis, double at)
{
    return space->origin[axis] + at * (space->edge / ldexp(1.0, (int)space->depth));
}

double hard_move(double value, int ulps)
{
    for (; ulps != 0; ulps += ulps > 0 ? -1 : 1) {
        value = nextafter(value, ulps > 0 ? (double)INFINITY : -(double)INFINITY);
    }
    return value;
}

/* In voxels from the first corner of s->cell, moved by a few ulps of the position. */
static void set_vertex(hard_case *s, int vertex, double x, double y, double z, int ulps)
{
    const double at[3] = {x, y, z};
    for (int k = 0; k < 3; ++k) {
        s->triangle.vertices[vertex][k] =
            hard_move(position_at(&s->space, k, (double)s->cell[k] + at[k]), hard_between(-ulps, ulps));
    }
}

/* Every vertex an ulp beside planes, or on them. */
static void make_beside_planes(hard_case *s)
{
    for (int i = 0; i < 3; ++i) {
        set_vertex(s, i, hard_between(-1, 2), hard_between(-1, 2), hard_between(-1, 2), 1);
    }
}

/* Halves of voxels: touches in corners, edges and faces, many of them degenerate. */
static void make_lattice(hard_case *s)
{
    for (int i = 0; i < 3; ++i) {
        set_vertex(s, i, hard_between(-2, 4) * 0.5, hard_between(-2, 4) * 0.5, hard_between(-2, 4) * 0.5, 0);
    }
}

/* A long edge through a corner of the cell, within ulps. */
static void make_edge_through_corner(hard_case *s)
{
    const double reach = ldexp(1.0, hard_between(-3, 4));
    const double step[3] = {reach * hard_between(-3, 3), reach * hard_between(-3, 3), reach * hard_between(-3, 3)};
    const int corner[3] = {hard_between(0, 1), hard_between(0, 1), hard_between(0, 1)};
    set_vertex(s, 0, corner[0] - step[0], corner[1] - step[1], corner[2] - step[2], 1);
    set_vertex(s, 1, corner[0] + step[0], corner[1] + step[1], corner[2] + step[2], 1);
    set_vertex(s, 2, 6.0 * uniform() - 3.0, 6.0 * uniform() - 3.0, 6.0 * uniform() - 3.0, 0);
}

/* A plane that cuts a corner off, or misses it, by less than 2^-40 of the grid's edge. */
static void make_grazing(hard_case *s)
{
    const double reach = 1.0 + uniform();
    const double depth = ldexp(uniform() - 0.5, (int)s->space.depth - hard_between(40, 56));
    set_vertex(s, 0, reach + depth, 0.0, 0.0, 0);
    set_vertex(s, 1, -reach, reach, depth, 0);
    set_vertex(s, 2, 0.0, -reach, reach + depth, 0);
}

/* A third vertex within ulps of the segment between the others. */
static void make_needle(hard_case *s)
{
    const double share = uniform();
    set_vertex(s, 0, 40.0 * uniform() - 20.0, 40.0 * uniform() - 20.0, 2.0 * uniform() - 1.0, 0);
    set_vertex(s, 1, 40.0 * uniform() - 20.0, 2.0 * uniform() - 1.0, 40.0 * uniform() - 20.0, 0);
    for (int k = 0; k < 3; ++k) {
        const double *a = s->triangle.vertices[0];
        const double *b = s->triangle.vertices[1];
        s->triangle.vertices[2][k] = hard_move(a[k] + share * (b[k] - a[k]), hard_between(-2, 2));
    }
}

/* A segment or a point. */
static void make_degenerate(hard_case *s)
{
    make_edge_through_corner(s);
    memcpy(s->triangle.vertices[2], s->triangle.vertices[hard_between(0, 1)], sizeof s->triangle.vertices[2]);
    if (hard_between(0, 2) == 0) {
        set_vertex(s, 0, hard_between(0, 1), hard_between(0, 1), hard_between(0, 1), 1);
        memcpy(s->triangle.vertices[1], s->triangle.vertices[0], sizeof s->triangle.vertices[1]);
        memcpy(s->triangle.vertices[2], s->triangle.vertices[0], sizeof s->triangle.vertices[2]);
    }
}

/* Tiny and huge numbers beside those of the grid. */
static void make_mixed_exponents(hard_case *s)
{
    static const double values[] = {0x1p-62, -0x1p-62, -0.8, 0.8, 0.0, 1e-308, 0x1p-1074, 1e15, -1e30, 1e200, 0.5};
    for (int i = 0; i < 9; ++i) {
        const double value = values[hard_between(0, (int)(sizeof values / sizeof values[0]) - 1)];
        const double other = position_at(&s->space, i % 3, s->cell[i % 3] + hard_between(0, 1));
        s->triangle.vertices[i / 3][i % 3] = hard_between(0, 2) == 0 ? other : value;
    }
}

/* What any mesh has. */
static void make_plain(hard_case *s)
{
    for (int i = 0; i < 3; ++i) {
        set_vertex(s, i, 6.0 * uniform() - 2.5, 6.0 * uniform() - 2.5, 6.0 * uniform() - 2.5, 0);
    }
}

const char *hard_kind_name(hard_kind kind)
{
    static const char *const names[HARD_KINDS] = {"beside planes", "lattice",    "edge through a corner", "grazing",
                                                  "needle",        "degenerate", "mixed exponents",       "plain"};
    return names[kind];
}

void hard_case_fill(hard_kind kind, hard_case *s)
{
    static void (*const makers[HARD_KINDS])(hard_case *) = {
        make_beside_planes, make_lattice,    make_edge_through_corner, make_grazing,
        make_needle,        make_degenerate, make_mixed_exponents,     make_plain};
    makers[kind](s);
}

void hard_case_make(hard_kind kind, size_t index, hard_case *out)
{
    *out = (hard_case){.space = spaces[index % HARD_SPACES]};
    /* Most triangles are a few voxels large, so that their lists are short at any depth. */
    out->space.depth = (unsigned)hard_between(1, kind == HARD_MIXED_EXPONENTS ? 5 : 16);
    for (int k = 0; k < 3; ++k) {
        out->cell[k] = hard_between(0, (1 << out->space.depth) - 1);
    }
    hard_case_fill(kind, out);
}

void hard_case_print(const hard_case *s, const int32_t cell[3])
{
    print_error("triangle");
    for (int i = 0; i < 9; ++i) {
        print_error(" %a", s->triangle.vertices[i / 3][i % 3]);
    }
    print_error(", origin %a %a %a edge %a depth %u, cell %d %d %d\n", s->space.origin[0], s->space.origin[1],
                s->space.origin[2], s->space.edge, s->space.depth, cell[0], cell[1], cell[2]);
}
