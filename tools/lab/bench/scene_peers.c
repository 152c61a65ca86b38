/* SPDX-License-Identifier: MIT */
/* Makes the peers of `svocl bench scene`. */
#include "bench/scene_peers.h"

#include <stdlib.h>
#include <string.h>

/* ---- one tree ---- */

/* The mesh's vertices once for each copy, moved. */
static double *copy_positions(const lattice *of, unsigned edge)
{
    const size_t vertices = of->mesh->vertex_count;
    const size_t copies = (size_t)edge * edge * edge;
    double *positions = calloc(copies * vertices * 3 + 1, sizeof *positions);
    for (size_t i = 0; positions != NULL && i < copies * vertices * 3; ++i) {
        const size_t copy = i / (vertices * 3);
        const size_t cell[3] = {copy % edge, copy / edge % edge, copy / edge / edge};
        const size_t from = i % (vertices * 3);
        const double at =
            of->mesh->positions_double != NULL ? of->mesh->positions_double[from] : (double)of->mesh->positions[from];
        positions[i] = at + of->width * (double)cell[i % 3];
    }
    return positions;
}

static uint32_t *copy_indices(const lattice *of, unsigned edge)
{
    const size_t corners = of->mesh->triangle_count * 3;
    const size_t copies = (size_t)edge * edge * edge;
    uint32_t *indices = calloc(copies * corners + 1, sizeof *indices);
    for (size_t i = 0; indices != NULL && i < copies * corners; ++i) {
        const size_t from = i % corners;
        const size_t vertex = of->mesh->indices != NULL ? of->mesh->indices[from] : from;
        indices[i] = (uint32_t)(i / corners * of->mesh->vertex_count + vertex);
    }
    return indices;
}

static svo_tree *build_merged(const lattice *of, const svo_mesh *mesh, unsigned edge_log2)
{
    const session *opened = &of->all->opened;
    svo_plan_options asked = {
        .struct_size = sizeof asked, .need = SVO_NEED_NONE, .edge = of->width * (double)(1u << edge_log2)};
    svo_plan *plan = NULL;
    svo_tree *merged = NULL;
    memcpy(asked.origin, of->info.origin, sizeof asked.origin);
    if (svo_plan_create(opened->device, mesh, of->info.depth + edge_log2, &asked, &plan) == SVO_OK) {
        (void)svo_build(plan, opened->cl, opened->queue, &merged, NULL);
    }
    svo_plan_destroy(&plan);
    return merged;
}

svo_tree *lattice_merge(const lattice *of, unsigned edge_log2)
{
    const unsigned edge = 1u << edge_log2;
    const size_t copies = (size_t)edge * edge * edge;
    double *positions = copy_positions(of, edge);
    uint32_t *indices = copy_indices(of, edge);
    svo_tree *merged = NULL;
    if (positions != NULL && indices != NULL) {
        const svo_mesh mesh = {.struct_size = sizeof mesh,
                               .positions_double = positions,
                               .vertex_count = copies * of->mesh->vertex_count,
                               .indices = indices,
                               .triangle_count = copies * of->mesh->triangle_count};
        merged = build_merged(of, &mesh, edge_log2);
    }
    free(positions);
    free(indices);
    return merged;
}

/* ---- boxes ---- */

#define BOX_CORNERS   8
#define BOX_TRIANGLES 12

typedef struct boxes {
    const svo_tree_arrays *arrays;
    const svo_tree_info *info;
    double width; /* of a voxel */
    float *vertices;
    uint32_t *indices;
    size_t count;
} boxes;

/* Corner k has x, y and z high where bits 0, 1 and 2 are set. */
static void add_box(boxes *to, const uint32_t cell[3])
{
    static const uint32_t corners[3 * BOX_TRIANGLES] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                                        2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    for (uint32_t k = 0; k < BOX_CORNERS; ++k) {
        for (uint32_t axis = 0; axis < 3; ++axis) {
            const double at = to->info->origin[axis] + to->width * (double)(cell[axis] + (k >> axis & 1));
            to->vertices[(to->count * BOX_CORNERS + k) * 3 + axis] = (float)at;
        }
    }
    for (size_t k = 0; k < sizeof corners / sizeof corners[0]; ++k) {
        to->indices[to->count * 3 * BOX_TRIANGLES + k] = (uint32_t)(to->count * BOX_CORNERS) + corners[k];
    }
    ++to->count;
}

static void add_leaves(boxes *to, uint32_t node, uint32_t level, const uint32_t cell[3])
{
    if (level == to->info->depth) {
        add_box(to, cell);
        return;
    }
    uint32_t child = to->arrays->first_child[node];
    for (uint32_t octant = 0; octant < 8; ++octant) {
        if ((to->arrays->child_mask[node] >> octant & 1) != 0) {
            const uint32_t inner[3] = {2 * cell[0] + (octant & 1), 2 * cell[1] + (octant >> 1 & 1),
                                       2 * cell[2] + (octant >> 2)};
            add_leaves(to, child++, level + 1, inner);
        }
    }
}

embree *lattice_boxes(const lattice *of, const float (*matrices)[12], size_t matrix_count)
{
    const size_t leaves = (size_t)of->info.leaf_count;
    const uint32_t root[3] = {0, 0, 0};
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    svo_tree_get_arrays(of->tree, &arrays);
    boxes made = {.arrays = &arrays, .info = &of->info, .width = of->width / (double)(1u << of->info.depth)};
    embree *peer = NULL;
    made.vertices = calloc(leaves * BOX_CORNERS * 3 + 1, sizeof *made.vertices);
    made.indices = calloc(leaves * BOX_TRIANGLES * 3 + 1, sizeof *made.indices);
    if (made.vertices != NULL && made.indices != NULL && leaves > 0) {
        add_leaves(&made, 0, 0, root);
        peer = embree_create_placed(made.vertices, made.count * BOX_CORNERS, made.indices, made.count * BOX_TRIANGLES,
                                    matrices, matrix_count);
    }
    free(made.vertices);
    free(made.indices);
    return peer;
}
