/* SPDX-License-Identifier: MIT */
/*
 * First reference: the separating axis test over 13 axes (Akenine-Moller, "Fast 3D Triangle-Box Overlap Testing"), in
 * 128-bit integers. A triangle and a closed box are disjoint exactly when one of these axes separates them. The
 * half-open box is the union of the closed boxes of width w - e over all e > 0; letting e shrink turns "min > P (w -
 * e)" into "min >= P w" where P > 0, and leaves it alone where P = 0.
 *
 * Widths: |coordinate| < 2^30, so edges fit 31 bits and a sign, axis components 63 bits and a sign; sums of components
 * need 65 bits, projections and products with the width 97.
 */
#include "predicate.h"

static oracle_wide project(const int64_t direction[3], const int64_t point[3])
{
    oracle_wide sum = 0;

    for (int k = 0; k < 3; k++)
        sum += (oracle_wide)direction[k] * point[k];
    return sum;
}

static void cross(const int64_t a[3], const int64_t b[3], int64_t out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* Extents of the triangle and of the unit cube along the axis. */
static void measure(const oracle_triangle *triangle, oracle_sat_axis *axis)
{
    for (int i = 0; i < 3; i++) {
        const int64_t point[3] = {triangle->vertex[i][0], triangle->vertex[i][1], triangle->vertex[i][2]};
        oracle_wide projection = project(axis->direction, point);

        if (i == 0 || projection < axis->minimum)
            axis->minimum = projection;
        if (i == 0 || projection > axis->maximum)
            axis->maximum = projection;
    }
    axis->positive = axis->negative = 0;
    for (int k = 0; k < 3; k++) {
        if (axis->direction[k] > 0)
            axis->positive += axis->direction[k];
        else
            axis->negative -= axis->direction[k];
    }
}

void oracle_sat_prepare(const oracle_triangle *triangle, oracle_sat_triangle *prepared)
{
    static const int64_t box_axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    int64_t edges[3][3];
    int axis_count = 0;

    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            edges[i][k] = (int64_t)triangle->vertex[(i + 1) % 3][k] - triangle->vertex[i][k];
    for (int k = 0; k < 3; k++, axis_count++)
        for (int j = 0; j < 3; j++)
            prepared->axes[axis_count].direction[j] = box_axes[k][j];
    cross(edges[0], edges[1], prepared->axes[axis_count++].direction);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            cross(box_axes[k], edges[i], prepared->axes[axis_count++].direction);
    for (int i = 0; i < ORACLE_SAT_AXES; i++)
        measure(triangle, &prepared->axes[i]);
}

/* Along the axis the box reaches from -negative * width to positive * width, relative to its corner. */
static bool is_separated(const oracle_sat_axis *axis, const oracle_box *box, oracle_coverage coverage)
{
    oracle_wide shift = project(axis->direction, box->corner);
    oracle_wide minimum = axis->minimum - shift, maximum = axis->maximum - shift;
    oracle_wide far_end = axis->positive * box->width, near_end = -axis->negative * box->width;

    if (minimum > far_end || maximum < near_end)
        return true;
    if (coverage == ORACLE_CLOSED)
        return false;
    return (axis->positive > 0 && minimum == far_end) || (axis->negative > 0 && maximum == near_end);
}

bool oracle_sat_test(const oracle_sat_triangle *prepared, const oracle_box *box, oracle_coverage coverage)
{
    for (int i = 0; i < ORACLE_SAT_AXES; i++)
        if (is_separated(&prepared->axes[i], box, coverage))
            return false;
    return true;
}

bool oracle_sat_touches(const oracle_triangle *triangle, const oracle_box *box, oracle_coverage coverage)
{
    oracle_sat_triangle prepared;

    if (coverage == ORACLE_THIN)
        return oracle_thin_by_extents(triangle, box);
    oracle_sat_prepare(triangle, &prepared);
    return oracle_sat_test(&prepared, box, coverage);
}
