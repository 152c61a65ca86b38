/* SPDX-License-Identifier: MIT */
/* Matrices of instances: checks, inverses, normals and boxes. Everything is computed in double, add, subtract,
   multiply, divide and square root alone, so the records are the same bytes on every machine. */
#include "scene/place.h"

#include <math.h>

/* Coordinates and entries of inverses are below this, so that the kernels' floats do not overflow. */
#define LARGEST 0x1p100

typedef struct linear {
    double m[3][3]; /* rows */
} linear;

static bool is_finite(const float matrix[12])
{
    bool finite = true;
    for (int i = 0; i < 12; ++i) {
        finite = finite && isfinite(matrix[i]);
    }
    return finite;
}

/* The transpose of the matrix of cofactors: the inverse times the determinant. */
static linear adjugate(const linear *a)
{
    linear out;
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            const int i1 = (i + 1) % 3;
            const int i2 = (i + 2) % 3;
            const int k1 = (k + 1) % 3;
            const int k2 = (k + 2) % 3;
            out.m[k][i] = a->m[i1][k1] * a->m[i2][k2] - a->m[i1][k2] * a->m[i2][k1];
        }
    }
    return out;
}

static double column_length(const linear *a, int k)
{
    return sqrt(a->m[0][k] * a->m[0][k] + a->m[1][k] * a->m[1][k] + a->m[2][k] * a->m[2][k]);
}

/* Stores the inverse in two floats per entry, and the images of the faces' normals, which are its rows. */
static bool store_inverse(const linear *inverse, svo_scene_instance *out)
{
    bool fits = true;
    for (int row = 0; row < 3; ++row) {
        const double *entries = inverse->m[row];
        const double length = sqrt(entries[0] * entries[0] + entries[1] * entries[1] + entries[2] * entries[2]);
        for (int k = 0; k < 3; ++k) {
            fits = fits && fabs(entries[k]) < LARGEST;
            out->inverse[3 * row + k] = (float)entries[k];
            out->inverse_rest[3 * row + k] = (float)(entries[k] - (double)out->inverse[3 * row + k]);
            out->normals[3 * row + k] = (float)(entries[k] / length) + 0.0F; /* never -0 */
        }
    }
    return fits;
}

/* The box of the image of a box, rounded outwards. */
static bool store_box(const linear *a, const float matrix[12], const svo_i_scene_box *box, svo_scene_instance *out)
{
    bool fits = true;
    for (int row = 0; row < 3; ++row) {
        double middle = (double)matrix[4 * row + 3];
        double half = 0;
        double size = fabs(middle);
        for (int k = 0; k < 3; ++k) {
            middle += a->m[row][k] * (0.5 * (box->low[k] + box->high[k]));
            half += fabs(a->m[row][k]) * (0.5 * (box->high[k] - box->low[k]));
            size += fabs(a->m[row][k]) * fmax(fabs(box->low[k]), fabs(box->high[k]));
        }
        half += size * 0x1p-48; /* what these sums may round */
        fits = fits && middle - half > -LARGEST && middle + half < LARGEST;
        out->low[row] = nextafterf((float)(middle - half), -INFINITY);
        out->high[row] = nextafterf((float)(middle + half), INFINITY);
        out->translation[row] = matrix[4 * row + 3];
    }
    return fits;
}

svo_status svo_i_scene_place(svo_device *device, const char *function, uint32_t instance, const float matrix[12],
                             const svo_i_scene_box *tree_box, svo_scene_instance *out)
{
    linear a;
    if (!is_finite(matrix)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: the matrix of instance %u is not finite", function,
                                 instance);
    }
    for (int i = 0; i < 12; ++i) {
        if (i % 4 < 3) {
            a.m[i / 4][i % 4] = (double)matrix[i];
        }
    }
    const linear scaled = adjugate(&a);
    const double determinant = a.m[0][0] * scaled.m[0][0] + a.m[0][1] * scaled.m[1][0] + a.m[0][2] * scaled.m[2][0];
    const double lengths[3] = {column_length(&a, 0), column_length(&a, 1), column_length(&a, 2)};
    const double least = SVO_SCENE_DETERMINANT_MIN * lengths[0] * lengths[1] * lengths[2];
    if (!(fabs(determinant) > least)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "%s: the matrix of instance %u is flat: determinant %g, its size is not above %g",
                                 function, instance, determinant, least);
    }
    linear inverse;
    for (int i = 0; i < 9; ++i) {
        inverse.m[i / 3][i % 3] = scaled.m[i / 3][i % 3] / determinant;
    }
    const bool inverse_fits = store_inverse(&inverse, out);
    if (!store_box(&a, matrix, tree_box, out) || !inverse_fits) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "%s: the matrix of instance %u or its inverse leads beyond 2^100", function, instance);
    }
    out->widest = (float)fmax(lengths[0], fmax(lengths[1], lengths[2]));
    return SVO_OK;
}
