/* SPDX-License-Identifier: MIT */
/*
 * Generalized winding numbers (Jacobson, Kavan and Sorkine-Hornung, "Robust Inside-Outside Segmentation using
 * Generalized Winding Numbers", 2013), by one line and the boundary, as in Martens and Bessmeltsev, "The One-Shot
 * Method for Robust Winding Numbers" (2025).
 *
 * Walls that hang from the edges of the boundary down to infinity close the mesh: with them, the winding number at a
 * point is the sum of crossings of the line from there upwards, which meets no wall. So that of the mesh is
 *
 *     w = crossings - (sum of the walls' solid angles) / 4 pi
 *
 * Crossings are exact (cross.cl). The solid angle of the wall below the edge from a to b, seen from the origin, is
 * twice the angle of the complex number (Van Oosterom and Strackee, 1983)
 *
 *     s_a s_b + conj(a') b'        with a' = a_x + i a_y and s_a = |a| - a_z
 *
 * It jumps by 4 pi where the line passes through the edge, as crossings do by 1. So the sign of its imaginary part is
 * that of kernels/solid/crossing.clh, exact and by the top-left rule, which is as if the point lay a bit further in
 * direction +x, and less in direction -y. What rounding may do to an angle is then a matter of how far it turns: the
 * number is small beside its terms only if the edge passes close by the point. The bounds on errors are the sum of
 * these.
 *
 * Far away, a cluster of edges is replaced by edges from its center to the ends that do not cancel in it, none if it
 * has whole loops. The two differ by a closed chain, whose cone from the center is a surface in a ball. Where the line
 * does not meet the ball, the difference is that surface's solid angle, of which the dipole is taken (Barill, Dickson,
 * Schmidt, Levin and Jacobson, "Fast Winding Numbers for Soups and Clouds", 2018). With area S, radius R and distance
 * d, it is off by less than 2 R S / (d - R)^3, since 2 / r^3 bounds the derivative of x / |x|^3. Numbers that this
 * leaves undecided are summed up again with less of it, and at last with none: no result depends on clusters.
 *
 * All of it is +, -, *, / and sqrt of doubles in one order, rounded as IEEE 754 says: every host has the same bits.
 */
#include "solid/winding.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "svocl/nodes.h"

#define PI 3.14159265358979323846

/* Edges of a cluster without children, unless one piece has more. */
#define LEAF_EDGES SVO_I_PIECE_EDGES

/* An angle is off by less than this times the sum of the number's terms by its size. In units of 2^-53: a coordinate is
   off by 2 of itself, |a| by 4, s by 12, the terms by 28; the angle by 1.1 sqrt(2) times that, and the arc by 8. */
#define ANGLE_ERROR 0x1p-46

/* Closer to 1/2 than this, or than the sum may be off, is ambiguous. */
#define AMBIGUOUS 0x1p-32

/* From so many radii off on a cluster is far away, pass by pass; 0: none is. */
static const double far_ratios[] = {2.0, 4.0, 12.0, 64.0, 0.0};
#define PASSES (sizeof far_ratios / sizeof far_ratios[0])

/* An edge from a cluster's center to a point. */
typedef struct svo_i_winding_star {
    uint32_t point;
    int32_t times; /* -1 : from the point to the center */
} svo_i_winding_star;

/* A cluster of pieces that follow each other. */
typedef struct svo_i_winding_node {
    double center[3], radius; /* in voxels, of a ball that holds it */
    double dipole[3], area; /* of the cone: the sum of its triangles, and of their sizes */
    size_t end; /* the node behind it and all below it */
    uint32_t first, count; /* pieces */
    size_t star_first, star_count;
    bool is_leaf, is_far; /* may be taken for far away */
} svo_i_winding_node;

/* ---- clusters ---- */

typedef struct maker {
    svo_i_winding *made;
    const svo_i_memory *memory;
    int32_t *ends; /* by point: how often edges of a cluster end there, less how often they begin there */
    uint32_t *touched; /* points of the cluster */
    size_t touched_count, star_capacity;
} maker;

static void point_at(const svo_i_boundary_point *point, double out[3])
{
    for (size_t k = 0; k < 3; ++k) {
        out[k] = 0.5 * point->half[k] + point->rest[k];
    }
}

static size_t first_edge(const svo_i_winding *w, const svo_i_winding_node *node)
{
    return w->boundary.pieces[node->first].first;
}

static size_t edges_end(const svo_i_winding *w, const svo_i_winding_node *node)
{
    const svo_i_boundary_piece *last = &w->boundary.pieces[node->first + node->count - 1];
    return last->first + last->count;
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The ball and the cone of a cluster. */
static void measure(const svo_i_winding *w, svo_i_winding_node *node)
{
    const size_t first = first_edge(w, node);
    const size_t end = edges_end(w, node);
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
        double side[3];
        point_at(&w->boundary.points[w->boundary.edges[i].from], a);
        point_at(&w->boundary.points[w->boundary.edges[i].to], b);
        for (size_t k = 0; k < 3; ++k) {
            a[k] -= node->center[k];
            b[k] -= node->center[k];
        }
        for (size_t k = 0; k < 3; ++k) {
            side[k] = 0.5 * (a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3]);
            node->dipole[k] += side[k];
        }
        node->area += sqrt(dot(side, side));
        node->radius = fmax(node->radius, sqrt(fmax(dot(a, a), dot(b, b))));
    }
    node->radius *= 1.0 + 0x1p-30; /* and so is more than rounding makes of it */
}

/* The ends of a cluster that do not cancel. Returns false when out of memory. */
static bool make_star(maker *m, svo_i_winding_node *node)
{
    svo_i_winding *w = m->made;
    const size_t first = first_edge(w, node);
    const size_t end = edges_end(w, node);
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
        svo_i_winding_star *grown = svo_i_grow(m->memory, w->stars, capacity * sizeof *grown);
        if (grown == NULL) {
            return false;
        }
        w->stars = grown;
        m->star_capacity = capacity;
    }
    for (size_t i = 0; i < m->touched_count; ++i) {
        const uint32_t point = m->touched[i];
        if (m->ends[point] != 0) {
            w->stars[w->star_count + count++] = (svo_i_winding_star){point, m->ends[point]};
            m->ends[point] = 0;
        }
    }
    node->is_far = 2 * count < end - first;
    node->star_first = w->star_count;
    node->star_count = node->is_far ? count : 0;
    w->star_count += node->star_count;
    return true;
}

/* How many of these pieces the first half has: whole loops, if they are of several. */
static uint32_t find_split(const svo_i_winding *w, uint32_t first, uint32_t count)
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
    svo_i_winding *w = m->made;
    const size_t index = w->node_count++;
    svo_i_winding_node *node = &w->nodes[index];
    *node = (svo_i_winding_node){.first = first, .count = count};
    node->is_leaf = count == 1 || edges_end(w, node) - first_edge(w, node) <= LEAF_EDGES;
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

static bool make_clusters(const svo_i_memory *memory, svo_i_winding *w)
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

/* ---- angles ---- */

/* A point from the center of the voxel. */
typedef struct seen {
    double x, y, s;
} seen;

/* A sum of angles. */
typedef struct turn {
    double angle, error;
} turn;

/* The center of a voxel, in half voxels and in units of exact.clh. */
typedef struct middle {
    int32_t half[3];
    uint32_t cell[3];
    double at[3];
} middle;

static seen see(const double at[3])
{
    const double square = at[0] * at[0] + at[1] * at[1];
    const double length = sqrt(square + at[2] * at[2]);
    if (square == 0.0 && at[2] > 0.0) {
        return (seen){-1.0, 0.0, 0.0}; /* the line passes at its +x side: only the direction matters */
    }
    return (seen){at[0], at[1], at[2] > 0.0 ? square / (length + at[2]) : length - at[2]};
}

static seen see_point(const svo_i_boundary_point *point, const middle *from)
{
    double at[3];
    for (size_t k = 0; k < 3; ++k) {
        at[k] = 0.5 * (point->half[k] - from->half[k]) + point->rest[k];
    }
    return see(at);
}

/* The side of the edge from a to b that the line is on: 1 left, -1 right, by the top-left rule too; 0: the edge has no
   length as the line sees it. */
static int exact_side(const svo_i_winding *w, const svo_i_boundary_edge *edge, const middle *from)
{
    const svo_i_boundary_point *a = &w->boundary.points[edge->from];
    const svo_i_boundary_point *b = &w->boundary.points[edge->to];
    const svo_short width = svo_decided_width(&w->grid);
    const svo_short half = svo_short_half(width);
    svo_short p[2];
    for (size_t k = 0; k < 2; ++k) {
        p[k] = svo_short_subtract(svo_exact_place(a->offset[k], from->cell[k], width), half);
    }
    const svo_big du = svo_big_of(svo_short_subtract(b->offset[0], a->offset[0]));
    const svo_big dv = svo_big_of(svo_short_subtract(b->offset[1], a->offset[1]));
    const SVO_I32 side = svo_big_sign(svo_big_subtract(svo_big_multiply(p[0], dv), svo_big_multiply(p[1], du)));
    return side != 0 ? side : svo_big_sign(dv) != 0 ? -svo_big_sign(dv) : -svo_big_sign(du);
}

/* The arc tangent of t in 0 .. 1: off by less than 2^-52. */
static double arc(double t)
{
    static const double known[5] = {0.0, 0.24497866312686415417, 0.46364760900080611621, 0.64350110879328438680,
                                    0.78539816339744830962};
    const int nearest = (int)(t * 4.0 + 0.5);
    const double c = 0.25 * nearest;
    const double r = (t - c) / (1.0 + t * c);
    const double q = r * r;
    double sum = 1.0 / 17.0;
    for (int n = 15; n > 0; n -= 2) {
        sum = 1.0 / n - q * sum;
    }
    return known[nearest] + r * sum;
}

/* The angle of x + i y, in 0 .. pi; y is not negative. */
static double angle_of(double x, double y)
{
    const double size = fabs(x);
    if (size == 0.0 && y == 0.0) {
        return 0.0;
    }
    const double acute = y <= size ? arc(y / size) : 0.5 * PI - arc(size / y);
    return x < 0.0 ? PI - acute : acute;
}

/* Adds the angle of an edge. side: its exact sign; 2: that of the sum. */
static void add_angle(const seen *a, const seen *b, int side, double times, turn *sum)
{
    const double left = a->x * b->y;
    const double right = a->y * b->x;
    const double imaginary = left - right;
    const double first = a->s * b->s;
    const double real = first + (a->x * b->x + a->y * b->y);
    const double terms = first + fabs(a->x * b->x) + fabs(a->y * b->y) + fabs(left) + fabs(right);
    const double size = fabs(real) + fabs(imaginary);
    const double angle = angle_of(real, fabs(imaginary));
    const double sign = side == 2 ? (imaginary < 0.0 ? -1.0 : 1.0) : side;
    sum->angle += times * sign * angle;
    sum->error += size > 0.0 ? fabs(times) * (ANGLE_ERROR * terms / size) : 0.0;
    sum->error += 0x1p-53 * fabs(sum->angle);
}

static void add_edge(const svo_i_winding *w, const svo_i_boundary_edge *edge, const seen *a, const seen *b,
                     const middle *from, turn *sum)
{
    const double left = a->x * b->y;
    const double right = a->y * b->x;
    const bool is_sure = fabs(left - right) > 0x1p-48 * (fabs(left) + fabs(right));
    add_angle(a, b, is_sure ? 2 : exact_side(w, edge, from), 1.0, sum);
}

static void add_leaf(const svo_i_winding *w, const svo_i_winding_node *node, const middle *from, turn *sum)
{
    const size_t end = edges_end(w, node);
    uint32_t last = UINT32_MAX;
    seen b = {0.0, 0.0, 0.0};
    for (size_t i = first_edge(w, node); i < end; ++i) {
        const svo_i_boundary_edge *edge = &w->boundary.edges[i];
        const seen a = edge->from == last ? b : see_point(&w->boundary.points[edge->from], from);
        b = see_point(&w->boundary.points[edge->to], from);
        last = edge->to;
        add_edge(w, edge, &a, &b, from, sum);
    }
}

/* Adds a cluster by what stands for it, where its ball is at least so many radii away. Returns whether it did. */
static bool add_far(const svo_i_winding *w, const svo_i_winding_node *node, const middle *from, double ratio, turn *sum)
{
    const double to[3] = {node->center[0] - from->at[0], node->center[1] - from->at[1], node->center[2] - from->at[2]};
    const double distance = sqrt(dot(to, to));
    const double gap = distance * (1.0 - 0x1p-30) - node->radius;
    const bool is_above = to[2] + node->radius > 0.0 && to[0] * to[0] + to[1] * to[1] <= node->radius * node->radius;
    if (!node->is_far || gap <= ratio * node->radius || is_above) {
        return false;
    }
    const seen center = see(to);
    for (size_t i = 0; i < node->star_count; ++i) {
        const svo_i_winding_star *star = &w->stars[node->star_first + i];
        const seen point = see_point(&w->boundary.points[star->point], from);
        add_angle(&center, &point, 2, star->times, sum);
    }
    sum->angle -= 0.5 * dot(node->dipole, to) / (distance * distance * distance);
    /* Half of what the solid angle is off by, as angles of walls are half of theirs. */
    sum->error += node->radius * node->area / (gap * gap * gap) * (1.0 + 0x1p-30);
    sum->error += 0x1p-40 * node->area / (distance * distance);
    return true;
}

/* Sums up all walls: their solid angles by 2. ratio: of clusters; 0: there are none. */
static turn add_walls(const svo_i_winding *w, const middle *from, double ratio)
{
    turn sum = {0.0, 0.0};
    for (size_t i = 0; i < w->node_count;) {
        const svo_i_winding_node *node = &w->nodes[i];
        if (ratio > 0.0 && add_far(w, node, from, ratio, &sum)) {
            i = node->end;
        } else {
            if (node->is_leaf) {
                add_leaf(w, node, from, &sum);
            }
            ++i;
        }
    }
    return sum;
}

/* ---- the entrance ---- */

/* The mesh in arrays that the caller releases. */
static svo_status read_mesh(svo_i_device_work *work, const svo_tree *tree, cl_mem buffer, svo_i_solid_mesh *mesh,
                            uint32_t **indices, void **positions)
{
    const uint64_t coordinate = mesh->kind == SVO_SOLID_DOUBLES ? sizeof(cl_double) : sizeof(cl_float);
    const size_t index_bytes = (size_t)mesh->triangle_count * 3 * sizeof **indices;
    const size_t position_bytes = (size_t)mesh->vertex_count * 3 * (size_t)coordinate;
    *indices = svo_i_alloc(&tree->device->memory, index_bytes);
    *positions = svo_i_alloc(&tree->device->memory, position_bytes);
    if (*indices == NULL || *positions == NULL) {
        return SVO_OUT_OF_HOST_MEMORY;
    }
    mesh->indices = *indices;
    mesh->positions = *positions;
    SVO_I_TRY(svo_i_work_read(work, tree->buffers[SVO_TREE_INDICES], 0, *indices, index_bytes));
    return svo_i_work_read(work, buffer, 0, *positions, position_bytes);
}

svo_status svo_i_winding_of_tree(svo_i_device_work *work, const svo_tree *tree, cl_mem positions, uint32_t kind,
                                 const svo_decide_params *grid, svo_i_winding *out)
{
    const double origin[3] = {0.0, 0.0, 0.0};
    const svo_part_header whole = {.depth = 0};
    svo_i_solid_mesh mesh = {.kind = kind,
                             .triangle_count = (uint32_t)tree->info.list_triangle_count,
                             .vertex_count = (uint32_t)tree->info.vertex_count,
                             .grid = *grid};
    uint32_t *indices = NULL;
    void *held = NULL;
    if (kind == SVO_SOLID_SNAPPED) {
        const double edge = ldexp(1.0, (int)tree->info.snap_bits);
        mesh.grid = svo_i_grid_params(&whole, 0, 0, tree->info.depth, origin, edge);
    }
    *out = (svo_i_winding){.grid = mesh.grid};
    svo_status status = read_mesh(work, tree, positions, &mesh, &indices, &held);
    if (status == SVO_OK) {
        status = svo_i_boundary_find(&tree->device->memory, &mesh, &out->boundary);
    }
    if (status == SVO_OK && !make_clusters(&tree->device->memory, out)) {
        status = SVO_OUT_OF_HOST_MEMORY;
    }
    svo_i_free(indices);
    svo_i_free(held);
    if (status != SVO_OK) {
        svo_i_winding_release(out);
    }
    return status;
}

void svo_i_winding_release(svo_i_winding *winding)
{
    svo_i_boundary_release(&winding->boundary);
    svo_i_free(winding->nodes);
    svo_i_free(winding->stars);
    winding->nodes = NULL;
    winding->stars = NULL;
}

static middle middle_of(const svo_i_winding *w, const uint32_t voxel[3])
{
    middle out;
    for (size_t k = 0; k < 3; ++k) {
        out.cell[k] = w->grid.corner[k] + voxel[k];
        out.half[k] = (int32_t)(2 * out.cell[k] + 1);
        out.at[k] = 0.5 * out.half[k];
    }
    return out;
}

svo_i_winding_side svo_i_winding_at(const svo_i_winding *winding, const uint32_t voxel[3], int32_t crossings)
{
    const middle from = middle_of(winding, voxel);
    for (size_t pass = 0; pass < PASSES; ++pass) {
        const turn sum = add_walls(winding, &from, far_ratios[pass]);
        const double over = (crossings - 0.5) - sum.angle / (2.0 * PI);
        const double error = sum.error / (2.0 * PI) + 0x1p-50 * fabs((double)crossings);
        if (fabs(over) > error + AMBIGUOUS) {
            return over > 0.0 ? SVO_I_WINDING_ABOVE : SVO_I_WINDING_BELOW;
        }
    }
    return SVO_I_WINDING_AMBIGUOUS;
}
