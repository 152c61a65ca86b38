/* SPDX-License-Identifier: MIT */
/* The payload in double precision: clips triangles to voxels with negligible rounding. */
#include <math.h>
#include <string.h>

#include "payload_pair.h"
#include "payload_reference.h"

/* A channel of a texel; red, green and blue times alpha. */
static double weighed_texel(const svo_texture *texture, int64_t column, int64_t row, unsigned channel)
{
    const double alpha = channel < 3 ? (double)payload_texel(texture, column, row, 3) : 1.0;
    return (double)payload_texel(texture, column, row, channel) * alpha;
}

/* Bilinear filtering of weighed texels; coordinates in texels from the center of the first. */
static double double_texels(const svo_texture *texture, double u, double v, unsigned channel)
{
    const double x = u * texture->width - 0.5;
    const double y = v * texture->height - 0.5;
    const int64_t column = (int64_t)floor(x);
    const int64_t row = (int64_t)floor(y);
    const double right = x - (double)column;
    const double below = y - (double)row;
    const double upper = weighed_texel(texture, column, row, channel) * (1.0 - right) +
                         weighed_texel(texture, column + 1, row, channel) * right;
    const double lower = weighed_texel(texture, column, row + 1, channel) * (1.0 - right) +
                         weighed_texel(texture, column + 1, row + 1, channel) * right;
    return upper * (1.0 - below) + lower * below;
}

static double double_sample(const svo_texture *texture, double u, double v, unsigned channel)
{
    const double alpha = double_texels(texture, u, v, 3);
    return channel == 3 ? alpha : double_texels(texture, u, v, channel) / fmax(alpha, 1e-9);
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

static void triangle_of(const payload_pair *pair, double triangle[3][3])
{
    for (unsigned corner = 0; corner < 3; ++corner) {
        for (unsigned axis = 0; axis < 3; ++axis) {
            triangle[corner][axis] = (double)pair->corners[corner][axis];
        }
    }
}

double payload_double_part(const payload_pair *pair, double centroid[3])
{
    double triangle[3][3];
    triangle_of(pair, triangle);
    return oracle_part(triangle, (double)PAYLOAD_WIDTH, centroid);
}

/* The weight of a pair and its corners' weights. Pairs without area get a tiny weight. */
static double double_share(const payload_pair *pair, svo_weights mode, double weights[3])
{
    double centroid[3];
    double triangle[3][3];
    const double half = (double)PAYLOAD_WIDTH * 0.5;
    const double middle[3] = {half, half, half};
    const double area = payload_double_part(pair, centroid);
    triangle_of(pair, triangle);
    oracle_corner_weights(triangle, mode == SVO_WEIGHTS_AREA ? centroid : middle, weights);
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
                color[channel] += weight * one[channel] * (channel < 3 ? one[3] : 1.0);
            }
            total += weight;
        }
        for (unsigned channel = 0; channel < 4; ++channel) {
            rgba[leaf * 4 + channel] = color[channel] / (channel < 3 ? fmax(color[3], 1e-9) : total);
        }
    }
}

static void add_double_projections(const payload_pair *pair, bool both_sides, double seen[6])
{
    double centroid[3];
    int64_t normal[3];
    payload_pair_normal(pair->corners, normal);
    const double length = sqrt((double)normal[0] * (double)normal[0] + (double)normal[1] * (double)normal[1] +
                               (double)normal[2] * (double)normal[2]);
    const double area = payload_double_part(pair, centroid);
    for (unsigned i = 0; i < 6 && length > 0.0; ++i) {
        const unsigned axis = i / 2;
        const double n = (double)normal[axis];
        if (both_sides || (i % 2 == 0 ? n < 0.0 : n > 0.0)) {
            seen[i] += area * fabs(n) / length;
        }
    }
}

void payload_double_projections(const exact *expected, bool both_sides, double *seen)
{
    const oracle_pairs *pairs = &expected->pairs;
    size_t leaf = 0;
    memset(seen, 0, (expected->tree.node_count - expected->tree.inner_count) * 6 * sizeof *seen);
    for (size_t i = 0; i < pairs->count; ++i) {
        payload_pair opened;
        leaf += i > 0 && pairs->pairs[i].code != pairs->pairs[i - 1].code ? 1 : 0;
        payload_pair_open(expected, &pairs->pairs[i], &opened);
        add_double_projections(&opened, both_sides, seen + leaf * 6);
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
