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
 * Cells of a node share what is far from all of its cube, as in fast multipole methods: top-down, a node adds clusters
 * of whole loops, no wall of which meets the cube, to a linear function, and hands the others to its children. With h
 * half the diagonal, that is off by less than 3 h^2 S / (d - R - h)^4 besides, since 6 / r^4 bounds the third
 * derivatives of 1 / r. So fewer clusters are left for each cell.
 *
 * Angles are added up as a product of complex numbers, with the turns around 0 counted: one arc tangent a sum.
 *
 * All of it is +, -, *, / and sqrt of doubles in one order, rounded as IEEE 754 says: every host has the same bits.
 */
#include "solid/winding.h"

#include <math.h>
#include <stdlib.h>

#include "svocl/nodes.h"

#define PI 3.14159265358979323846

/* An angle is off by less than this times the sum of the number's terms by its size. In units of 2^-53: a coordinate is
   off by 2 of itself, |a| by 4, s by 12, the terms by 28; the angle by 1.1 sqrt(2) times that, and the arc by 8. */
#define ANGLE_ERROR 0x1p-46

/* Closer to 1/2 than this, or than the sum may be off, is ambiguous. */
#define AMBIGUOUS 0x1p-32

/* The most that what stands for a cluster may be off, as an angle, pass by pass; 0: there are no clusters. */
static const double tolerances[] = {0x1p-2, 0x1p-6, 0x1p-9, 0x1p-14, 0x1p-21, 0.0};
#define PASSES (sizeof tolerances / sizeof tolerances[0])

/* Of those, the first ones add up what is far from a box for all of it. */
#define BOX_PASSES 3

/* The same of clusters in the sum of a box, and of those that are not divided there. */
#define BOX_TOLERANCE    0x1p-8
#define LISTED_TOLERANCE 0x1p-6

/* A box with no more pieces of the boundary near it serves for all nodes below it. */
#define FEW_PIECES 32

/* Of a box, by its width: more than sqrt(3) / 2. */
#define HALF_DIAGONAL 0.8661

/* ---- angles ---- */

/* A point from the center of the voxel. */
typedef struct seen {
    double x, y, s;
} seen;

/* A sum of angles: one, whole turns, and that of a complex number which is a product. */
typedef struct turn {
    double angle, x, y, error;
    int64_t turns;
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
    const svo_i_boundary_point *a = &w->clusters.boundary.points[edge->from];
    const svo_i_boundary_point *b = &w->clusters.boundary.points[edge->to];
    const svo_big du = svo_big_of(svo_short_subtract(b->offset[0], a->offset[0]));
    const svo_big dv = svo_big_of(svo_short_subtract(b->offset[1], a->offset[1]));
    if (svo_big_sign(du) == 0 && svo_big_sign(dv) == 0) {
        return 0;
    }
    const svo_short width = svo_decided_width(&w->grid);
    const svo_short half = svo_short_half(width);
    svo_short p[2];
    for (size_t k = 0; k < 2; ++k) {
        p[k] = svo_short_subtract(svo_exact_place(a->offset[k], from->cell[k], width), half);
    }
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

/* So that an angle of pi is one to the left or to the right, and no sum rounds from one to the other. */
#define LEAST_TURN 0x1p-60

/* Turns by the angle of x + i y, between -pi and pi. |x| + |y| is 1, and y is not 0. */
static void turn_by(double x, double y, turn *sum)
{
    const double real = sum->x * x - sum->y * y;
    const double imaginary = sum->x * y + sum->y * x;
    /* Turns to the left lead from the upper half plane to the lower one across the negative numbers, and so back. */
    sum->turns += y > 0.0 && sum->y >= 0.0 && imaginary < 0.0 ? 1 : 0;
    sum->turns -= y < 0.0 && sum->y < 0.0 && imaginary >= 0.0 ? 1 : 0;
    const double scale = fabs(real) + fabs(imaginary) < 0.25 ? 4.0 : 1.0;
    sum->x = real * scale;
    sum->y = imaginary * scale;
}

/* Adds the angle of an edge. side: its exact sign; 2: that of the sum. */
static void add_angle(const seen *a, const seen *b, int side, int32_t times, turn *sum)
{
    const double left = a->x * b->y;
    const double right = a->y * b->x;
    const double imaginary = left - right;
    const double first = a->s * b->s;
    const double real = first + (a->x * b->x + a->y * b->y);
    const double terms = first + fabs(a->x * b->x) + fabs(a->y * b->y) + fabs(left) + fabs(right);
    const double size = fabs(real) + fabs(imaginary);
    if (size == 0.0) {
        return;
    }
    const double inverse = 1.0 / size;
    const bool is_left = (side == 2 ? imaginary >= 0.0 : side > 0) == (times > 0);
    const double y = fmax(fabs(imaginary) * inverse, LEAST_TURN);
    const int32_t count = times < 0 ? -times : times;
    for (int32_t i = 0; i < count; ++i) {
        turn_by(real * inverse, is_left ? y : -y, sum);
    }
    sum->error += count * (ANGLE_ERROR * terms * inverse);
}

/* The whole sum. */
static double angle_of_turn(const turn *sum)
{
    const double angle = angle_of(sum->x, fabs(sum->y));
    return sum->angle + 2.0 * PI * (double)sum->turns + (sum->y < 0.0 ? -angle : angle);
}

static void add_edge(const svo_i_winding *w, const svo_i_boundary_edge *edge, const seen *a, const seen *b,
                     const middle *from, turn *sum)
{
    const double left = a->x * b->y;
    const double right = a->y * b->x;
    const bool is_sure = fabs(left - right) > 0x1p-48 * (fabs(left) + fabs(right));
    const int side = is_sure ? 2 : exact_side(w, edge, from);
    if (side != 0) { /* else its wall has no area */
        add_angle(a, b, side, 1, sum);
    }
}

static void add_leaf(const svo_i_winding *w, const svo_i_cluster *node, const middle *from, turn *sum)
{
    const size_t end = svo_i_cluster_edges_end(&w->clusters, node);
    uint32_t last = UINT32_MAX;
    seen b = {0.0, 0.0, 0.0};
    for (size_t i = svo_i_cluster_first_edge(&w->clusters, node); i < end; ++i) {
        const svo_i_boundary_edge *edge = &w->clusters.boundary.edges[i];
        const seen a = edge->from == last ? b : see_point(&w->clusters.boundary.points[edge->from], from);
        b = see_point(&w->clusters.boundary.points[edge->to], from);
        last = edge->to;
        add_edge(w, edge, &a, &b, from, sum);
    }
}

/* Adds the walls below a star, or below the chord of a path. to: the center. */
static void add_star(const svo_i_winding *w, const svo_i_cluster *node, const double to[3], const middle *from,
                     turn *sum)
{
    const svo_i_cluster_star *star = &w->clusters.stars[node->star_first];
    if (node->is_path) {
        const seen a = see_point(&w->clusters.boundary.points[star[0].point], from);
        const seen b = see_point(&w->clusters.boundary.points[star[1].point], from);
        add_angle(&a, &b, 2, star[1].times, sum);
        return;
    }
    const seen center = see(to);
    for (size_t i = 0; i < node->star_count; ++i) {
        const seen point = see_point(&w->clusters.boundary.points[star[i].point], from);
        add_angle(&center, &point, 2, star[i].times, sum);
    }
}

/* Adds a cluster by what stands for it, where that is not off by more. Returns whether it did. */
static bool add_far(const svo_i_winding *w, const svo_i_cluster *node, const middle *from, double tolerance, turn *sum)
{
    const double to[3] = {node->center[0] - from->at[0], node->center[1] - from->at[1], node->center[2] - from->at[2]};
    const double distance = sqrt(svo_i_cluster_dot(to, to));
    const double gap = distance * (1.0 - 0x1p-30) - node->radius;
    const double cube = gap * gap * gap;
    const bool is_above = to[2] + node->radius > 0.0 && to[0] * to[0] + to[1] * to[1] <= node->radius * node->radius;
    /* Half of what the solid angle is off by, as angles of walls are half of theirs. */
    const double off = node->radius * node->area * (1.0 + 0x1p-30);
    if (!node->is_far || gap <= node->radius || off > tolerance * cube || is_above) {
        return false;
    }
    add_star(w, node, to, from, sum);
    sum->angle -= 0.5 * svo_i_cluster_dot(node->dipole, to) / (distance * distance * distance);
    sum->error += off / cube + 0x1p-40 * node->area / (distance * distance);
    return true;
}

/* Sums up the walls of clusters: their solid angles by 2. */
static void add_walls(const svo_i_winding *w, size_t first, size_t end, const middle *from, double tolerance, turn *sum)
{
    for (size_t i = first; i < end;) {
        const svo_i_cluster *node = &w->clusters.nodes[i];
        if (tolerance > 0.0 && add_far(w, node, from, tolerance, sum)) {
            i = node->end;
        } else {
            if (node->is_leaf) {
                add_leaf(w, node, from, sum);
            }
            ++i;
        }
    }
}

/* ---- boxes ---- */

/* What becomes of a cluster in a box. */
typedef enum box_use {
    BOX_ADDED, /* it is part of the sum */
    BOX_LISTED, /* each voxel adds it, or its parts */
    BOX_DIVIDED /* its parts may be far away */
} box_use;

/* Adds a cluster to the sum of a box, if no wall of it passes through the box, and what stands for it is not off by
   more anywhere in there. */
static box_use use_in_box(const svo_i_cluster *node, svo_i_winding_box *box)
{
    const double to[3] = {node->center[0] - box->center[0], node->center[1] - box->center[1],
                          node->center[2] - box->center[2]};
    const double square = svo_i_cluster_dot(to, to);
    const double distance = sqrt(square);
    const double reach = HALF_DIAGONAL * box->width;
    const double gap = distance * (1.0 - 0x1p-30) - node->radius - reach;
    const double cube = gap * gap * gap;
    const double beside = node->radius + reach;
    const bool is_above =
        to[2] + node->radius + 0.5 * box->width > 0.0 && to[0] * to[0] + to[1] * to[1] <= beside * beside;
    const box_use other = node->is_leaf || node->radius <= reach ? BOX_LISTED : BOX_DIVIDED;
    if (!node->is_far || gap <= node->radius || is_above || node->radius * node->area > LISTED_TOLERANCE * cube) {
        return other;
    }
    const double off = node->area * (node->radius + 1.5 * reach * reach / gap) * (1.0 + 0x1p-30);
    if (node->star_count > 0 || off > BOX_TOLERANCE * cube) {
        return BOX_LISTED; /* it is far away from each voxel */
    }
    const double along = svo_i_cluster_dot(node->dipole, to);
    const double scale = 0.5 / (square * distance);
    box->angle -= scale * along;
    for (size_t k = 0; k < 3; ++k) {
        box->slope[k] += scale * (node->dipole[k] - 3.0 * along * to[k] / square);
    }
    box->error += off / cube + 0x1p-38 * node->area / square + 0x1p-52 * fabs(box->angle);
    return BOX_ADDED;
}

/* Makes the box of a node from that above it. */
static void make_box(svo_i_winding *w, uint32_t level, uint64_t code)
{
    const svo_i_winding_box *above = &w->boxes[level - 1];
    svo_i_winding_box *box = &w->boxes[level];
    uint32_t cell[3];
    *box = *above;
    box->code = code;
    box->width = 0.5 * above->width;
    box->first = above->end;
    box->end = above->end;
    box->piece_count = 0;
    svo_code_to_cell(code, cell);
    for (size_t k = 0; k < 3; ++k) {
        box->center[k] = w->grid.corner[k] + (cell[k] + 0.5) * box->width;
        const double step = above->slope[k] * (box->center[k] - above->center[k]);
        box->angle += step;
        box->error += 0x1p-50 * (fabs(step) + fabs(box->angle));
    }
    for (size_t item = above->first; item < above->end; ++item) {
        const size_t end = w->clusters.nodes[w->near[item]].end;
        for (size_t i = w->near[item]; i < end;) {
            const svo_i_cluster *node = &w->clusters.nodes[i];
            const box_use use = use_in_box(node, box);
            if (use == BOX_LISTED) {
                w->near[box->end++] = (uint32_t)i;
                box->piece_count += node->count;
            }
            i = use == BOX_DIVIDED ? i + 1 : node->end;
        }
    }
}

/* Prepares the boxes. Returns false when out of memory. */
static bool make_boxes(const svo_i_memory *memory, svo_i_winding *w, uint32_t depth)
{
    w->boxes = svo_i_alloc_zeroed(memory, depth, sizeof *w->boxes);
    w->near = svo_i_alloc_zeroed(memory, depth * (w->clusters.boundary.piece_count + 1), sizeof *w->near);
    if (w->boxes == NULL || w->near == NULL) {
        return false;
    }
    svo_i_winding_box *root = &w->boxes[0];
    root->width = (double)(1u << depth);
    for (size_t k = 0; k < 3; ++k) {
        root->center[k] = w->grid.corner[k] + 0.5 * root->width;
    }
    for (size_t i = 0; i < w->clusters.node_count; i = w->clusters.nodes[i].end) {
        w->near[root->end++] = (uint32_t)i;
        root->piece_count += w->clusters.nodes[i].count;
    }
    return true;
}

void svo_i_winding_enter(svo_i_winding *w, uint32_t level, uint64_t code)
{
    uint32_t at = level < w->box_level ? level : w->box_level;
    while (w->boxes[at].code != code >> 3 * (level - at)) {
        --at;
    }
    for (; at < level && w->boxes[at].piece_count > FEW_PIECES; ++at) {
        make_box(w, at + 1, code >> 3 * (level - at - 1));
    }
    w->box_level = at;
}

/* The sum by the box that was entered: of what is far from it, and what is near. */
static turn add_box(const svo_i_winding *w, const middle *from, double tolerance)
{
    const svo_i_winding_box *box = &w->boxes[w->box_level];
    turn sum = {.angle = box->angle, .x = 1.0, .error = box->error};
    for (size_t k = 0; k < 3; ++k) {
        const double step = box->slope[k] * (from->at[k] - box->center[k]);
        sum.angle += step;
        sum.error += 0x1p-50 * (fabs(step) + fabs(sum.angle));
    }
    for (size_t item = box->first; item < box->end; ++item) {
        const size_t i = w->near[item];
        add_walls(w, i, w->clusters.nodes[i].end, from, tolerance, &sum);
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
        status = svo_i_boundary_find(&tree->device->memory, &mesh, &out->clusters.boundary);
    }
    if (status == SVO_OK && (!svo_i_clusters_make(&tree->device->memory, &out->clusters) ||
                             !make_boxes(&tree->device->memory, out, tree->info.depth))) {
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
    svo_i_clusters_release(&winding->clusters);
    svo_i_free(winding->boxes);
    svo_i_free(winding->near);
    winding->boxes = NULL;
    winding->near = NULL;
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
        turn sum = {.x = 1.0};
        if (pass < BOX_PASSES) {
            sum = add_box(winding, &from, tolerances[pass]);
        } else {
            add_walls(winding, 0, winding->clusters.node_count, &from, tolerances[pass], &sum);
        }
        const double angle = angle_of_turn(&sum);
        const double over = (crossings - 0.5) - angle / (2.0 * PI);
        const double error = (sum.error + 0x1p-48 * fabs(angle)) / (2.0 * PI) + 0x1p-48 * fabs((double)crossings);
        if (fabs(over) > error + AMBIGUOUS) {
            return over > 0.0 ? SVO_I_WINDING_ABOVE : SVO_I_WINDING_BELOW;
        }
    }
    return SVO_I_WINDING_AMBIGUOUS;
}
