/* SPDX-License-Identifier: MIT */
/* The payload by the definition, twice: in integers, bit for bit what the kernels make, and in doubles, what it should be. */
#include "payload_reference.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define WEIGHT_BITS 16
#define WEIGHT_ONE  (INT64_C(1) << WEIGHT_BITS)

/* What a node's pairs add up to. */
typedef struct sums {
    int64_t pair_count;
    int64_t color[4], normal[3];
} sums;

/* The mesh as the definition sees it. */
typedef struct surface {
    const svo_mesh *mesh;
    const exact *snapped;
} surface;

/* numerator / denominator rounded half up; denominator > 0. */
static int64_t round_half_up(int64_t numerator, int64_t denominator)
{
    const int64_t doubled = 2 * numerator + denominator;
    const int64_t quotient = doubled / (2 * denominator);
    return doubled % (2 * denominator) < 0 ? quotient - 1 : quotient;
}

static int64_t floor_remainder(int64_t value, int64_t period)
{
    return (value % period + period) % period;
}

/* Twice the signed area of the triangle (point, p, q) seen along axis. */
static int64_t area_seen(const int64_t point[3], const int32_t p[3], const int32_t q[3], unsigned axis)
{
    const unsigned u = (axis + 1) % 3;
    const unsigned v = (axis + 2) % 3;
    return (p[u] - point[u]) * (q[v] - point[v]) - (p[v] - point[v]) * (q[u] - point[u]);
}

/* The axis along which the triangle looks largest; of equals the first. */
static unsigned axis_of_view(const int32_t *const corners[3])
{
    const int64_t first[3] = {corners[0][0], corners[0][1], corners[0][2]};
    int64_t areas[3];
    for (unsigned axis = 0; axis < 3; ++axis) {
        areas[axis] = llabs(area_seen(first, corners[1], corners[2], axis));
    }
    unsigned best = 0;
    best = areas[1] > areas[best] ? 1 : best;
    return areas[2] > areas[best] ? 2 : best;
}

/* The parts of the triangle opposite each corner, seen from point; none negative, all 0 for a triangle of no area. */
static void corner_parts(const int32_t *const corners[3], const int64_t point[3], int64_t parts[3])
{
    const unsigned axis = axis_of_view(corners);
    parts[0] = area_seen(point, corners[1], corners[2], axis);
    parts[1] = area_seen(point, corners[2], corners[0], axis);
    parts[2] = area_seen(point, corners[0], corners[1], axis);
    const int64_t area = parts[0] + parts[1] + parts[2];
    const int64_t turn = area < 0 ? -1 : area > 0 ? 1 : 0;
    for (unsigned k = 0; k < 3; ++k) {
        parts[k] = parts[k] * turn > 0 ? parts[k] * turn : 0;
    }
}

/* Corner weights that add up to WEIGHT_ONE: shares of the 16 leading bits of the whole, cut; the first corner has what is
   left. */
static void corner_weights(const int32_t *const corners[3], const int64_t point[3], int64_t weights[3])
{
    int64_t parts[3];
    corner_parts(corners, point, parts);
    int64_t whole = parts[0] + parts[1] + parts[2];
    if (whole == 0) {
        weights[1] = weights[2] = WEIGHT_ONE / 3;
    } else {
        for (; whole >= WEIGHT_ONE; whole /= 2) {
            parts[1] /= 2;
            parts[2] /= 2;
        }
        weights[1] = parts[1] * WEIGHT_ONE / whole;
        weights[2] = parts[2] * WEIGHT_ONE / whole;
    }
    weights[0] = WEIGHT_ONE - weights[1] - weights[2];
}

static int64_t blend(const int64_t values[3], const int64_t weights[3])
{
    return round_half_up(values[0] * weights[0] + values[1] * weights[1] + values[2] * weights[2], WEIGHT_ONE);
}

/* The triangle's material, or NULL for white. */
static const svo_material *material_of(const svo_mesh *mesh, uint32_t triangle)
{
    const uint32_t given = mesh->triangle_materials != NULL ? mesh->triangle_materials[triangle] : 0;
    return mesh->material_count > 0 ? &mesh->materials[given < mesh->material_count ? given : 0] : NULL;
}

static const svo_texture *texture_of(const svo_mesh *mesh, uint32_t triangle)
{
    const svo_material *material = material_of(mesh, triangle);
    return mesh->uvs != NULL && material != NULL && material->texture_index < mesh->texture_count
               ? &mesh->textures[material->texture_index]
               : NULL;
}

static int64_t wrapped_texel(int64_t texel, int64_t texel_count, svo_wrap wrap)
{
    if (wrap == SVO_WRAP_CLAMP) {
        return texel < 0 ? 0 : texel >= texel_count ? texel_count - 1 : texel;
    }
    if (wrap == SVO_WRAP_REPEAT) {
        return floor_remainder(texel, texel_count);
    }
    const int64_t inside = floor_remainder(texel, 2 * texel_count);
    return inside < texel_count ? inside : 2 * texel_count - 1 - inside;
}

static int64_t texel_value(const svo_texture *texture, int64_t x, int64_t y, unsigned channel)
{
    const int64_t column = wrapped_texel(x, texture->width, texture->wrap_u);
    const int64_t row = wrapped_texel(y, texture->height, texture->wrap_v);
    return texture->rgba[(row * texture->width + column) * 4 + channel];
}

/* Texture coordinate, WEIGHT_ONE = 1, to 256ths of a texel from the middle of the first. */
static int64_t texel_position(int64_t coordinate, uint32_t texel_count)
{
    return round_half_up(coordinate * texel_count * 256, WEIGHT_ONE) - 128;
}

static int64_t sampled(const svo_texture *texture, const int64_t uv[2], unsigned channel)
{
    const int64_t x = texel_position(uv[0], texture->width);
    const int64_t y = texel_position(uv[1], texture->height);
    const int64_t right = floor_remainder(x, 256);
    const int64_t below = floor_remainder(y, 256);
    const int64_t column = (x - right) / 256;
    const int64_t row = (y - below) / 256;
    const int64_t upper = texel_value(texture, column, row, channel) * (256 - right) +
                          texel_value(texture, column + 1, row, channel) * right;
    const int64_t lower = texel_value(texture, column, row + 1, channel) * (256 - right) +
                          texel_value(texture, column + 1, row + 1, channel) * right;
    return round_half_up(upper * (256 - below) + lower * below, 65536);
}

static int64_t fixed_uv(float value)
{
    if (!isfinite(value)) {
        return 0;
    }
    const double limited = value > 32767.0F ? 32767.0 : value < -32767.0F ? -32767.0 : (double)value;
    return (int64_t)rint(limited * 65536.0);
}

static void sample_uv(const svo_mesh *mesh, const uint32_t corners[3], const int64_t weights[3], int64_t uv[2])
{
    for (unsigned axis = 0; axis < 2; ++axis) {
        int64_t values[3];
        for (unsigned corner = 0; corner < 3; ++corner) {
            values[corner] = fixed_uv(mesh->uvs[(size_t)corners[corner] * 2 + axis]);
        }
        uv[axis] = blend(values, weights);
    }
}

static void add_color(const svo_mesh *mesh, uint32_t triangle, const uint32_t corners[3], const int64_t weights[3],
                      int64_t color[4])
{
    const svo_material *material = material_of(mesh, triangle);
    const svo_texture *texture = texture_of(mesh, triangle);
    int64_t uv[2] = {0, 0};
    if (texture != NULL) {
        sample_uv(mesh, corners, weights, uv);
    }
    for (unsigned channel = 0; channel < 4; ++channel) {
        int64_t value = material != NULL ? material->rgba[channel] : 255;
        if (mesh->colors != NULL) {
            int64_t values[3];
            for (unsigned corner = 0; corner < 3; ++corner) {
                values[corner] = mesh->colors[(size_t)corners[corner] * 4 + channel];
            }
            value = round_half_up(value * blend(values, weights), 255);
        }
        if (texture != NULL) {
            value = round_half_up(value * sampled(texture, uv, channel), 255);
        }
        color[channel] += value;
    }
}

/* 32767 = 1; zero where there is no direction. */
static void fixed_unit(const double vector[3], int64_t out[3])
{
    const double length = sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
    for (unsigned axis = 0; axis < 3; ++axis) {
        out[axis] = isfinite(length) && length > 0.0 ? (int64_t)rint(vector[axis] / length * 32767.0) : 0;
    }
}

static void own_normal(const int32_t *const corners[3], int64_t out[3])
{
    const int64_t first[3] = {corners[0][0], corners[0][1], corners[0][2]};
    double normal[3];
    for (unsigned axis = 0; axis < 3; ++axis) {
        normal[axis] = (double)area_seen(first, corners[1], corners[2], axis);
    }
    fixed_unit(normal, out);
}

static void add_normal(const svo_mesh *mesh, const uint32_t indices[3], const int32_t *const corners[3],
                       const int64_t weights[3], int64_t normal[3])
{
    int64_t own[3];
    int64_t values[3][3]; /* axis, corner */
    own_normal(corners, own);
    for (unsigned corner = 0; corner < 3; ++corner) {
        int64_t unit[3] = {0, 0, 0};
        if (mesh->normals != NULL) {
            const float *n = mesh->normals + (size_t)indices[corner] * 3;
            fixed_unit((const double[3]){(double)n[0], (double)n[1], (double)n[2]}, unit);
        }
        const int64_t *chosen = unit[0] == 0 && unit[1] == 0 && unit[2] == 0 ? own : unit;
        for (unsigned axis = 0; axis < 3; ++axis) {
            values[axis][corner] = chosen[axis];
        }
    }
    for (unsigned axis = 0; axis < 3; ++axis) {
        normal[axis] += blend(values[axis], weights);
    }
}

/* A pair's triangle, given by its id, and the middle of its voxel. */
static void open_pair(const exact *expected, const oracle_pair *pair, uint32_t indices[3], const int32_t *corners[3],
                      int64_t middle[3])
{
    size_t low = 0;
    size_t high = expected->triangle_count;
    while (high - low > 1) {
        const size_t half = (low + high) / 2;
        *(expected->triangle_ids[half] <= pair->triangle ? &low : &high) = half;
    }
    for (unsigned corner = 0; corner < 3; ++corner) {
        indices[corner] = expected->indices[low * 3 + corner];
        corners[corner] = expected->vertices + (size_t)indices[corner] * 3;
    }
    oracle_box box;
    oracle_voxel_box(pair->code, expected->tree.depth, expected->grid.snap_bits, &box);
    for (unsigned axis = 0; axis < 3; ++axis) {
        middle[axis] = box.corner[axis] + box.width / 2;
    }
}

static void add_pair(const surface *of, const oracle_pair *pair, sums *leaf)
{
    uint32_t indices[3];
    const int32_t *corners[3];
    int64_t middle[3];
    int64_t weights[3];
    open_pair(of->snapped, pair, indices, corners, middle);
    corner_weights(corners, middle, weights);
    ++leaf->pair_count;
    add_color(of->mesh, pair->triangle, indices, weights, leaf->color);
    add_normal(of->mesh, indices, corners, weights, leaf->normal);
}

static void add_sums(sums *to, const sums *from)
{
    to->pair_count += from->pair_count;
    for (unsigned channel = 0; channel < 4; ++channel) {
        to->color[channel] += from->color[channel];
    }
    for (unsigned axis = 0; axis < 3; ++axis) {
        to->normal[axis] += from->normal[axis];
    }
}

/* Leaves from the pairs, then every inner node from its children, the last one first. */
static void sum_nodes(const surface *of, sums *nodes)
{
    const oracle_tree *tree = &of->snapped->tree;
    const oracle_pairs *pairs = &of->snapped->pairs;
    size_t leaf = tree->inner_count;
    for (size_t i = 0; i < pairs->count; ++i) {
        leaf += i > 0 && pairs->pairs[i].code != pairs->pairs[i - 1].code ? 1 : 0;
        add_pair(of, &pairs->pairs[i], &nodes[leaf]);
    }
    for (size_t node = tree->inner_count; node-- > 0;) {
        size_t child = tree->first_child[node];
        for (unsigned octant = 0; octant < 8; ++octant) {
            if ((tree->child_mask[node] >> octant & 1) != 0) {
                add_sums(&nodes[node], &nodes[child++]);
            }
        }
    }
}

void payload_reference_create(const svo_mesh *mesh, const exact *expected, payload_reference *out)
{
    const size_t node_count = expected->tree.node_count;
    const surface of = {mesh, expected};
    sums *nodes = calloc(node_count, sizeof *nodes);
    out->colors = calloc(node_count, 4);
    out->normals = calloc(node_count * 3, sizeof(int16_t));
    assert_non_null(nodes);
    assert_non_null(out->colors);
    assert_non_null(out->normals);
    sum_nodes(&of, nodes);
    for (size_t node = 0; node < node_count; ++node) {
        const int64_t pair_count = nodes[node].pair_count > 0 ? nodes[node].pair_count : 1; /* an empty root: zeros */
        for (unsigned channel = 0; channel < 4; ++channel) {
            out->colors[node * 4 + channel] = (uint8_t)round_half_up(nodes[node].color[channel], pair_count);
        }
        for (unsigned axis = 0; axis < 3; ++axis) {
            out->normals[node * 3 + axis] = (int16_t)round_half_up(nodes[node].normal[axis], pair_count);
        }
    }
    free(nodes);
}

void payload_reference_destroy(payload_reference *made)
{
    free(made->colors);
    free(made->normals);
    *made = (payload_reference){0};
}

/* Bilinear, in texels from the middle of the first. */
static double double_sample(const svo_texture *texture, double u, double v, unsigned channel)
{
    const double x = u * texture->width - 0.5;
    const double y = v * texture->height - 0.5;
    const int64_t column = (int64_t)floor(x);
    const int64_t row = (int64_t)floor(y);
    const double right = x - (double)column;
    const double below = y - (double)row;
    const double upper = (double)texel_value(texture, column, row, channel) * (1.0 - right) +
                         (double)texel_value(texture, column + 1, row, channel) * right;
    const double lower = (double)texel_value(texture, column, row + 1, channel) * (1.0 - right) +
                         (double)texel_value(texture, column + 1, row + 1, channel) * right;
    return upper * (1.0 - below) + lower * below;
}

static void add_double_color(const svo_mesh *mesh, uint32_t triangle, const uint32_t indices[3],
                             const double weights[3], double color[4])
{
    const svo_material *material = material_of(mesh, triangle);
    const svo_texture *texture = texture_of(mesh, triangle);
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

static void double_weights(const int32_t *const corners[3], const int64_t middle[3], double weights[3])
{
    int64_t parts[3];
    corner_parts(corners, middle, parts);
    const double whole = (double)(parts[0] + parts[1] + parts[2]);
    for (unsigned k = 0; k < 3; ++k) {
        weights[k] = whole > 0.0 ? (double)parts[k] / whole : 1.0 / 3.0;
    }
}

void payload_double_colors(const svo_mesh *mesh, const exact *expected, double *rgba)
{
    const oracle_pairs *pairs = &expected->pairs;
    size_t leaf = 0;
    for (size_t begin = 0; begin < pairs->count; ++leaf) {
        double color[4] = {0.0, 0.0, 0.0, 0.0};
        size_t end = begin;
        for (; end < pairs->count && pairs->pairs[end].code == pairs->pairs[begin].code; ++end) {
            uint32_t indices[3];
            const int32_t *corners[3];
            int64_t middle[3];
            double weights[3];
            open_pair(expected, &pairs->pairs[end], indices, corners, middle);
            double_weights(corners, middle, weights);
            add_double_color(mesh, pairs->pairs[end].triangle, indices, weights, color);
        }
        for (unsigned channel = 0; channel < 4; ++channel) {
            rgba[leaf * 4 + channel] = color[channel] / (double)(end - begin);
        }
        begin = end;
    }
}
