/* SPDX-License-Identifier: MIT */
/* What the payload should be, in double precision: triangles are clipped to voxels without any rounding to speak of. */
#include <math.h>
#include <string.h>

#include "payload_pair.h"
#include "payload_reference.h"

/* Bilinear, in texels from the middle of the first. */
static double double_sample(const svo_texture *texture, double u, double v, unsigned channel)
{
    const double x = u * texture->width - 0.5;
    const double y = v * texture->height - 0.5;
    const int64_t column = (int64_t)floor(x);
    const int64_t row = (int64_t)floor(y);
    const double right = x - (double)column;
    const double below = y - (double)row;
    const double upper = (double)payload_texel(texture, column, row, channel) * (1.0 - right) +
                         (double)payload_texel(texture, column + 1, row, channel) * right;
    const double lower = (double)payload_texel(texture, column, row + 1, channel) * (1.0 - right) +
                         (double)payload_texel(texture, column + 1, row + 1, channel) * right;
    return upper * (1.0 - below) + lower * below;
}

static void add_double_color(const svo_mesh *mesh, uint32_t triangle, const uint32_t indices[3],
                             const double weights[3], double color[4])
{
    const svo_material *material = payload_material(mesh, triangle);
    const svo_texture *texture = payload_texture(mesh, triangle);
    double uv[2] = {0.0, 0.0};
    for (unsigned corner = 0; corner < 3 && texture != NULL; ++corner) {
        uv[0] += weights[corner] * (double)mesh->uvs[(size_t)indices[corner] * 2];
        uv[1] += weights[corner] * (double)mesh->uvs[(size_t)indices[corner] * 2 + 1];
    }
    for (unsigned channel = 0; channel < 4; ++channel) {
        double value = material != NULL ? material->rgba[channel] : 255.0;
        if (mesh->colors != NULL) {
            double mixed = 0.0;
            for (unsigned corner = 0; corner < 3; ++corner) {
                mixed += weights[corner] * mesh->colors[(size_t)indices[corner] * 4 + channel];
            }
            value *= mixed / 255.0;
        }
        color[channel] += texture != NULL ? value * double_sample(texture, uv[0], uv[1], channel) / 255.0 : value;
    }
}

/* A polygon in space, in grid units from the voxel's corner. */
typedef struct double_polygon {
    double corners[9][3];
    unsigned count;
} double_polygon;

/* Keeps what lies on the positive side of sign * (x[axis] - bound) = 0. */
static double_polygon cut(const double_polygon *from, unsigned axis, double sign, double bound)
{
    double_polygon to = {.count = 0};
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

static double_polygon clipped(const payload_pair *pair)
{
    double_polygon p = {.count = 3};
    for (unsigned corner = 0; corner < 3; ++corner) {
        for (unsigned axis = 0; axis < 3; ++axis) {
            p.corners[corner][axis] = (double)(pair->corners[corner][axis] - pair->box.corner[axis]);
        }
    }
    for (unsigned axis = 0; axis < 3; ++axis) {
        p = cut(&p, axis, 1.0, 0.0);
        p = cut(&p, axis, -1.0, (double)pair->box.width);
    }
    return p;
}

double payload_double_part(const payload_pair *pair, double centroid[3])
{
    const double_polygon p = clipped(pair);
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
    const double width = (double)pair->box.width;
    for (unsigned k = 0; k < 3; ++k) {
        centroid[k] = area > 0.0 ? moment[k] / area : width / 2.0;
    }
    return area / (width * width);
}

/* Corner weights at a point, given in grid units from the voxel's corner. */
static void double_weights(const payload_pair *pair, const double at[3], double weights[3])
{
    const unsigned axis = payload_pair_axis(pair->corners);
    const unsigned u = (axis + 1) % 3;
    const unsigned v = (axis + 2) % 3;
    double whole = 0.0;
    double sign = 0.0;
    for (unsigned k = 0; k < 3; ++k) {
        const int32_t *p = pair->corners[(k + 1) % 3];
        const int32_t *q = pair->corners[(k + 2) % 3];
        const double p_u = (double)(p[u] - pair->box.corner[u]) - at[u];
        const double p_v = (double)(p[v] - pair->box.corner[v]) - at[v];
        const double q_u = (double)(q[u] - pair->box.corner[u]) - at[u];
        const double q_v = (double)(q[v] - pair->box.corner[v]) - at[v];
        weights[k] = p_u * q_v - p_v * q_u;
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

/* The weight of a pair and its corners' weights. What has no area weighs next to nothing. */
static double double_share(const payload_pair *pair, svo_weights mode, double weights[3])
{
    double centroid[3];
    const double half = (double)pair->box.width * 0.5;
    const double middle[3] = {half, half, half};
    const double area = payload_double_part(pair, centroid);
    double_weights(pair, mode == SVO_WEIGHTS_AREA ? centroid : middle, weights);
    if (mode == SVO_WEIGHTS_UNIFORM) {
        weights[0] = weights[1] = weights[2] = 1.0 / 3.0;
    }
    return mode == SVO_WEIGHTS_AREA ? fmax(area, 1e-9) : 1.0;
}

void payload_double_colors(const svo_mesh *mesh, const exact *expected, svo_weights weights, double *rgba)
{
    const oracle_pairs *pairs = &expected->pairs;
    size_t leaf = 0;
    for (size_t begin = 0, end = 0; begin < pairs->count; begin = end, ++leaf) {
        double color[4] = {0.0, 0.0, 0.0, 0.0};
        double total = 0.0;
        for (end = begin; end < pairs->count && pairs->pairs[end].code == pairs->pairs[begin].code; ++end) {
            payload_pair opened;
            double corners[3];
            double one[4] = {0.0, 0.0, 0.0, 0.0};
            payload_pair_open(expected, &pairs->pairs[end], &opened);
            const double weight = double_share(&opened, weights, corners);
            add_double_color(mesh, pairs->pairs[end].triangle, opened.indices, corners, one);
            for (unsigned channel = 0; channel < 4; ++channel) {
                color[channel] += weight * one[channel];
            }
            total += weight;
        }
        for (unsigned channel = 0; channel < 4; ++channel) {
            rgba[leaf * 4 + channel] = color[channel] / total;
        }
    }
}

void payload_double_areas(const exact *expected, double *areas)
{
    const oracle_pairs *pairs = &expected->pairs;
    size_t leaf = 0;
    for (size_t i = 0; i < pairs->count; ++i) {
        payload_pair opened;
        double centroid[3];
        leaf += i > 0 && pairs->pairs[i].code != pairs->pairs[i - 1].code ? 1 : 0;
        areas[leaf] = i == 0 || pairs->pairs[i].code != pairs->pairs[i - 1].code ? 0.0 : areas[leaf];
        payload_pair_open(expected, &pairs->pairs[i], &opened);
        areas[leaf] += payload_double_part(&opened, centroid);
    }
}
