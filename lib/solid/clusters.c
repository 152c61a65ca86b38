/* SPDX-License-Identifier: MIT */
/*
 * Clusters of the boundary of a mesh for generalized winding numbers: pieces of short loops by their place, and those
 * of each long loop along it, halved until few edges are left. Each has a ball, the dipole of its cone, and the ends
 * that do not cancel in it (winding.c says what they are for).
 */
#include "solid/clusters.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "svocl/nodes.h"

/* Edges of a cluster without children, unless one piece has more. */
#define LEAF_EDGES SVO_I_PIECE_EDGES

static void point_at(const svo_i_boundary_point *point, double out[3])
{
    for (size_t k = 0; k < 3; ++k) {
        out[k] = 0.5 * point->half[k] + point->rest[k];
    }
}

typedef struct maker {
    svo_i_clusters *made;
    const svo_i_memory *memory;
    int32_t *ends; /* by point: how often edges of a cluster end there, less how often they begin there */
    uint32_t *touched; /* points of the cluster */
    size_t touched_count, star_capacity;
} maker;

static void point_from(const svo_i_clusters *w, uint32_t point, const double center[3], double out[3])
{
    point_at(&w->boundary.points[point], out);
    for (size_t k = 0; k < 3; ++k) {
        out[k] -= center[k];
    }
}

/* Adds the triangle of the center and an edge to the cone of a cluster. */
static void add_triangle(const svo_i_clusters *w, uint32_t from, uint32_t to, svo_i_cluster *node)
{
    double a[3];
    double b[3];
    double side[3];
    point_from(w, from, node->center, a);
    point_from(w, to, node->center, b);
    for (size_t k = 0; k < 3; ++k) {
        side[k] = 0.5 * (a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3]);
        node->dipole[k] += side[k];
    }
    node->area += sqrt(svo_i_cluster_dot(side, side));
    node->radius = fmax(node->radius, sqrt(fmax(svo_i_cluster_dot(a, a), svo_i_cluster_dot(b, b))));
}

/* The ball and the cone of a cluster. */
static void measure(const svo_i_clusters *w, svo_i_cluster *node)
{
    const size_t first = svo_i_cluster_first_edge(w, node);
    const size_t end = svo_i_cluster_edges_end(w, node);
    double a[3];
    double b[3];
    for (size_t i = first; i < end; ++i) {
        point_at(&w->boundary.points[w->boundary.edges[i].from], a);
        point_at(&w->boundary.points[w->boundary.edges[i].to], b);
        for (size_t k = 0; k < 3; ++k) {
            node->center[k] += (a[k] + b[k]) / (2.0 * (double)(end - first));
        }
    }
    for (size_t i = first; i < end; ++i) {
        add_triangle(w, w->boundary.edges[i].from, w->boundary.edges[i].to, node);
    }
    node->radius *= 1.0 + 0x1p-30; /* and so is more than rounding makes of it */
}

/* The ends of a cluster that do not cancel. Returns false when out of memory. */
static bool make_star(maker *m, svo_i_cluster *node)
{
    svo_i_clusters *w = m->made;
    const size_t first = svo_i_cluster_first_edge(w, node);
    const size_t end = svo_i_cluster_edges_end(w, node);
    size_t count = 0;
    m->touched_count = 0;
    for (size_t i = 2 * first; i < 2 * end; ++i) {
        const svo_i_boundary_edge *edge = &w->boundary.edges[i / 2];
        const uint32_t point = i % 2 == 0 ? edge->from : edge->to;
        m->touched[m->touched_count++] = point;
        m->ends[point] += i % 2 == 0 ? -1 : 1;
    }
    if (w->star_count + m->touched_count > m->star_capacity) {
        const size_t capacity = 2 * m->star_capacity + m->touched_count;
        svo_i_cluster_star *grown = svo_i_grow(m->memory, w->stars, capacity * sizeof *grown);
        if (grown == NULL) {
            return false;
        }
        w->stars = grown;
        m->star_capacity = capacity;
    }
    for (size_t i = 0; i < m->touched_count; ++i) {
        const uint32_t point = m->touched[i];
        if (m->ends[point] != 0) {
            w->stars[w->star_count + count++] = (svo_i_cluster_star){point, m->ends[point]};
            m->ends[point] = 0;
        }
    }
    node->is_far = 2 * count < end - first;
    node->star_first = w->star_count;
    node->star_count = node->is_far ? count : 0;
    const svo_i_cluster_star *star = &w->stars[node->star_first];
    node->is_path = node->star_count == 2 && star[0].times * star[1].times == -1;
    if (node->is_path) { /* its chord, in place of two edges by the center, closes the cone */
        const size_t begin = star[0].times < 0 ? 0 : 1;
        add_triangle(w, star[1 - begin].point, star[begin].point, node);
    }
    w->star_count += node->star_count;
    return true;
}

/* How many of these pieces the first half has: whole loops, if they are of several. */
static uint32_t find_split(const svo_i_clusters *w, uint32_t first, uint32_t count)
{
    const svo_i_boundary_piece *pieces = w->boundary.pieces + first;
    for (uint32_t away = 0; away < count / 2; ++away) {
        const uint32_t below = count / 2 - away;
        const uint32_t above = count / 2 + away;
        if (pieces[below].loop_first != pieces[below - 1].loop_first) {
            return below;
        }
        if (above < count && pieces[above].loop_first != pieces[above - 1].loop_first) {
            return above;
        }
    }
    return count / 2;
}

/* Adds the cluster of these pieces and those below it. Returns false when out of memory. */
static bool make_nodes(maker *m, uint32_t first, uint32_t count)
{
    svo_i_clusters *w = m->made;
    const size_t index = w->node_count++;
    svo_i_cluster *node = &w->nodes[index];
    *node = (svo_i_cluster){.first = first, .count = count};
    node->is_leaf = count == 1 || svo_i_cluster_edges_end(w, node) - svo_i_cluster_first_edge(w, node) <= LEAF_EDGES;
    measure(w, node);
    if (!make_star(m, node)) {
        return false;
    }
    const uint32_t half = node->is_leaf ? 0 : find_split(w, first, count);
    if (!node->is_leaf && (!make_nodes(m, first, half) || !make_nodes(m, first + half, count - half))) {
        return false;
    }
    node->end = w->node_count;
    return true;
}

/* A piece by the place of its loop. */
typedef struct placed_piece {
    uint64_t code; /* 0: of a long loop */
    svo_i_boundary_piece piece;
} placed_piece;

static int compare_pieces(const void *a, const void *b)
{
    const placed_piece *left = a;
    const placed_piece *right = b;
    return left->code != right->code
               ? (left->code > right->code) - (left->code < right->code)
               : (left->piece.first > right->piece.first) - (left->piece.first < right->piece.first);
}

static uint64_t code_of_loop(const svo_i_boundary *boundary, const svo_i_boundary_piece *piece)
{
    uint32_t cell[3];
    for (size_t k = 0; k < 3; ++k) {
        uint64_t sum = 0;
        for (uint64_t i = piece->loop_first; i < piece->loop_end; ++i) {
            sum += (uint64_t)boundary->points[boundary->edges[i].from].half[k];
        }
        cell[k] = (uint32_t)(sum / (piece->loop_end - piece->loop_first));
    }
    return 1 + svo_cell_to_code(cell);
}

/* Puts short loops behind the others, with those side by side that lie close together, and edges in their order.
   Returns false when out of memory. */
static bool sort_pieces(const svo_i_memory *memory, svo_i_boundary *boundary)
{
    placed_piece *placed = svo_i_alloc_zeroed(memory, boundary->piece_count, sizeof *placed);
    svo_i_boundary_edge *edges = svo_i_alloc_zeroed(memory, boundary->edge_count, sizeof *edges);
    size_t count = 0;
    if (placed == NULL || edges == NULL) {
        svo_i_free(placed);
        svo_i_free(edges);
        return false;
    }
    for (size_t i = 0; i < boundary->piece_count; ++i) {
        const svo_i_boundary_piece *piece = &boundary->pieces[i];
        placed[i] = (placed_piece){piece->of_long != 0 ? 0 : code_of_loop(boundary, piece), *piece};
    }
    qsort(placed, boundary->piece_count, sizeof *placed, compare_pieces);
    for (size_t i = 0; i < boundary->piece_count; ++i) {
        const svo_i_boundary_piece *piece = &placed[i].piece;
        memcpy(edges + count, boundary->edges + piece->first, piece->count * sizeof *edges);
        boundary->pieces[i] = *piece;
        boundary->pieces[i].first = count;
        count += piece->count;
    }
    svo_i_free(placed);
    svo_i_free(boundary->edges);
    boundary->edges = edges;
    return true;
}

/* Makes the clusters of each long loop, and of all others together. Returns false when out of memory. */
static bool make_trees(maker *m, const svo_i_boundary *boundary)
{
    size_t end = 0;
    for (size_t first = 0; first < boundary->piece_count; first = end) {
        while (end < boundary->piece_count && boundary->pieces[end].of_long == boundary->pieces[first].of_long) {
            ++end;
        }
        if (!make_nodes(m, (uint32_t)first, (uint32_t)(end - first))) {
            return false;
        }
    }
    return true;
}

bool svo_i_clusters_make(const svo_i_memory *memory, svo_i_clusters *w)
{
    const svo_i_boundary *boundary = &w->boundary;
    maker m = {.made = w, .memory = memory};
    if (boundary->piece_count == 0) {
        return true;
    }
    w->nodes = svo_i_alloc_zeroed(memory, 2 * boundary->piece_count, sizeof *w->nodes);
    m.ends = svo_i_alloc_zeroed(memory, boundary->point_count, sizeof *m.ends);
    m.touched = svo_i_alloc_zeroed(memory, 2 * boundary->edge_count, sizeof *m.touched);
    const bool good = w->nodes != NULL && m.ends != NULL && m.touched != NULL && sort_pieces(memory, &w->boundary) &&
                      make_trees(&m, boundary);
    svo_i_free(m.ends);
    svo_i_free(m.touched);
    return good;
}

void svo_i_clusters_release(svo_i_clusters *clusters)
{
    svo_i_boundary_release(&clusters->boundary);
    svo_i_free(clusters->nodes);
    svo_i_free(clusters->stars);
    clusters->nodes = NULL;
    clusters->stars = NULL;
}
