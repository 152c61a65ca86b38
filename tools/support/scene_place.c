/* SPDX-License-Identifier: MIT */
/* Matrices from scale, angles and translation, and back. */
#include "support/scene_place.h"

#include <math.h>
#include <string.h>

#include "svocl/scene.h"

#define PI 3.14159265358979323846

/* Columns count as perpendicular up to this cosine: float matrices of a placement are not exactly so. */
#define SHEAR_MAX 1e-5

/* Turns the columns of a matrix about an axis. */
static void turn(double matrix[9], int axis, double degrees)
{
    const int a = (axis + 1) % 3;
    const int b = (axis + 2) % 3;
    const double c = cos(degrees * PI / 180);
    const double s = sin(degrees * PI / 180);
    for (int k = 0; k < 3; ++k) {
        const double u = matrix[3 * a + k];
        const double v = matrix[3 * b + k];
        matrix[3 * a + k] = c * u - s * v;
        matrix[3 * b + k] = s * u + c * v;
    }
}

void scene_place_compose(const scene_place *place, float transform[12])
{
    double matrix[9] = {0};
    matrix[0] = (double)place->scale[0];
    matrix[4] = (double)place->scale[1];
    matrix[8] = (double)place->scale[2];
    for (int axis = 0; axis < 3; ++axis) {
        turn(matrix, axis, (double)place->rotate[axis]);
    }
    for (int i = 0; i < 12; ++i) {
        transform[i] = i % 4 == 3 ? place->translate[i / 4] : (float)matrix[3 * (i / 4) + i % 4];
    }
}

/* ---- back ---- */

static double dot_columns(const double matrix[9], int a, int b)
{
    return matrix[a] * matrix[b] + matrix[3 + a] * matrix[3 + b] + matrix[6 + a] * matrix[6 + b];
}

static double determinant(const double m[9])
{
    return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) + m[2] * (m[3] * m[7] - m[4] * m[6]);
}

bool scene_place_is_flat(const float transform[12])
{
    double matrix[9];
    double least = SVO_SCENE_DETERMINANT_MIN;
    for (int i = 0; i < 9; ++i) {
        matrix[i] = (double)transform[4 * (i / 3) + i % 3];
    }
    for (int k = 0; k < 3; ++k) {
        least *= sqrt(dot_columns(matrix, k, k));
    }
    return !(fabs(determinant(matrix)) > least);
}

/* Divides the columns by their lengths, which are the scales; false where the columns are not perpendicular. */
static bool split_scale(double matrix[9], double scale[3])
{
    for (int k = 0; k < 3; ++k) {
        scale[k] = sqrt(dot_columns(matrix, k, k));
    }
    scale[2] = determinant(matrix) < 0 ? -scale[2] : scale[2];
    for (int i = 0; i < 9; ++i) {
        matrix[i] /= scale[i % 3];
    }
    return fabs(dot_columns(matrix, 0, 1)) < SHEAR_MAX && fabs(dot_columns(matrix, 1, 2)) < SHEAR_MAX &&
           fabs(dot_columns(matrix, 2, 0)) < SHEAR_MAX;
}

/* Degrees about x, then y, then z. Where y is a quarter turn, x and z turn alike, and x is 0. */
static void split_angles(const double m[9], double degrees[3])
{
    const double sine = fmin(fmax(-m[6], -1), 1);
    const bool is_quarter = fabs(sine) > 1 - 1e-12;
    degrees[0] = is_quarter ? 0 : atan2(m[7], m[8]) * 180 / PI;
    degrees[1] = asin(sine) * 180 / PI;
    degrees[2] = (is_quarter ? atan2(-m[1], m[4]) : atan2(m[3], m[0])) * 180 / PI;
}

static double rounded(double value, double step)
{
    return round(value / step) * step + 0.0; /* never -0 */
}

bool scene_place_is_exact(const scene_place *place, const float transform[12])
{
    float composed[12];
    scene_place_compose(place, composed);
    for (int i = 0; i < 12; ++i) {
        if (composed[i] != transform[i]) {
            return false;
        }
    }
    return true;
}

bool scene_place_find(const float transform[12], scene_place *out)
{
    static const double steps[] = {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 0};
    double matrix[9];
    double scale[3];
    double degrees[3];
    for (int i = 0; i < 9; ++i) {
        matrix[i] = (double)transform[4 * (i / 3) + i % 3];
    }
    if (!split_scale(matrix, scale)) {
        return false;
    }
    split_angles(matrix, degrees);
    for (int i = 0; i < (int)(sizeof steps / sizeof steps[0]); ++i) {
        for (int k = 0; k < 3; ++k) {
            out->translate[k] = transform[4 * k + 3];
            out->rotate[k] = (float)(steps[i] > 0 ? rounded(degrees[k], steps[i]) : degrees[k]);
            out->scale[k] = (float)(steps[i] > 0 ? rounded(scale[k], steps[i]) : scale[k]);
        }
        if (scene_place_is_exact(out, transform)) {
            break;
        }
    }
    return true;
}
