/* SPDX-License-Identifier: MIT */
/*
 * Second reference: the triangle clipped to the box, exactly. The piece of a triangle inside a closed box is a convex
 * polygon (or a segment, a point, nothing) and each of its corners is an end of a triangle edge clipped to the box or
 * the crossing of a box edge with the triangle. So the piece is known from those points, which are visited as fractions
 * with a common denominator; none means the triangle misses the closed box.
 *
 * The half-open box asks for one point below all three far faces at once. Different corners of the piece may answer for
 * different axes: the mean of all corners is a point of the piece and lies on a far face only if every corner does. So
 * the piece meets the half-open box exactly when for each axis some corner lies below the far face.
 *
 * Widths: |coordinate| < 2^30 and |corner| + width < 2^31, so differences fit 32 bits and a sign, normals 63 bits and a
 * sign, and the plane's value at a corner 98 bits.
 */
#include "predicate.h"

/* What is known of the piece: whether it has points, and for which axes one of them lies below the far face. */
typedef struct piece {
    bool has_points;
    bool below[3];
} piece;

/* numerator / denominator, denominator > 0 */
typedef struct fraction {
    int64_t numerator, denominator;
} fraction;

static bool fraction_less(fraction a, fraction b)
{
    return (oracle_wide)a.numerator * b.denominator < (oracle_wide)b.numerator * a.denominator;
}

static bool piece_is_complete(const piece *found)
{
    return found->has_points && found->below[0] && found->below[1] && found->below[2];
}

void oracle_clip_prepare(const oracle_triangle *triangle, oracle_clip_triangle *prepared)
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            prepared->vertex[i][k] = triangle->vertex[i][k];
    prepared->constant = 0;
    for (int k = 0; k < 3; k++) {
        int u = (k + 1) % 3, v = (k + 2) % 3;
        const int64_t *a = prepared->vertex[0], *b = prepared->vertex[1], *c = prepared->vertex[2];

        /* Twice the signed area of the triangle seen along axis k. */
        prepared->normal[k] = (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
        prepared->constant += (oracle_wide)prepared->normal[k] * a[k];
    }
}

/* The part of a + t (b - a), 0 <= t <= 1, inside the closed box: false, or the first and the last t (Liang and
   Barsky). */
static bool clip_segment(const int64_t a[3], const int64_t b[3], const oracle_box *box, fraction *first, fraction *last)
{
    *first = (fraction){0, 1};
    *last = (fraction){1, 1};
    for (int k = 0; k < 3; k++) {
        int64_t to_near = box->corner[k] - a[k], to_far = to_near + box->width, step = b[k] - a[k];
        fraction enter = {to_near, step}, leave = {to_far, step};

        if (step == 0) {
            if (to_near > 0 || to_far < 0)
                return false;
            continue;
        }
        if (step < 0) {
            enter = (fraction){-to_far, -step};
            leave = (fraction){-to_near, -step};
        }
        *first = fraction_less(*first, enter) ? enter : *first;
        *last = fraction_less(leave, *last) ? leave : *last;
    }
    return !fraction_less(*last, *first);
}

static void add_segment_point(const int64_t a[3], const int64_t b[3], fraction t, const oracle_box *box, piece *found)
{
    found->has_points = true;
    for (int k = 0; k < 3; k++) {
        oracle_wide position = (oracle_wide)a[k] * t.denominator + (oracle_wide)(b[k] - a[k]) * t.numerator;
        oracle_wide far_face = (oracle_wide)(box->corner[k] + box->width) * t.denominator;

        found->below[k] = found->below[k] || position < far_face;
    }
}

/* The ends of the triangle's edges inside the box; a segment or a point consists of nothing else. */
static void add_triangle_edges(const oracle_clip_triangle *triangle, const oracle_box *box, piece *found)
{
    for (int i = 0; i < 3 && !piece_is_complete(found); i++) {
        const int64_t *a = triangle->vertex[i], *b = triangle->vertex[(i + 1) % 3];
        fraction first, last;

        if (clip_segment(a, b, box, &first, &last)) {
            add_segment_point(a, b, first, box, found);
            add_segment_point(a, b, last, box, found);
        }
    }
}

/* Whether the line through point along axis k meets the triangle, which is not seen edge-on from there. */
static bool line_meets_triangle(const oracle_clip_triangle *triangle, const int64_t point[3], int k)
{
    int u = (k + 1) % 3, v = (k + 2) % 3;

    for (int i = 0; i < 3; i++) {
        const int64_t *a = triangle->vertex[i], *b = triangle->vertex[(i + 1) % 3];
        oracle_wide side =
            (oracle_wide)(b[u] - a[u]) * (point[v] - a[v]) - (oracle_wide)(b[v] - a[v]) * (point[u] - a[u]);

        if (triangle->normal[k] > 0 ? side < 0 : side > 0)
            return false;
    }
    return true;
}

/* The crossing of the box edge that starts in box corner `octant` and runs along axis k, if there is just one. An edge
   parallel to the plane adds nothing: a corner of the piece on it is a box corner, which ends another edge too, or lies
   on a triangle edge. */
static void add_box_edge(const oracle_clip_triangle *triangle, const oracle_box *box, int octant, int k, piece *found)
{
    int64_t point[3];
    oracle_wide at_near = -triangle->constant, at_far;

    for (int j = 0; j < 3; j++) {
        point[j] = box->corner[j] + (octant >> j & 1) * box->width;
        at_near += (oracle_wide)triangle->normal[j] * point[j];
    }
    at_far = at_near + (oracle_wide)triangle->normal[k] * box->width;
    if ((at_near < 0 && at_far < 0) || (at_near > 0 && at_far > 0) || !line_meets_triangle(triangle, point, k))
        return;
    found->has_points = true;
    for (int j = 0; j < 3; j++) {
        bool is_below = j == k ? at_far != 0 : (octant >> j & 1) == 0;

        found->below[j] = found->below[j] || is_below;
    }
}

static void add_box_edges(const oracle_clip_triangle *triangle, const oracle_box *box, piece *found)
{
    for (int k = 0; k < 3; k++) {
        if (triangle->normal[k] == 0)
            continue;
        for (int octant = 0; octant < 8 && !piece_is_complete(found); octant++)
            if ((octant >> k & 1) == 0)
                add_box_edge(triangle, box, octant, k, found);
    }
}

bool oracle_clip_test(const oracle_clip_triangle *prepared, const oracle_box *box, oracle_coverage coverage)
{
    piece found = {false, {false, false, false}};

    add_triangle_edges(prepared, box, &found);
    if (!piece_is_complete(&found))
        add_box_edges(prepared, box, &found);
    return coverage == ORACLE_CLOSED ? found.has_points : piece_is_complete(&found);
}

bool oracle_clip_touches(const oracle_triangle *triangle, const oracle_box *box, oracle_coverage coverage)
{
    oracle_clip_triangle prepared;

    oracle_clip_prepare(triangle, &prepared);
    return oracle_clip_test(&prepared, box, coverage) &&
           (coverage != ORACLE_THIN || oracle_thin_by_vertices(triangle, box));
}
