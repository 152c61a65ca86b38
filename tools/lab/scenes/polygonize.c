/* SPDX-License-Identifier: MIT */
/*
 * Marching tetrahedra (Doi and Koide, 1991) on the body-centered cubic lattice.
 *
 * Nodes are the corners and the centers of cubic cells. Around each face between two neighboring cells lie four
 * tetrahedra, each made of the two centers and one edge of the face; they fill space, are all congruent, and meet face
 * to face, so the surface cut out of them is closed and edge-manifold whatever the field does between the nodes.
 * Vertices lie on lattice edges and are shared through a hash table keyed by the edge's midpoint.
 *
 * The lattice is processed in blocks. A block is skipped when the field at its center is too far from zero for the
 * surface to reach it, so the work grows with the surface, not with the volume.
 */
#include "polygonize.h"

#include <stdlib.h>
#include <string.h>

#define BLOCK_CELLS    8
#define BLOCK_NODES    (BLOCK_CELLS + 1)
#define CELL_WIDTH_MAX 0.3

/* A node in units of half a cell: corners have even coordinates, centers odd ones. */
typedef struct lattice_node {
    int32_t at[3];
    double value;
} lattice_node;

/* An open-addressing table from lattice edges to vertices; key 0 is a free slot. */
typedef struct edge_table {
    uint64_t *keys;
    uint32_t *vertices;
    size_t slot_count; /* a power of two */
    size_t used_count;
} edge_table;

typedef struct polygonizer {
    scene_builder *builder;
    const implicit_solid *solid;
    vector3 origin; /* of the lattice */
    double cell_width;
    edge_table edges;
} polygonizer;

typedef struct lattice_block {
    int32_t first_cell[3];
    double corners[BLOCK_NODES][BLOCK_NODES][BLOCK_NODES]; /* [z][y][x] */
    double centers[BLOCK_NODES][BLOCK_NODES][BLOCK_NODES];
} lattice_block;

static size_t edge_slot(const edge_table *table, uint64_t key)
{
    size_t slot = (size_t)((key * 0x9E3779B97F4A7C15u) >> 20) & (table->slot_count - 1);
    while (table->keys[slot] != 0 && table->keys[slot] != key) {
        slot = (slot + 1) & (table->slot_count - 1);
    }
    return slot;
}

static bool edge_table_grow(edge_table *table)
{
    edge_table grown = {.slot_count = table->slot_count == 0 ? 1u << 14 : 2 * table->slot_count};
    grown.keys = calloc(grown.slot_count, sizeof *grown.keys);
    grown.vertices = malloc(grown.slot_count * sizeof *grown.vertices);
    if (grown.keys == NULL || grown.vertices == NULL) {
        free(grown.keys);
        free(grown.vertices);
        return false;
    }
    for (size_t slot = 0; slot < table->slot_count; ++slot) {
        if (table->keys[slot] != 0) {
            const size_t moved = edge_slot(&grown, table->keys[slot]);
            grown.keys[moved] = table->keys[slot];
            grown.vertices[moved] = table->vertices[slot];
        }
    }
    grown.used_count = table->used_count;
    free(table->keys);
    free(table->vertices);
    *table = grown;
    return true;
}

static vector3 node_position(const polygonizer *work, const int32_t at[3])
{
    const double half = 0.5 * work->cell_width;
    return vector_add(work->origin, vector(half * at[0], half * at[1], half * at[2]));
}

static double field_at(const polygonizer *work, vector3 position)
{
    return work->solid->field(work->solid->context, position);
}

static vector3 field_gradient(const polygonizer *work, vector3 p)
{
    const double step = 0.25 * work->cell_width;
    return vector(field_at(work, vector(p.x + step, p.y, p.z)) - field_at(work, vector(p.x - step, p.y, p.z)),
                  field_at(work, vector(p.x, p.y + step, p.z)) - field_at(work, vector(p.x, p.y - step, p.z)),
                  field_at(work, vector(p.x, p.y, p.z + step)) - field_at(work, vector(p.x, p.y, p.z - step)));
}

/* The vertex between two nodes of different sign. It is kept off the nodes, so that no triangle collapses to a
   point. */
static surface_point crossing(const polygonizer *work, const lattice_node *inside, const lattice_node *outside)
{
    const double t = clamp_to(inside->value / (inside->value - outside->value), 0.04, 0.96);
    surface_point point;
    point.position = vector_mix(node_position(work, inside->at), node_position(work, outside->at), t);
    point.normal = vector_normalize(field_gradient(work, point.position));
    point.color = work->solid->color(work->solid->context, point.position);
    return point;
}

/* Twice the midpoint of the edge, 21 bits per axis. It identifies the edge, since no two edges share their midpoint. */
static uint64_t edge_key(const lattice_node *a, const lattice_node *b)
{
    uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
        key = key << 21 | (uint64_t)(a->at[axis] + b->at[axis]);
    }
    return key + 1;
}

static uint32_t edge_vertex(polygonizer *work, const lattice_node *inside, const lattice_node *outside)
{
    edge_table *table = &work->edges;
    if (2 * table->used_count >= table->slot_count && !edge_table_grow(table)) {
        work->builder->out_of_memory = true;
        return 0;
    }
    const uint64_t key = edge_key(inside, outside);
    const size_t slot = edge_slot(table, key);
    if (table->keys[slot] == 0) {
        const surface_point point = crossing(work, inside, outside);
        table->keys[slot] = key;
        table->vertices[slot] = builder_vertex(work->builder, &point);
        table->used_count += 1;
    }
    return table->vertices[slot];
}

/* Even permutations that move the inside nodes (bit k: node k) to the front, and their number. */
typedef struct tetrahedron_case {
    uint8_t inside_count;
    uint8_t order[4];
} tetrahedron_case;

static const tetrahedron_case cases[16] = {
    {0, {0, 1, 2, 3}}, {1, {0, 1, 2, 3}}, {1, {1, 0, 3, 2}}, {2, {0, 1, 2, 3}}, {1, {2, 3, 0, 1}}, {2, {0, 2, 3, 1}},
    {2, {1, 2, 0, 3}}, {3, {0, 1, 2, 3}}, {1, {3, 2, 1, 0}}, {2, {0, 3, 1, 2}}, {2, {1, 3, 2, 0}}, {3, {1, 0, 3, 2}},
    {2, {2, 3, 0, 1}}, {3, {0, 2, 3, 1}}, {3, {3, 2, 1, 0}}, {4, {0, 1, 2, 3}},
};

/* nodes: a positively oriented tetrahedron. Triangles are counter-clockwise seen from outside. */
static void emit_tetrahedron(polygonizer *work, const lattice_node *const nodes[4])
{
    unsigned mask = 0;
    for (unsigned k = 0; k < 4; ++k) {
        mask |= (nodes[k]->value < 0 ? 1u : 0u) << k;
    }
    const tetrahedron_case *found = &cases[mask];
    if (found->inside_count == 0 || found->inside_count == 4) {
        return;
    }
    if (work->builder->counting) {
        work->builder->triangle_count += found->inside_count == 2 ? 2 : 1;
        return;
    }
    const lattice_node *a = nodes[found->order[0]];
    const lattice_node *b = nodes[found->order[1]];
    const lattice_node *c = nodes[found->order[2]];
    const lattice_node *d = nodes[found->order[3]];
    /* One vertex per statement: their order in the mesh must not depend on the compiler. */
    const uint32_t first = found->inside_count == 1 ? edge_vertex(work, a, b) : edge_vertex(work, a, d);
    const uint32_t second = found->inside_count == 1 ? edge_vertex(work, a, c) : edge_vertex(work, b, d);
    if (found->inside_count == 1) {
        builder_triangle(work->builder, first, second, edge_vertex(work, a, d));
    } else if (found->inside_count == 2) {
        const uint32_t third = edge_vertex(work, b, c);
        builder_quad(work->builder, first, second, third, edge_vertex(work, a, c));
    } else {
        builder_triangle(work->builder, first, second, edge_vertex(work, c, d));
    }
}

static lattice_node block_node(const lattice_block *block, const int32_t cell[3], bool center)
{
    lattice_node node;
    for (int axis = 0; axis < 3; ++axis) {
        node.at[axis] = 2 * (block->first_cell[axis] + cell[axis]) + (center ? 1 : 0);
    }
    node.value = center ? block->centers[cell[2]][cell[1]][cell[0]] : block->corners[cell[2]][cell[1]][cell[0]];
    return node;
}

/* The four tetrahedra around the face between a cell and its neighbor along axis. */
static void emit_face(polygonizer *work, const lattice_block *block, const int32_t cell[3], int axis)
{
    /* Counter-clockwise around the axis. */
    static const int32_t ring[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    int32_t beyond[3] = {cell[0], cell[1], cell[2]};
    beyond[axis] += 1;
    const lattice_node here = block_node(block, cell, true);
    const lattice_node there = block_node(block, beyond, true);
    lattice_node corners[4];
    int inside_count = (here.value < 0) + (there.value < 0);
    for (int k = 0; k < 4; ++k) {
        int32_t corner[3] = {beyond[0], beyond[1], beyond[2]};
        corner[(axis + 1) % 3] += ring[k][0];
        corner[(axis + 2) % 3] += ring[k][1];
        corners[k] = block_node(block, corner, false);
        inside_count += corners[k].value < 0;
    }
    if (inside_count == 0 || inside_count == 6) {
        return;
    }
    for (int k = 0; k < 4; ++k) {
        const lattice_node *const nodes[4] = {&here, &there, &corners[k], &corners[(k + 1) % 4]};
        emit_tetrahedron(work, nodes);
    }
}

static bool block_may_cross(const polygonizer *work, const int32_t first_cell[3])
{
    int32_t middle[3];
    for (int axis = 0; axis < 3; ++axis) {
        middle[axis] = 2 * first_cell[axis] + BLOCK_NODES;
    }
    /* Half the diagonal of everything the block evaluates, rounded up. */
    const double reach = 0.87 * BLOCK_NODES * work->cell_width;
    return fabs(field_at(work, node_position(work, middle))) <= work->solid->steepness * reach;
}

static void evaluate_block(const polygonizer *work, lattice_block *block)
{
    for (int32_t z = 0; z < BLOCK_NODES; ++z) {
        for (int32_t y = 0; y < BLOCK_NODES; ++y) {
            for (int32_t x = 0; x < BLOCK_NODES; ++x) {
                const int32_t cell[3] = {x, y, z};
                const lattice_node corner = block_node(block, cell, false);
                const lattice_node center = block_node(block, cell, true);
                block->corners[z][y][x] = field_at(work, node_position(work, corner.at));
                block->centers[z][y][x] = field_at(work, node_position(work, center.at));
            }
        }
    }
}

static void polygonize_block(polygonizer *work, lattice_block *block)
{
    evaluate_block(work, block);
    for (int32_t z = 0; z < BLOCK_CELLS; ++z) {
        for (int32_t y = 0; y < BLOCK_CELLS; ++y) {
            for (int32_t x = 0; x < BLOCK_CELLS; ++x) {
                const int32_t cell[3] = {x, y, z};
                for (int axis = 0; axis < 3; ++axis) {
                    emit_face(work, block, cell, axis);
                }
            }
        }
    }
}

void polygonize(scene_builder *builder, const implicit_solid *solid, double cell_width)
{
    polygonizer work = {.builder = builder, .solid = solid, .cell_width = cell_width};
    /* The lattice's outermost half cell is not filled with tetrahedra: leave a cell around the box. */
    work.origin = vector_subtract(solid->low, vector(cell_width, cell_width, cell_width));
    const vector3 extent = vector_subtract(solid->high, work.origin);

    const int32_t cells_x = (int32_t)(extent.x / cell_width) + 2;
    const int32_t cells_y = (int32_t)(extent.y / cell_width) + 2;
    const int32_t cells_z = (int32_t)(extent.z / cell_width) + 2;
    lattice_block block;
    for (int32_t z = 0; z < cells_z; z += BLOCK_CELLS) {
        for (int32_t y = 0; y < cells_y; y += BLOCK_CELLS) {
            for (int32_t x = 0; x < cells_x && !builder->out_of_memory; x += BLOCK_CELLS) {
                const int32_t first_cell[3] = {x, y, z};
                if (block_may_cross(&work, first_cell)) {
                    memcpy(block.first_cell, first_cell, sizeof first_cell);
                    polygonize_block(&work, &block);
                }
            }
        }
    }
    free(work.edges.keys);
    free(work.edges.vertices);
}

void polygonize_to_count(scene_builder *builder, const implicit_solid *solid, uint32_t triangles)
{
    /* The count grows with the inverse square of the cell width. Large counts are extrapolated from a smaller trial
       by this rule, small ones are searched for. */
    const double wanted = triangles;
    const double trial = wanted < 200000 ? wanted : 200000;
    double cell_width = clamp_to(8.4 / sqrt(trial), 0, CELL_WIDTH_MAX);
    double best_width = cell_width;
    double best_error = HUGE_VAL;
    for (int attempt = 0; attempt < 8 && best_error > 0.01 * trial; ++attempt) {
        scene_builder counter = {.counting = true};
        polygonize(&counter, solid, cell_width);
        const double count = (double)counter.triangle_count;
        if (fabs(count - trial) < best_error) {
            best_error = fabs(count - trial);
            best_width = cell_width;
        }
        cell_width = clamp_to(cell_width * sqrt(count / trial), 0.5 * cell_width, CELL_WIDTH_MAX);
    }
    polygonize(builder, solid, best_width * sqrt(trial / wanted));
}
