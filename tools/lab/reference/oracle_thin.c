/* SPDX-License-Identifier: MIT */
/*
 * Thin coverage: the 13 axes of a triangle and a box, each with a reach of h = width / 2 * max |n_i| around the box's
 * center (Laine, "A Topological Approach to Voxelization", 2013). n is turned so that its first component that is not 0
 * is positive; the triangle is separated when min >= h or max < -h. Tested twice: by the extent of the projection, and
 * vertex by vertex. Everything is doubled, so that the center is an integer.
 *
 * Widths: as in oracle_sat.c, and two bits more.
 */
#include "predicate.h"

/* Axis index 0 .. 12: box axes, normal, edges crossed with box axes. */
static void thin_axis(const oracle_triangle *triangle, int index, int64_t n[3])
{
    int64_t edges[3][3];

    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            edges[i][k] = (int64_t)triangle->vertex[(i + 1) % 3][k] - triangle->vertex[i][k];
    if (index < 3) {
        for (int k = 0; k < 3; k++)
            n[k] = k == index;
    } else if (index == 3) {
        for (int k = 0; k < 3; k++)
            n[k] = edges[0][(k + 1) % 3] * edges[1][(k + 2) % 3] - edges[0][(k + 2) % 3] * edges[1][(k + 1) % 3];
    } else {
        int axis = (index - 4) % 3;
        const int64_t *edge = edges[(index - 4) / 3];

        n[axis] = 0;
        n[(axis + 1) % 3] = -edge[(axis + 2) % 3];
        n[(axis + 2) % 3] = edge[(axis + 1) % 3];
    }
    for (int k = 0; k < 3; k++) {
        if (n[k] == 0)
            continue;
        for (int j = 0; n[k] < 0 && j < 3; j++)
            n[j] = j == k ? n[j] : -n[j];
        n[k] = n[k] < 0 ? -n[k] : n[k];
        break;
    }
}

/* Twice the vertex's offset from the box's center along n. */
static oracle_wide doubled_offset(const oracle_triangle *triangle, int vertex, const oracle_box *box,
                                  const int64_t n[3])
{
    oracle_wide sum = 0;

    for (int k = 0; k < 3; k++)
        sum += (oracle_wide)n[k] * (2 * (int64_t)triangle->vertex[vertex][k] - 2 * box->corner[k] - box->width);
    return sum;
}

/* Twice the reach; 0 for an axis that is none. */
static oracle_wide doubled_reach(const oracle_box *box, const int64_t n[3])
{
    int64_t largest = 0;

    for (int k = 0; k < 3; k++) {
        int64_t size = n[k] < 0 ? -n[k] : n[k];
        largest = size > largest ? size : largest;
    }
    return (oracle_wide)largest * box->width;
}

bool oracle_thin_by_extents(const oracle_triangle *triangle, const oracle_box *box)
{
    for (int index = 0; index < ORACLE_SAT_AXES; index++) {
        int64_t n[3];
        thin_axis(triangle, index, n);
        oracle_wide reach = doubled_reach(box, n);
        oracle_wide low = doubled_offset(triangle, 0, box, n), high = low;

        for (int vertex = 1; vertex < 3; vertex++) {
            oracle_wide offset = doubled_offset(triangle, vertex, box, n);
            low = offset < low ? offset : low;
            high = offset > high ? offset : high;
        }
        if (reach > 0 && (low >= reach || high < -reach))
            return false;
    }
    return true;
}

bool oracle_thin_by_vertices(const oracle_triangle *triangle, const oracle_box *box)
{
    for (int index = ORACLE_SAT_AXES; index-- > 0;) {
        int64_t n[3];
        bool some_below = false, some_above = false;

        thin_axis(triangle, index, n);
        oracle_wide reach = doubled_reach(box, n);
        for (int vertex = 0; vertex < 3; vertex++) {
            some_below = some_below || doubled_offset(triangle, vertex, box, n) - reach < 0;
            some_above = some_above || doubled_offset(triangle, vertex, box, n) + reach >= 0;
        }
        if (reach > 0 && !(some_below && some_above))
            return false;
    }
    return true;
}
