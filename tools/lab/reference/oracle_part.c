/* SPDX-License-Identifier: MIT */
/*
 * The part of a triangle inside a box, in double precision: Sutherland and Hodgman, "Reentrant Polygon Clipping", 1974.
 * Unlike the rest of this folder it is not exact, but its error is negligible against the rounding of an 8-bit or
 * 16-bit value.
 */
#include <math.h>
#include <string.h>

#include "oracle.h"

/* A polygon in space, from the box's corner. */
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

static polygon clipped(const double triangle[3][3], double width)
{
    polygon p = {.count = 3};
    memcpy(p.corners, triangle, 3 * sizeof p.corners[0]);
    for (unsigned axis = 0; axis < 3; ++axis) {
        p = cut(&p, axis, 1.0, 0.0);
        p = cut(&p, axis, -1.0, width);
    }
    return p;
}

double oracle_part(const double triangle[3][3], double width, double centroid[3])
{
    const polygon p = clipped(triangle, width);
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
    for (unsigned k = 0; k < 3; ++k) {
        centroid[k] = area > 0.0 ? moment[k] / area : width / 2.0;
    }
    return area / (width * width);
}

/* Twice the signed area of the triangle (at, p, q) seen along axis. Barycentric weights of slivers need its sign. */
static long double area_seen(const double at[3], const double p[3], const double q[3], unsigned axis)
{
    const unsigned u = (axis + 1) % 3;
    const unsigned v = (axis + 2) % 3;
    return ((long double)p[u] - at[u]) * ((long double)q[v] - at[v]) -
           ((long double)p[v] - at[v]) * ((long double)q[u] - at[u]);
}

void oracle_corner_weights(const double triangle[3][3], const double at[3], double weights[3])
{
    unsigned axis = 0;
    for (unsigned other = 1; other < 3; ++other) {
        const long double largest = fabsl(area_seen(triangle[0], triangle[1], triangle[2], axis));
        axis = fabsl(area_seen(triangle[0], triangle[1], triangle[2], other)) > largest ? other : axis;
    }
    long double parts[3];
    long double whole = 0.0L;
    long double sign = 0.0L;
    for (unsigned k = 0; k < 3; ++k) {
        parts[k] = area_seen(at, triangle[(k + 1) % 3], triangle[(k + 2) % 3], axis);
        sign += parts[k];
    }
    for (unsigned k = 0; k < 3; ++k) {
        parts[k] = fmaxl(sign < 0.0L ? -parts[k] : parts[k], 0.0L);
        whole += parts[k];
    }
    for (unsigned k = 0; k < 3; ++k) {
        weights[k] = whole > 0.0L && sign != 0.0L ? (double)(parts[k] / whole) : 1.0 / 3.0;
    }
}
