/* SPDX-License-Identifier: MIT */
/* The payload by the definition, in integers: bit for bit equal to the kernels' results. */
#include "payload_reference.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "payload_pair.h"
#include "shared/clip.clh"

#define WEIGHT_BITS 16
#define WEIGHT_ONE  (INT64_C(1) << WEIGHT_BITS)

typedef struct payload_reference {
    uint8_t *colors; /* node_count * 4 */
    int16_t *normals; /* node_count * 3 */
    uint16_t *materials, *fills; /* node_count */
    uint16_t *areas; /* leaf_count * 6 */
} payload_reference;

/* The sums over a node's pairs. */
typedef struct sums {
    int64_t weight;
    int64_t color[4], normal[3]; /* color: red, green and blue times alpha, and alpha */
} sums;

/* The mesh in the definition's terms. */
typedef struct surface {
    const svo_mesh *mesh;
    const exact *snapped;
    svo_weights weights;
    uint32_t weight_log2;
    size_t material_count; /* at least 1 */
} surface;

/* A pair's contribution: its weight, and the weights of the triangle's corners, which add up to WEIGHT_ONE. */
typedef struct share {
    int64_t weight, corners[3];
} share;

/* numerator / denominator rounded half up; denominator > 0. */
static int64_t round_half_up(int64_t numerator, int64_t denominator)
{
    const int64_t doubled = 2 * numerator + denominator;
    const int64_t quotient = doubled / (2 * denominator);
    return doubled % (2 * denominator) < 0 ? quotient - 1 : quotient;
}

/* Twice the signed area of the triangle of two points and the origin. */
static int64_t area_from(const int64_t p[2], const int64_t q[2])
{
    return p[0] * q[1] - p[1] * q[0];
}

/* The areas between a point, in sub-units, and the edge opposite each corner; none is negative, all are 0 for a
   triangle without area. Distances from the point have 30 bits. */
static void corner_parts(const payload_pair *pair, unsigned axis, int64_t u, int64_t v, int64_t parts[3])
{
    int64_t from[6];
    for (unsigned corner = 0; corner < 3; ++corner) {
        from[2 * corner] = pair->corners[corner][(axis + 1) % 3] - u;
        from[2 * corner + 1] = pair->corners[corner][(axis + 2) % 3] - v;
    }
    (void)payload_halve(from, 6, 30);
    parts[0] = area_from(from + 2, from + 4);
    parts[1] = area_from(from + 4, from);
    parts[2] = area_from(from, from + 2);
    const int64_t area = parts[0] + parts[1] + parts[2];
    const int64_t turn = area < 0 ? -1 : area > 0 ? 1 : 0;
    for (unsigned k = 0; k < 3; ++k) {
        parts[k] = parts[k] * turn > 0 ? parts[k] * turn : 0;
    }
}

/* Corner weights that add up to WEIGHT_ONE: ratios to the 16 leading bits of the whole, rounded down; the first corner
   gets the remainder. */
static void corner_weights(const payload_pair *pair, unsigned axis, int64_t u, int64_t v, int64_t weights[3])
{
    int64_t parts[3];
    corner_parts(pair, axis, u, v, parts);
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

static void normal_of(const payload_pair *pair, double normal[3])
{
    int64_t whole[3];
    payload_pair_normal(pair->corners, whole);
    for (unsigned axis = 0; axis < 3; ++axis) {
        normal[axis] = (double)whole[axis];
    }
}

/* The ratio of the true area to the projected area, 2^30 = 1. */
static uint32_t stretch_of(const payload_pair *pair, unsigned axis)
{
    double n[3];
    normal_of(pair, n);
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    return (uint32_t)rint((n[axis] != 0.0 ? length / fabs(n[axis]) : 1.0) * 1073741824.0);
}

static svo_part part_of(const payload_pair *pair)
{
    const unsigned axis = payload_pair_axis(pair->corners);
    int64_t polygons[SVO_PART_WORDS];
    for (unsigned corner = 0; corner < 3; ++corner) {
        for (unsigned k = 0; k < 3; ++k) {
            const unsigned along = (axis + 1 + k) % 3;
            polygons[3 * corner + k] = pair->corners[corner][along];
        }
    }
    return svo_clip(polygons);
}

static void share_by_area(const surface *of, const payload_pair *pair, share *out)
{
    const unsigned axis = payload_pair_axis(pair->corners);
    const svo_part part = part_of(pair);
    out->weight = svo_part_weight(part.doubled_area, stretch_of(pair, axis), of->weight_log2);
    corner_weights(pair, axis, part.u, part.v, out->corners);
}

static void share_of(const surface *of, const payload_pair *pair, share *out)
{
    const unsigned axis = payload_pair_axis(pair->corners);
    out->weight = 1;
    switch (of->weights) {
    case SVO_WEIGHTS_AREA:
        share_by_area(of, pair, out);
        break;
    case SVO_WEIGHTS_CENTER:
        corner_weights(pair, axis, PAYLOAD_WIDTH / 2, PAYLOAD_WIDTH / 2, out->corners);
        break;
    default:
        out->corners[1] = out->corners[2] = WEIGHT_ONE / 3;
        out->corners[0] = WEIGHT_ONE - 2 * out->corners[1];
    }
}

static int64_t blend(const int64_t values[3], const int64_t weights[3])
{
    return round_half_up(values[0] * weights[0] + values[1] * weights[1] + values[2] * weights[2], WEIGHT_ONE);
}

/* Converts a texture coordinate, WEIGHT_ONE = 1, to 256ths of a texel from the center of the first. */
static int64_t texel_position(int64_t coordinate, uint32_t texel_count)
{
    return round_half_up(coordinate * texel_count * 256, WEIGHT_ONE) - 128;
}

uint8_t payload_alpha(uint64_t rounded, uint64_t sum, uint64_t weight)
{
    return rounded == 0 && sum > 0 ? 1 : rounded == 255 && sum < 255 * weight ? 254 : (uint8_t)rounded;
}

/* A channel of a texel; red, green and blue times alpha. */
static int64_t weighed_texel(const svo_texture *texture, int64_t column, int64_t row, unsigned channel)
{
    return payload_texel(texture, column, row, channel) * (channel < 3 ? payload_texel(texture, column, row, 3) : 1);
}

/* The sum of the four texels around a place, whose shares add up to 65536. */
static int64_t sum_of_texels(const svo_texture *texture, const int64_t uv[2], unsigned channel)
{
    const int64_t x = texel_position(uv[0], texture->width);
    const int64_t y = texel_position(uv[1], texture->height);
    const int64_t right = payload_remainder(x, 256);
    const int64_t below = payload_remainder(y, 256);
    const int64_t column = (x - right) / 256;
    const int64_t row = (y - below) / 256;
    const int64_t upper = weighed_texel(texture, column, row, channel) * (256 - right) +
                          weighed_texel(texture, column + 1, row, channel) * right;
    const int64_t lower = weighed_texel(texture, column, row + 1, channel) * (256 - right) +
                          weighed_texel(texture, column + 1, row + 1, channel) * right;
    return upper * (256 - below) + lower * below;
}

static int64_t sampled(const svo_texture *texture, const int64_t uv[2], unsigned channel)
{
    const int64_t alpha = sum_of_texels(texture, uv, 3);
    return channel == 3 ? round_half_up(alpha, 65536)
                        : round_half_up(sum_of_texels(texture, uv, channel), alpha > 0 ? alpha : 1);
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

/* The color of a triangle where its corners have those shares. */
static void color_of(const svo_mesh *mesh, uint32_t triangle, const uint32_t corners[3], const share *by,
                     int64_t one[4])
{
    const svo_material *material = payload_material(mesh, triangle);
    const svo_texture *texture = payload_texture(mesh, triangle);
    int64_t uv[2] = {0, 0};
    if (texture != NULL) {
        sample_uv(mesh, corners, by->corners, uv);
    }
    for (unsigned channel = 0; channel < 4; ++channel) {
        int64_t value = material != NULL ? material->rgba[channel] : 255;
        if (mesh->colors != NULL) {
            int64_t values[3];
            for (unsigned corner = 0; corner < 3; ++corner) {
                values[corner] = mesh->colors[(size_t)corners[corner] * 4 + channel];
            }
            value = round_half_up(value * blend(values, by->corners), 255);
        }
        if (texture != NULL) {
            value = round_half_up(value * sampled(texture, uv, channel), 255);
        }
        one[channel] = value;
    }
}

static void add_color(const svo_mesh *mesh, uint32_t triangle, const uint32_t corners[3], const share *by,
                      int64_t color[4])
{
    int64_t one[4];
    color_of(mesh, triangle, corners, by, one);
    for (unsigned channel = 0; channel < 4; ++channel) {
        color[channel] += by->weight * one[channel] * (channel < 3 ? one[3] : 1);
    }
}

/* 32767 = 1; zero for a zero vector. */
static void fixed_unit(const double vector[3], int64_t out[3])
{
    const double length = sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
    for (unsigned axis = 0; axis < 3; ++axis) {
        out[axis] = isfinite(length) && length > 0.0 ? (int64_t)rint(vector[axis] / length * 32767.0) : 0;
    }
}

static void own_normal(const payload_pair *pair, int64_t out[3])
{
    double normal[3];
    normal_of(pair, normal);
    fixed_unit(normal, out);
}

static void add_normal(const svo_mesh *mesh, const payload_pair *pair, const share *by, int64_t normal[3])
{
    int64_t own[3];
    int64_t values[3][3]; /* axis, corner */
    own_normal(pair, own);
    for (unsigned corner = 0; corner < 3; ++corner) {
        int64_t unit[3] = {0, 0, 0};
        if (mesh->normals != NULL) {
            const float *n = mesh->normals + (size_t)pair->indices[corner] * 3;
            fixed_unit((const double[3]){(double)n[0], (double)n[1], (double)n[2]}, unit);
        }
        const int64_t *chosen = unit[0] == 0 && unit[1] == 0 && unit[2] == 0 ? own : unit;
        for (unsigned axis = 0; axis < 3; ++axis) {
            values[axis][corner] = chosen[axis];
        }
    }
    for (unsigned axis = 0; axis < 3; ++axis) {
        normal[axis] += by->weight * blend(values[axis], by->corners);
    }
}

/* by_material: sums of weights per material. */
static void add_pair(const surface *of, const oracle_pair *pair, sums *leaf, int64_t *by_material)
{
    payload_pair opened;
    share by;
    payload_pair_open(of->snapped, pair, &opened);
    share_of(of, &opened, &by);
    leaf->weight += by.weight;
    add_color(of->mesh, pair->triangle, opened.indices, &by, leaf->color);
    add_normal(of->mesh, &opened, &by, leaf->normal);
    const size_t material = of->mesh->triangle_materials != NULL ? of->mesh->triangle_materials[pair->triangle] : 0;
    by_material[material < of->material_count ? material : 0] += by.weight;
}

size_t payload_drop_pairs(const svo_mesh *mesh, svo_weights weights, double least, exact *expected)
{
    const surface of = {.mesh = mesh, .snapped = expected, .weights = weights, .weight_log2 = 16};
    oracle_pairs *pairs = &expected->pairs;
    const unsigned depth = expected->tree.depth;
    const size_t before = pairs->count;
    size_t kept = 0;
    for (size_t i = 0; i < before; ++i) {
        payload_pair opened;
        share by;
        int64_t color[4];
        payload_pair_open(expected, &pairs->pairs[i], &opened);
        share_of(&of, &opened, &by);
        color_of(mesh, pairs->pairs[i].triangle, opened.indices, &by, color);
        if ((double)color[3] >= least * 255.0) {
            pairs->pairs[kept++] = pairs->pairs[i];
        }
    }
    pairs->count = kept;
    oracle_tree_free(&expected->tree);
    assert_true(oracle_tree_make(pairs, depth, &expected->tree));
    return before - kept;
}

static void add_sums(sums *to, const sums *from)
{
    to->weight += from->weight;
    for (unsigned channel = 0; channel < 4; ++channel) {
        to->color[channel] += from->color[channel];
    }
    for (unsigned axis = 0; axis < 3; ++axis) {
        to->normal[axis] += from->normal[axis];
    }
}

/* Computes leaves from the pairs, then every inner node from its children, in descending order. */
static void sum_nodes(const surface *of, sums *nodes, int64_t *by_material)
{
    const oracle_tree *tree = &of->snapped->tree;
    const oracle_pairs *pairs = &of->snapped->pairs;
    size_t leaf = tree->inner_count;
    for (size_t i = 0; i < pairs->count; ++i) {
        leaf += i > 0 && pairs->pairs[i].code != pairs->pairs[i - 1].code ? 1 : 0;
        add_pair(of, &pairs->pairs[i], &nodes[leaf], by_material + leaf * of->material_count);
    }
    for (size_t node = tree->inner_count; node-- > 0;) {
        size_t child = tree->first_child[node];
        for (unsigned mask = tree->child_mask[node]; mask != 0; mask &= mask - 1) {
            add_sums(&nodes[node], &nodes[child]);
            for (size_t m = 0; m < of->material_count; ++m) {
                by_material[node * of->material_count + m] += by_material[child * of->material_count + m];
            }
            ++child;
        }
    }
}

static uint16_t heaviest(const int64_t *by_material, size_t material_count)
{
    size_t best = 0;
    for (size_t m = 1; m < material_count; ++m) {
        best = by_material[m] > by_material[best] ? m : best;
    }
    return (uint16_t)best;
}

/* Weight in 4096ths of the face of a node that is `levels` above the leaves. */
static uint16_t fill_of(int64_t weight, uint32_t weight_log2, uint32_t levels_above)
{
    const long double face = ldexpl(1.0L, (int)(weight_log2 + 2 * levels_above));
    const long double fill = floorl((long double)weight * 4096.0L / face + 0.5L);
    return fill > 65535.0L ? 65535 : (uint16_t)fill;
}

static void write_node(const surface *of, size_t node, uint32_t level, const sums *from, const int64_t *by_material,
                       payload_reference *out)
{
    const int64_t weight = from->weight > 0 ? from->weight : 1; /* an empty root: zeros */
    for (unsigned channel = 0; channel < 4; ++channel) {
        const int64_t by = channel < 3 && from->color[3] > 0 ? from->color[3] : weight;
        out->colors[node * 4 + channel] = (uint8_t)round_half_up(from->color[channel], by);
    }
    out->colors[node * 4 + 3] = payload_alpha(out->colors[node * 4 + 3], (uint64_t)from->color[3], (uint64_t)weight);
    for (unsigned axis = 0; axis < 3; ++axis) {
        out->normals[node * 3 + axis] = (int16_t)round_half_up(from->normal[axis], weight);
    }
    out->materials[node] = heaviest(by_material, of->material_count);
    out->fills[node] = fill_of(from->weight, of->weight_log2, of->snapped->tree.depth - level);
}

/* The part's area as rays along an axis see it, 2^32 = a face: n / n_t has 31 bits below 1, from the 32 leading ones of
   n_t. */
static uint64_t seen_along(int64_t doubled_area, int64_t n, int64_t n_t)
{
    int64_t part = llabs(n);
    int64_t whole = llabs(n_t);
    for (; whole > UINT32_MAX; whole /= 2) {
        part /= 2;
    }
    const int64_t ratio = (int64_t)(((__int128)part << 31) / whole);
    return (uint64_t)round_half_up((int64_t)(((__int128)doubled_area * ratio) >> 25), 1 << 23);
}

static void add_areas(const payload_pair *pair, bool both_sides, uint64_t areas[6])
{
    int64_t normal[3];
    payload_pair_normal(pair->corners, normal);
    const int64_t largest = normal[payload_pair_axis(pair->corners)];
    const int64_t doubled_area = part_of(pair).doubled_area;
    for (unsigned i = 0; i < 6 && largest != 0; ++i) {
        const int64_t n = normal[i / 2];
        if (both_sides || (i % 2 == 0 ? n < 0 : n > 0)) {
            areas[i] += seen_along(doubled_area, n, largest);
        }
    }
}

static void reference_areas(const exact *expected, uint16_t *out)
{
    const oracle_pairs *pairs = &expected->pairs;
    const bool both_sides = payload_mesh_is_open(expected);
    for (size_t begin = 0, end = 0; begin < pairs->count; begin = end, out += 6) {
        uint64_t areas[6] = {0};
        for (end = begin; end < pairs->count && pairs->pairs[end].code == pairs->pairs[begin].code; ++end) {
            payload_pair opened;
            payload_pair_open(expected, &pairs->pairs[end], &opened);
            add_areas(&opened, both_sides, areas);
        }
        for (unsigned i = 0; i < 6; ++i) {
            const uint64_t rounded = areas[i] / (1 << 20) + areas[i] / (1 << 19) % 2;
            out[i] = rounded > 65535 ? 65535 : (uint16_t)rounded;
        }
    }
}

static void reference_create(const svo_mesh *mesh, const exact *expected, const built *as, payload_reference *out)
{
    const oracle_tree *tree = &expected->tree;
    const surface of = {mesh, expected, (svo_weights)as->info.weights, as->weight_log2,
                        mesh->material_count > 0 ? mesh->material_count : 1};
    sums *nodes = calloc(tree->node_count, sizeof *nodes);
    int64_t *by_material = calloc(tree->node_count * of.material_count, sizeof *by_material);
    out->colors = calloc(tree->node_count, 4);
    out->normals = calloc(tree->node_count * 3, sizeof(int16_t));
    out->materials = calloc(tree->node_count, sizeof(uint16_t));
    out->fills = calloc(tree->node_count, sizeof(uint16_t));
    out->areas = calloc((tree->node_count - tree->inner_count) * 6 + 1, sizeof(uint16_t));
    assert_non_null(nodes);
    assert_non_null(by_material);
    assert_non_null(out->colors);
    assert_non_null(out->normals);
    assert_non_null(out->materials);
    assert_non_null(out->fills);
    assert_non_null(out->areas);
    if (as->arrays.areas != NULL) {
        reference_areas(expected, out->areas);
    }
    sum_nodes(&of, nodes, by_material);
    uint32_t level = 0;
    for (size_t node = 0; node < tree->node_count; ++node) {
        while (node >= tree->level_begin[level + 1]) {
            ++level;
        }
        write_node(&of, node, level, &nodes[node], by_material + node * of.material_count, out);
    }
    free(by_material);
    free(nodes);
}

static void reference_destroy(payload_reference *made)
{
    free(made->colors);
    free(made->normals);
    free(made->materials);
    free(made->fills);
    free(made->areas);
    *made = (payload_reference){0};
}

void assert_payload_is_exact(const svo_mesh *mesh, const exact *expected, const built *actual)
{
    payload_reference payload;
    reference_create(mesh, expected, actual, &payload);
    const struct {
        const char *name;
        const void *actual, *expected;
        size_t node_bytes;
        uint64_t count;
    } arrays[] = {{"color", actual->arrays.colors, payload.colors, 4, actual->info.node_count},
                  {"normal", actual->arrays.normals, payload.normals, 6, actual->info.node_count},
                  {"material", actual->arrays.materials, payload.materials, 2, actual->info.node_count},
                  {"fill", actual->arrays.fills, payload.fills, 2, actual->info.node_count},
                  {"areas by leaf", actual->arrays.areas, payload.areas, 12, actual->info.leaf_count}};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; ++i) {
        const size_t bytes = arrays[i].node_bytes;
        for (size_t node = 0; arrays[i].actual != NULL && node < arrays[i].count; ++node) {
            const uint8_t *a = (const uint8_t *)arrays[i].actual + node * bytes;
            const uint8_t *e = (const uint8_t *)arrays[i].expected + node * bytes;
            if (memcmp(a, e, bytes) != 0) {
                fail_msg("%s of node %zu of %llu (%llu inner): bytes %02x %02x .., not %02x %02x ..", arrays[i].name,
                         node, (unsigned long long)actual->info.node_count,
                         (unsigned long long)actual->info.inner_count, a[0], a[1], e[0], e[1]);
            }
        }
    }
    reference_destroy(&payload);
}
