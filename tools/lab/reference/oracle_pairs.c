/* SPDX-License-Identifier: MIT */
/*
 * From one pair to all pairs: the traversal that finds every voxel of every triangle with one of the two predicates,
 * the sort, and the comparison of two lists.
 */
#include "predicate.h"

#include <stdlib.h>
#include <string.h>

/* One traversal: the predicate with the current triangle, and the growing list. */
typedef struct walker {
    oracle_request request;
    union {
        oracle_sat_triangle sat;
        oracle_clip_triangle clip;
    } prepared;
    oracle_triangle triangle;
    int64_t low[3], high[3]; /* the triangle's bounds */
    uint32_t triangle_id;
    oracle_pair *pairs;
    size_t count, capacity;
} walker;

void oracle_voxel_box(uint64_t code, unsigned depth, unsigned snap_bits, oracle_box *box)
{
    box->width = (int64_t)1 << (snap_bits - depth);
    for (unsigned k = 0; k < 3; k++) {
        int64_t cell = 0;

        for (unsigned bit = 0; bit < depth; bit++)
            cell |= (int64_t)(code >> (3 * bit + k) & 1) << bit;
        box->corner[k] = cell * box->width;
    }
}

uint64_t oracle_voxel_code(uint32_t x, uint32_t y, uint32_t z, unsigned depth)
{
    const uint32_t cell[3] = {x, y, z};
    uint64_t code = 0;

    for (unsigned k = 0; k < 3; k++)
        for (unsigned bit = 0; bit < depth; bit++)
            code |= (uint64_t)(cell[k] >> bit & 1) << (3 * bit + k);
    return code;
}

static bool walker_touches(const walker *walk, const oracle_box *box)
{
    /* Saves time: most boxes that are missed are outside the bounds of the triangle. */
    for (int k = 0; k < 3; k++)
        if (walk->high[k] < box->corner[k] || walk->low[k] > box->corner[k] + box->width)
            return false;
    if (walk->request.method == ORACLE_SAT)
        return oracle_sat_test(&walk->prepared.sat, box, walk->request.coverage);
    return oracle_clip_test(&walk->prepared.clip, box, walk->request.coverage);
}

/* Thin coverage does not nest. Inner boxes are traversed as half-open, a superset of it, and voxels are tested
   again. */
static bool walker_keeps(const walker *walk, const oracle_box *box)
{
    if (walk->request.coverage != ORACLE_THIN)
        return true;
    if (walk->request.method == ORACLE_SAT)
        return oracle_thin_by_extents(&walk->triangle, box);
    return oracle_thin_by_vertices(&walk->triangle, box);
}

static bool walker_add(walker *walk, uint64_t code)
{
    if (walk->count == walk->capacity) {
        size_t capacity = walk->capacity ? 2 * walk->capacity : 4096;
        oracle_pair *pairs = NULL;

        if (capacity <= SIZE_MAX / sizeof(*pairs))
            pairs = realloc(walk->pairs, capacity * sizeof(*pairs));
        if (!pairs)
            return false;
        walk->pairs = pairs;
        walk->capacity = capacity;
    }
    walk->pairs[walk->count++] = (oracle_pair){code, walk->triangle_id};
    return true;
}

/* Adds the voxels below the node `code` of `level`, whose box is given, in Morton order. False: out of memory. */
static bool walker_descend(walker *walk, uint64_t code, unsigned level, const oracle_box *box)
{
    if (!walker_touches(walk, box))
        return true;
    if (level == walk->request.depth)
        return !walker_keeps(walk, box) || walker_add(walk, code);
    for (unsigned octant = 0; octant < 8; octant++) {
        oracle_box child = {{0, 0, 0}, box->width / 2};

        for (unsigned k = 0; k < 3; k++)
            child.corner[k] = box->corner[k] + (int64_t)(octant >> k & 1) * child.width;
        if (!walker_descend(walk, code << 3 | octant, level + 1, &child))
            return false;
    }
    return true;
}

/* Triangle t of the mesh; false if it is refused for being too far away. */
static bool fetch_triangle(const oracle_mesh *mesh, size_t t, oracle_triangle *triangle)
{
    for (size_t i = 0; i < 3; i++) {
        size_t vertex_index = mesh->indices ? mesh->indices[3 * t + i] : 3 * t + i;

        for (size_t k = 0; k < 3; k++) {
            int32_t coordinate = mesh->vertices[3 * vertex_index + k];

            if (coordinate <= -(1 << 29) || coordinate >= 1 << 29)
                return false;
            triangle->vertex[i][k] = coordinate;
        }
    }
    return true;
}

static bool walker_add_triangle(walker *walk, const oracle_triangle *triangle)
{
    oracle_box root = {{0, 0, 0}, (int64_t)1 << walk->request.snap_bits};

    walk->triangle = *triangle;
    for (int k = 0; k < 3; k++) {
        walk->low[k] = walk->high[k] = triangle->vertex[0][k];
        for (int i = 1; i < 3; i++) {
            walk->low[k] = triangle->vertex[i][k] < walk->low[k] ? triangle->vertex[i][k] : walk->low[k];
            walk->high[k] = triangle->vertex[i][k] > walk->high[k] ? triangle->vertex[i][k] : walk->high[k];
        }
    }
    if (walk->request.method == ORACLE_SAT)
        oracle_sat_prepare(triangle, &walk->prepared.sat);
    else
        oracle_clip_prepare(triangle, &walk->prepared.clip);
    return walker_descend(walk, 0, 0, &root);
}

bool oracle_enumerate(const oracle_mesh *mesh, const oracle_request *request, oracle_pairs *out)
{
    walker walk = {.request = *request};

    *out = (oracle_pairs){NULL, 0};
    if (request->depth > ORACLE_DEPTH_MAX || request->snap_bits < request->depth || request->snap_bits > 24)
        return false;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        oracle_triangle triangle;

        walk.triangle_id = mesh->triangle_ids ? mesh->triangle_ids[t] : (uint32_t)t;
        if (fetch_triangle(mesh, t, &triangle) && !walker_add_triangle(&walk, &triangle))
            goto fail;
    }
    if (!oracle_pairs_sort(walk.pairs, walk.count))
        goto fail;
    *out = (oracle_pairs){walk.pairs, walk.count};
    return true;

fail:
    free(walk.pairs);
    return false;
}

void oracle_pairs_free(oracle_pairs *pairs)
{
    free(pairs->pairs);
    *pairs = (oracle_pairs){NULL, 0};
}

static int pair_order(const oracle_pair *a, const oracle_pair *b)
{
    if (a->code != b->code)
        return a->code < b->code ? -1 : 1;
    return (a->triangle > b->triangle) - (a->triangle < b->triangle);
}

static bool is_sorted(const oracle_pair *pairs, size_t count)
{
    for (size_t i = 1; i < count; i++)
        if (pair_order(&pairs[i - 1], &pairs[i]) > 0)
            return false;
    return true;
}

#define SORT_DIGITS 12 /* bytes of the key: 4 of the triangle, then 8 of the code */

static unsigned sort_digit(const oracle_pair *pair, unsigned digit)
{
    return digit < 4 ? pair->triangle >> 8 * digit & 255 : (unsigned)(pair->code >> 8 * (digit - 4) & 255);
}

/* Radix sort, least significant byte first. Bytes that are equal in all keys cost one counting pass. */
bool oracle_pairs_sort(oracle_pair *pairs, size_t count)
{
    oracle_pair *from = pairs, *to;

    if (is_sorted(pairs, count))
        return true;
    to = malloc(count * sizeof(*to));
    if (!to)
        return false;
    for (unsigned digit = 0; digit < SORT_DIGITS; digit++) {
        size_t begin[257] = {0};
        oracle_pair *swap = from;

        for (size_t i = 0; i < count; i++)
            begin[sort_digit(&from[i], digit) + 1]++;
        if (begin[sort_digit(&from[0], digit) + 1] == count)
            continue;
        for (unsigned value = 0; value < 256; value++)
            begin[value + 1] += begin[value];
        for (size_t i = 0; i < count; i++)
            to[begin[sort_digit(&from[i], digit)]++] = from[i];
        from = to;
        to = swap;
    }
    if (from != pairs)
        memcpy(pairs, from, count * sizeof(*pairs));
    free(from == pairs ? to : from);
    return true;
}

uint64_t oracle_pairs_voxel_count(const oracle_pairs *pairs)
{
    uint64_t count = 0;

    for (size_t i = 0; i < pairs->count; i++)
        count += i == 0 || pairs->pairs[i].code != pairs->pairs[i - 1].code;
    return count;
}

/* The first position after i where another voxel begins. */
static size_t next_voxel(const oracle_pairs *list, size_t i)
{
    uint64_t code = list->pairs[i].code;

    while (i < list->count && list->pairs[i].code == code)
        i++;
    return i;
}

static void compare_pairs(const oracle_pairs *expected, const oracle_pairs *actual, oracle_difference *difference)
{
    size_t e = 0, a = 0;

    while (e < expected->count && a < actual->count) {
        int order = pair_order(&expected->pairs[e], &actual->pairs[a]);

        difference->missed_pairs += order < 0;
        difference->surplus_pairs += order > 0;
        e += order <= 0;
        a += order >= 0;
    }
    difference->missed_pairs += expected->count - e;
    difference->surplus_pairs += actual->count - a;
}

static void compare_voxels(const oracle_pairs *expected, const oracle_pairs *actual, oracle_difference *difference)
{
    size_t e = 0, a = 0;

    while (e < expected->count || a < actual->count) {
        bool is_missed = a == actual->count || (e < expected->count && expected->pairs[e].code < actual->pairs[a].code);
        bool is_surplus =
            e == expected->count || (a < actual->count && actual->pairs[a].code < expected->pairs[e].code);

        difference->missed_voxels += is_missed;
        difference->surplus_voxels += is_surplus;
        if (!is_surplus)
            e = next_voxel(expected, e);
        if (!is_missed)
            a = next_voxel(actual, a);
    }
}

void oracle_compare(const oracle_pairs *expected, const oracle_pairs *actual, oracle_difference *difference)
{
    *difference = (oracle_difference){0, 0, 0, 0};
    compare_pairs(expected, actual, difference);
    compare_voxels(expected, actual, difference);
}
