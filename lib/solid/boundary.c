/* SPDX-License-Identifier: MIT */
/*
 * svo_i_boundary_find. Vertices at one place are one. Each side of a triangle counts 1 in its direction and -1 in the
 * other; what does not cancel is the boundary, into which and out of every vertex the same number of edges lead. So
 * walks along edges that are not used yet come back to where they were, and close loop after loop (Hierholzer).
 */
#include "solid/boundary.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#define NONE UINT32_MAX

/* What is held while the boundary is found. All owned. */
typedef struct finder {
    const svo_i_memory *memory;
    const svo_i_solid_mesh *mesh;
    uint32_t *place_of; /* by vertex: the first vertex at its place */
    uint64_t *begin; /* by vertex: its first side; vertex_count + 1 */
    uint64_t *sides; /* by their lower vertex: twice the other one, plus 1 if the side comes from there */
    svo_i_boundary_edge *found; /* edges of the boundary, by vertices */
    size_t found_count, found_capacity;
} finder;

/* ---- vertices ---- */

/* The bits of a vertex, those of -0 as those of 0. */
static void read_place(const svo_i_solid_mesh *mesh, uint32_t vertex, uint64_t out[3])
{
    for (size_t k = 0; k < 3; ++k) {
        const size_t i = 3 * (size_t)vertex + k;
        if (mesh->kind == SVO_SOLID_DOUBLES) {
            memcpy(&out[k], (const char *)mesh->positions + i * sizeof out[k], sizeof out[k]);
            out[k] = out[k] << 1 == 0 ? 0 : out[k];
        } else {
            const uint32_t word = svo_word_at(mesh->positions, i);
            out[k] = mesh->kind == SVO_SOLID_FLOATS && (uint32_t)(word << 1) == 0 ? 0 : word;
        }
    }
}

/* Sets place_of. Returns false when out of memory. */
static bool find_places(finder *f)
{
    const uint32_t count = f->mesh->vertex_count;
    size_t slots = 16;
    while (slots < 2 * (size_t)count) {
        slots *= 2;
    }
    uint32_t *table = svo_i_alloc(f->memory, slots * sizeof *table);
    f->place_of = svo_i_alloc_zeroed(f->memory, count, sizeof *f->place_of);
    const bool good = table != NULL && f->place_of != NULL;
    if (good) {
        memset(table, 0xff, slots * sizeof *table);
    }
    for (uint32_t vertex = 0; good && vertex < count; ++vertex) {
        uint64_t place[3];
        uint64_t other[3] = {0, 0, 0};
        read_place(f->mesh, vertex, place);
        size_t slot = (size_t)XXH3_64bits(place, sizeof place) & (slots - 1);
        for (; table[slot] != NONE; slot = (slot + 1) & (slots - 1)) {
            read_place(f->mesh, table[slot], other);
            if (memcmp(place, other, sizeof place) == 0) {
                break;
            }
        }
        table[slot] = table[slot] != NONE ? table[slot] : vertex;
        f->place_of[vertex] = table[slot];
    }
    svo_i_free(table);
    return good;
}

/* ---- edges that do not cancel ---- */

/* The ends of a triangle's side, by their places. Returns false if it has no length. */
static bool get_side(const finder *f, size_t side, uint32_t *lower, uint64_t *key)
{
    const size_t next = side % 3 == 2 ? side - 2 : side + 1;
    const uint32_t from = f->place_of[f->mesh->indices[side]];
    const uint32_t to = f->place_of[f->mesh->indices[next]];
    *lower = from < to ? from : to;
    *key = from < to ? (uint64_t)to * 2 : (uint64_t)from * 2 + 1;
    return from != to;
}

/* Lists the sides by their lower vertex. Returns false when out of memory. */
static bool list_sides(finder *f)
{
    const size_t count = 3 * (size_t)f->mesh->triangle_count;
    uint32_t lower;
    uint64_t key;
    f->begin = svo_i_alloc_zeroed(f->memory, (size_t)f->mesh->vertex_count + 2, sizeof *f->begin);
    f->sides = svo_i_alloc_zeroed(f->memory, count + 1, sizeof *f->sides);
    if (f->begin == NULL || f->sides == NULL) {
        return false;
    }
    /* Two places up at first, so that filling moves them to where they belong. */
    for (size_t i = 0; i < count; ++i) {
        if (get_side(f, i, &lower, &key) && lower + 2 <= f->mesh->vertex_count) {
            ++f->begin[lower + 2];
        }
    }
    for (size_t i = 2; i <= f->mesh->vertex_count; ++i) {
        f->begin[i] += f->begin[i - 1];
    }
    for (size_t i = 0; i < count; ++i) {
        if (get_side(f, i, &lower, &key)) {
            f->sides[f->begin[lower + 1]++] = key;
        }
    }
    return true;
}

static int compare_keys(const void *a, const void *b)
{
    const uint64_t left = *(const uint64_t *)a;
    const uint64_t right = *(const uint64_t *)b;
    return (left > right) - (left < right);
}

/* Adds an edge, so many times. Returns false when out of memory. */
static bool add_found(finder *f, svo_i_boundary_edge edge, uint64_t times)
{
    if (f->found_count + times > f->found_capacity) {
        const size_t capacity = 2 * f->found_capacity + (size_t)times + 64;
        svo_i_boundary_edge *grown = svo_i_grow(f->memory, f->found, capacity * sizeof *grown);
        if (grown == NULL) {
            return false;
        }
        f->found = grown;
        f->found_capacity = capacity;
    }
    for (uint64_t i = 0; i < times; ++i) {
        f->found[f->found_count++] = edge;
    }
    return true;
}

/* Adds what is left of the sides of a lower vertex. Returns false when out of memory. */
static bool cancel_sides(finder *f, uint32_t lower)
{
    uint64_t *sides = f->sides + f->begin[lower];
    const size_t count = (size_t)(f->begin[lower + 1] - f->begin[lower]);
    qsort(sides, count, sizeof *sides, compare_keys);
    for (size_t i = 0, end = 0; i < count; i = end) {
        const uint32_t upper = (uint32_t)(sides[i] >> 1);
        int64_t sum = 0;
        for (end = i; end < count && sides[end] >> 1 == upper; ++end) {
            sum += (sides[end] & 1) == 0 ? 1 : -1;
        }
        const svo_i_boundary_edge edge = {sum > 0 ? lower : upper, sum > 0 ? upper : lower};
        if (!add_found(f, edge, (uint64_t)(sum < 0 ? -sum : sum))) {
            return false;
        }
    }
    return true;
}

static bool find_edges(finder *f)
{
    bool good = list_sides(f);
    for (uint32_t vertex = 0; good && vertex < f->mesh->vertex_count; ++vertex) {
        good = f->begin[vertex + 1] - f->begin[vertex] == 0 || cancel_sides(f, vertex);
    }
    return good;
}

/* ---- points ---- */

static svo_number number_at(const svo_i_solid_mesh *mesh, uint32_t vertex, size_t axis)
{
    const size_t i = 3 * (size_t)vertex + axis;
    if (mesh->kind == SVO_SOLID_DOUBLES) {
        return svo_number_of_double(svo_word_at(mesh->positions, 2 * i), svo_word_at(mesh->positions, 2 * i + 1));
    }
    if (mesh->kind == SVO_SOLID_FLOATS) {
        return svo_number_of_float(svo_word_at(mesh->positions, i));
    }
    return (svo_number){.low = svo_word_at(mesh->positions, i), .high = 0, .exponent = 0, .is_negative = false};
}

/* The number as a double, off by less than 2^-51 of itself. */
static double double_of(svo_short a)
{
    const bool is_negative = a.words[SVO_SHORT_WORDS - 1] >> 31 != 0;
    if (is_negative) {
        a = svo_short_subtract(svo_short_of(0), a);
    }
    const double size = (double)a.words[2] * 0x1p64 + (double)((uint64_t)a.words[1] << 32 | a.words[0]);
    return is_negative ? -size : size;
}

static void place_point(const svo_i_solid_mesh *mesh, uint32_t vertex, svo_i_boundary_point *out)
{
    const svo_decide_params *grid = &mesh->grid;
    const svo_short width = svo_decided_width(grid);
    const svo_short half = svo_short_half(width);
    const SVO_I32 unit = svo_exact_unit(svo_number_of_double(grid->edge[0], grid->edge[1]));
    for (size_t k = 0; k < 3; ++k) {
        const svo_number origin = svo_number_of_double(grid->origin[2 * k], grid->origin[2 * k + 1]);
        const svo_short offset = svo_exact_offset(number_at(mesh, vertex, k), origin, unit);
        const double near = rint(double_of(offset) / double_of(half));
        const svo_short rest = svo_exact_place(offset, (SVO_U32)(near > 0.0 ? near : 0.0), half);
        out->half[k] = (int32_t)(near > 0.0 ? near : 0.0);
        out->rest[k] = double_of(rest) / double_of(width);
        if (k < 2) {
            out->offset[k] = offset;
        }
    }
}

/* Makes points of the vertices of edges, and gives the edges their numbers. Returns false when out of memory. */
static bool make_points(finder *f, svo_i_boundary *out)
{
    size_t count = 0;
    uint32_t *number = f->place_of; /* not needed any more */
    memset(number, 0xff, f->mesh->vertex_count * sizeof *number);
    for (size_t i = 0; i < 2 * f->found_count; ++i) {
        const uint32_t vertex = i % 2 == 0 ? f->found[i / 2].from : f->found[i / 2].to;
        number[vertex] = number[vertex] == NONE ? (uint32_t)count++ : number[vertex];
    }
    out->points = svo_i_alloc_zeroed(f->memory, count + 1, sizeof *out->points);
    if (out->points == NULL) {
        return false;
    }
    out->point_count = count;
    for (uint32_t vertex = 0; vertex < f->mesh->vertex_count; ++vertex) {
        if (number[vertex] != NONE) {
            place_point(f->mesh, vertex, &out->points[number[vertex]]);
        }
    }
    for (size_t i = 0; i < f->found_count; ++i) {
        f->found[i] = (svo_i_boundary_edge){number[f->found[i].from], number[f->found[i].to]};
    }
    return true;
}

/* ---- loops ---- */

/* Walks along edges. */
typedef struct walker {
    uint32_t *ends; /* of edges, by the point that they begin at */
    size_t *next; /* by point: its first end that is not used yet; point_count + 2 */
    size_t *limit; /* by point: the end of its ends */
    uint32_t *path; /* points */
    size_t *place; /* by point: 1 + its place on the path; 0: it is not there */
} walker;

/* Closes a loop of the last edges of the path, from a place on. */
static void close_loop(walker *w, size_t place, size_t length, svo_i_boundary *out)
{
    const size_t first = out->edge_count;
    for (size_t i = place; i < length; ++i) {
        const uint32_t to = w->path[i + 1 < length ? i + 1 : place];
        out->edges[out->edge_count++] = (svo_i_boundary_edge){w->path[i], to};
        w->place[w->path[i]] = 0;
    }
    const bool is_long = out->edge_count - first > SVO_I_LOOP_EDGES;
    out->long_count += is_long ? 1 : 0;
    for (size_t at = first; at < out->edge_count; at += SVO_I_PIECE_EDGES) {
        const size_t left = out->edge_count - at;
        out->pieces[out->piece_count++] =
            (svo_i_boundary_piece){.first = at,
                                   .count = (uint32_t)(left < SVO_I_PIECE_EDGES ? left : SVO_I_PIECE_EDGES),
                                   .of_long = is_long ? (uint32_t)out->long_count : 0,
                                   .loop_first = first,
                                   .loop_end = out->edge_count};
    }
}

static void walk_from(walker *w, uint32_t start, svo_i_boundary *out)
{
    size_t length = 0;
    uint32_t at = start;
    for (;;) {
        if (w->place[at] != 0) {
            const size_t place = w->place[at] - 1;
            close_loop(w, place, length, out);
            length = place;
        }
        if (w->next[at] == w->limit[at]) {
            return; /* as many edges lead here as away, so this is the start, and the path is empty */
        }
        w->path[length++] = at;
        w->place[at] = length;
        at = w->ends[w->next[at]++];
    }
}

/* Lists the ends of edges by their begin. */
static void list_ends(const finder *f, walker *w, size_t point_count)
{
    for (size_t i = 0; i < f->found_count; ++i) {
        ++w->limit[f->found[i].from];
    }
    for (size_t i = 0, sum = 0; i < point_count; ++i) {
        w->next[i] = sum;
        sum += w->limit[i];
        w->limit[i] = w->next[i];
    }
    for (size_t i = 0; i < f->found_count; ++i) {
        w->ends[w->limit[f->found[i].from]++] = f->found[i].to;
    }
}

/* Returns false when out of memory. */
static bool make_loops(const finder *f, svo_i_boundary *out)
{
    const size_t points = out->point_count + 1;
    const size_t edges = f->found_count + 1;
    walker w = {.ends = svo_i_alloc_zeroed(f->memory, edges, sizeof *w.ends),
                .next = svo_i_alloc_zeroed(f->memory, points, sizeof *w.next),
                .limit = svo_i_alloc_zeroed(f->memory, points, sizeof *w.limit),
                .path = svo_i_alloc_zeroed(f->memory, points, sizeof *w.path),
                .place = svo_i_alloc_zeroed(f->memory, points, sizeof *w.place)};
    out->edges = svo_i_alloc_zeroed(f->memory, edges, sizeof *out->edges);
    out->pieces = svo_i_alloc_zeroed(f->memory, edges, sizeof *out->pieces);
    const bool good = w.ends != NULL && w.next != NULL && w.limit != NULL && w.path != NULL && w.place != NULL &&
                      out->edges != NULL && out->pieces != NULL;
    if (good) {
        list_ends(f, &w, out->point_count);
        for (size_t i = 0; i < out->point_count; ++i) {
            walk_from(&w, (uint32_t)i, out);
        }
    }
    svo_i_free(w.ends);
    svo_i_free(w.next);
    svo_i_free(w.limit);
    svo_i_free(w.path);
    svo_i_free(w.place);
    return good;
}

/* ---- the entrance ---- */

svo_status svo_i_boundary_find(const svo_i_memory *memory, const svo_i_solid_mesh *mesh, svo_i_boundary *out)
{
    finder f = {.memory = memory, .mesh = mesh};
    *out = (svo_i_boundary){.points = NULL};
    const bool good = find_places(&f) && find_edges(&f) && make_points(&f, out) && make_loops(&f, out);
    svo_i_free(f.place_of);
    svo_i_free(f.begin);
    svo_i_free(f.sides);
    svo_i_free(f.found);
    if (!good) {
        svo_i_boundary_release(out);
    }
    return good ? SVO_OK : SVO_OUT_OF_HOST_MEMORY;
}

void svo_i_boundary_release(svo_i_boundary *boundary)
{
    svo_i_free(boundary->points);
    svo_i_free(boundary->edges);
    svo_i_free(boundary->pieces);
    *boundary = (svo_i_boundary){.points = NULL};
}
