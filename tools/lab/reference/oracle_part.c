/* SPDX-License-Identifier: MIT */
/*
 * The part of a triangle inside a box, in double precision: Sutherland and Hodgman, "Reentrant Polygon Clipping", 1974.
 * Unlike the rest of this folder it is not exact, but its error is negligible against the rounding of an 8-bit or
 * 16-bit value.
 */
#include <math.h>
#include <string.h>

#include "oracle.h"

/* A polygon in space, in grid units from the box's corner. */
typedef struct polygon {
    double corners[9][3];
    unsigned count;
} polygon;

/* Keeps what lies on the positive side of sign * (x[axis] - bound) = 0. */
static polygon cut(const polygon *from, unsigned axis, double sign, double bound)
{
    polygon to = {.count = 0};
    for (unsigned i = 0; i < from->count; ++i) {
        const double *a = from->corners[i];
        const double *b = from->corners[(i + 1) % from->count];
        const double a_depth = sign * (a[axis] - bound);
        const double b_depth = sign * (b[axis] - bound);
        if (a_depth >= 0.0) {
            memcpy(to.corners[to.count++], a, sizeof to.corners[0]);
        }
        if ((a_depth < 0.0) != (b_depth < 0.0)) {
            for (unsigned k = 0; k < 3; ++k) {
                to.corners[to.count][k] = a[k] + (b[k] - a[k]) * (a_depth / (a_depth - b_depth));
            }
            ++to.count;
        }
    }
    return to;
}

static polygon clipped(const oracle_triangle *triangle, const oracle_box *box)
{
    polygon p = {.count = 3};
    for (unsigned corner = 0; corner < 3; ++corner) {
        for (unsigned axis = 0; axis < 3; ++axis) {
            p.corners[corner][axis] = (double)(triangle->vertex[corner][axis] - box->corner[axis]);
        }
    }
    for (unsigned axis = 0; axis < 3; ++axis) {
        p = cut(&p, axis, 1.0, 0.0);
        p = cut(&p, axis, -1.0, (double)box->width);
    }
    return p;
}

double oracle_part(const oracle_triangle *triangle, const oracle_box *box, double centroid[3])
{
    const polygon p = clipped(triangle, box);
    double area = 0.0;
    double moment[3] = {0.0, 0.0, 0.0};
    for (unsigned i = 2; i < p.count; ++i) {
        double e[3];
        double f[3];
        for (unsigned k = 0; k < 3; ++k) {
            e[k] = p.corners[i - 1][k] - p.corners[0][k];
            f[k] = p.corners[i][k] - p.corners[0][k];
        }
        const double n[3] = {e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]};
        const double piece = 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        area += piece;
        for (unsigned k = 0; k < 3; ++k) {
            moment[k] += piece * (p.corners[0][k] + p.corners[i - 1][k] + p.corners[i][k]) / 3.0;
        }
    }
    const double width = (double)box->width;
    for (unsigned k = 0; k < 3; ++k) {
        centroid[k] = area > 0.0 ? moment[k] / area : width / 2.0;
    }
    return area / (width * width);
}

/* Twice the signed area of the triangle (at, p, q) seen along axis. */
static double area_seen(const double at[3], const double p[3], const double q[3], unsigned axis)
{
    const unsigned u = (axis + 1) % 3;
    const unsigned v = (axis + 2) % 3;
    return (p[u] - at[u]) * (q[v] - at[v]) - (p[v] - at[v]) * (q[u] - at[u]);
}

void oracle_corner_weights(const oracle_triangle *triangle, const oracle_box *box, const double at[3],
                           double weights[3])
{
    double corners[3][3];
    for (unsigned corner = 0; corner < 3; ++corner) {
        for (unsigned k = 0; k < 3; ++k) {
            corners[corner][k] = (double)(triangle->vertex[corner][k] - box->corner[k]);
        }
    }
    unsigned axis = 0;
    for (unsigned other = 1; other < 3; ++other) {
        const double largest = fabs(area_seen(corners[0], corners[1], corners[2], axis));
        axis = fabs(area_seen(corners[0], corners[1], corners[2], other)) > largest ? other : axis;
    }
    double whole = 0.0;
    double sign = 0.0;
    for (unsigned k = 0; k < 3; ++k) {
        weights[k] = area_seen(at, corners[(k + 1) % 3], corners[(k + 2) % 3], axis);
        sign += weights[k];
    }
    for (unsigned k = 0; k < 3; ++k) {
        weights[k] = fmax(sign < 0.0 ? -weights[k] : weights[k], 0.0);
        whole += weights[k];
    }
    for (unsigned k = 0; k < 3; ++k) {
        weights[k] = whole > 0.0 && sign != 0.0 ? weights[k] / whole : 1.0 / 3.0;
    }
}
