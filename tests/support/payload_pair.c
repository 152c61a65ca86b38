/* SPDX-License-Identifier: MIT */
/* Lookups that both payload references use: a pair's triangle and voxel, a triangle's material and texels. */
#include "payload_pair.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

int64_t payload_remainder(int64_t value, int64_t period)
{
    return (value % period + period) % period;
}

unsigned payload_halve(int64_t *numbers, unsigned count, unsigned bits)
{
    int64_t largest = 0;
    unsigned halvings = 0;
    for (unsigned i = 0; i < count; ++i) {
        largest = llabs(numbers[i]) > largest ? llabs(numbers[i]) : largest;
    }
    for (; largest >= INT64_C(1) << bits; largest /= 2) {
        ++halvings;
        for (unsigned i = 0; i < count; ++i) {
            numbers[i] = (numbers[i] - payload_remainder(numbers[i], 2)) / 2;
        }
    }
    return halvings;
}

void payload_pair_normal(const int64_t corners[3][3], int64_t normal[3])
{
    int64_t edges[6];
    for (unsigned i = 0; i < 6; ++i) {
        edges[i] = corners[1 + i / 3][i % 3] - corners[0][i % 3];
    }
    (void)payload_halve(edges, 6, 30);
    for (unsigned axis = 0; axis < 3; ++axis) {
        const unsigned u = (axis + 1) % 3;
        const unsigned v = (axis + 2) % 3;
        normal[axis] = edges[u] * edges[3 + v] - edges[v] * edges[3 + u];
    }
}

/* The axis along which the triangle's projection is largest; the first of equal ones. */
unsigned payload_pair_axis(const int64_t corners[3][3])
{
    int64_t normal[3];
    payload_pair_normal(corners, normal);
    unsigned best = 0;
    best = llabs(normal[1]) > llabs(normal[best]) ? 1 : best;
    return llabs(normal[2]) > llabs(normal[best]) ? 2 : best;
}

/* An edge between two positions, the lesser first; sign: 1 for this direction, -1 for the other. */
typedef struct edge {
    double ends[2][3];
    int sign;
} edge;

static int compare_positions(const double a[3], const double b[3])
{
    int order = 0;
    for (unsigned axis = 0; axis < 3 && order == 0; ++axis) {
        order = (a[axis] > b[axis]) - (a[axis] < b[axis]); /* -0 equals 0 */
    }
    return order;
}

static int compare_edges(const void *a, const void *b)
{
    const edge *p = a;
    const edge *q = b;
    const int first = compare_positions(p->ends[0], q->ends[0]);
    return first != 0 ? first : compare_positions(p->ends[1], q->ends[1]);
}

static edge edge_between(const exact *expected, uint32_t from, uint32_t to)
{
    edge made;
    const double *begin = expected->positions + (size_t)from * 3;
    const double *end = expected->positions + (size_t)to * 3;
    made.sign = compare_positions(begin, end) > 0 ? -1 : 1;
    memcpy(made.ends[0], made.sign > 0 ? begin : end, sizeof made.ends[0]);
    memcpy(made.ends[1], made.sign > 0 ? end : begin, sizeof made.ends[1]);
    return made;
}

bool payload_mesh_is_open(const exact *expected)
{
    const size_t count = expected->triangle_count * 3;
    edge *edges = malloc((count + 1) * sizeof *edges);
    bool is_open = false;
    assert_non_null(edges);
    for (size_t i = 0; i < count; ++i) {
        edges[i] = edge_between(expected, expected->indices[i], expected->indices[i % 3 < 2 ? i + 1 : i - 2]);
    }
    qsort(edges, count, sizeof *edges, compare_edges);
    for (size_t begin = 0, end = 0; begin < count; begin = end) {
        long balance = 0;
        const bool is_point = compare_positions(edges[begin].ends[0], edges[begin].ends[1]) == 0;
        for (end = begin; end < count && compare_edges(&edges[begin], &edges[end]) == 0; ++end) {
            balance += edges[end].sign;
        }
        is_open = is_open || (balance != 0 && !is_point);
    }
    free(edges);
    return is_open;
}

/* The triangle's material, or NULL for white. */
const svo_material *payload_material(const svo_mesh *mesh, uint32_t triangle)
{
    const uint32_t given = mesh->triangle_materials != NULL ? mesh->triangle_materials[triangle] : 0;
    return mesh->material_count > 0 ? &mesh->materials[given < mesh->material_count ? given : 0] : NULL;
}

const svo_texture *payload_texture(const svo_mesh *mesh, uint32_t triangle)
{
    const svo_material *material = payload_material(mesh, triangle);
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
        return payload_remainder(texel, texel_count);
    }
    const int64_t inside = payload_remainder(texel, 2 * texel_count);
    return inside < texel_count ? inside : 2 * texel_count - 1 - inside;
}

int64_t payload_texel(const svo_texture *texture, int64_t x, int64_t y, unsigned channel)
{
    const int64_t column = wrapped_texel(x, texture->width, texture->wrap_u);
    const int64_t row = wrapped_texel(y, texture->height, texture->wrap_v);
    return texture->rgba[(row * texture->width + column) * 4 + channel];
}

/* A pair names its triangle by id. */
void payload_pair_open(const exact *expected, const oracle_pair *pair, payload_pair *out)
{
    size_t low = 0;
    size_t high = expected->triangle_count;
    while (high - low > 1) {
        const size_t half = (low + high) / 2;
        *(expected->triangle_ids[half] <= pair->triangle ? &low : &high) = half;
    }
    oracle_voxel_box(pair->code, expected->tree.depth, expected->grid.snap_bits, &out->box);
    for (unsigned corner = 0; corner < 3; ++corner) {
        out->indices[corner] = expected->indices[low * 3 + corner];
        for (unsigned axis = 0; axis < 3; ++axis) {
            out->corners[corner][axis] = expected->fine[(size_t)out->indices[corner] * 3 + axis] -
                                         out->box.corner[axis] / out->box.width * PAYLOAD_WIDTH;
        }
    }
}
