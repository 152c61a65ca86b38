/* SPDX-License-Identifier: MIT */
/* A flood fill from outside finds the enclosed voxels: half-open voxels are 6-separating, so it stays outside a closed
   surface. */
#include "errors/detail_measures.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "reference/oracle.h"

#define FILL_OF_A_FACE 4096.0

/* ---- the mesh ---- */

/* Areas and signed tetrahedra over the origin of the grid. */
static void measure_mesh(const svo_tree_info *info, const svo_tree_arrays *arrays, detail_reference *out)
{
    double doubled_area = 0.0;
    double sixfold_volume = 0.0;
    for (size_t t = 0; t < (size_t)info->list_triangle_count; ++t) {
        double p[3][3];
        double n[3];
        for (size_t i = 0; i < 9; ++i) {
            p[i / 3][i % 3] = arrays->vertices[(size_t)arrays->indices[3 * t + i / 3] * 3 + i % 3] / info->scale;
        }
        for (int k = 0; k < 3; ++k) {
            const int u = (k + 1) % 3;
            const int v = (k + 2) % 3;
            n[k] = (p[1][u] - p[0][u]) * (p[2][v] - p[0][v]) - (p[1][v] - p[0][v]) * (p[2][u] - p[0][u]);
        }
        doubled_area += sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        sixfold_volume += p[0][0] * n[0] + p[0][1] * n[1] + p[0][2] * n[2];
    }
    out->area = doubled_area / 2.0;
    out->volume = fabs(sixfold_volume) / 6.0;
}

bool detail_reference_create(const session *opened, const svo_mesh *mesh, detail_reference *out)
{
    const svo_plan_options for_rays = {.struct_size = sizeof for_rays, .need = SVO_NEED_RAYS};
    svo_plan *plan = NULL;
    *out = (detail_reference){0};
    bool worked = svo_plan_create(opened->device, mesh, 6, &for_rays, &plan) == SVO_OK;
    if (worked) {
        const unsigned depth = svo_plan_ray_depth(plan);
        svo_plan_destroy(&plan);
        worked = svo_plan_create(opened->device, mesh, depth, &for_rays, &plan) == SVO_OK &&
                 svo_build(plan, opened->frontend, opened->queue, &out->tree, NULL) == SVO_OK &&
                 svo_tree_download(out->tree, opened->queue) == SVO_OK;
    }
    svo_plan_destroy(&plan);
    if (!worked) {
        detail_reference_free(out);
        return false;
    }
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    svo_tree_get_info(out->tree, &info);
    svo_tree_get_arrays(out->tree, &arrays);
    measure_mesh(&info, &arrays, out);
    return true;
}

void detail_reference_free(detail_reference *made)
{
    svo_tree_destroy(&made->tree);
}

/* ---- voxels ---- */

typedef struct cells {
    uint8_t *states; /* CELL_*, x fastest */
    size_t width; /* of the grid and a border of one cell on every side */
    uint32_t *stack;
} cells;

enum { CELL_UNSEEN = 0, CELL_SURFACE, CELL_OUTSIDE };

static size_t cell_of(const cells *grid, const oracle_box *box)
{
    const size_t x = (size_t)(box->corner[0] / box->width) + 1;
    const size_t y = (size_t)(box->corner[1] / box->width) + 1;
    const size_t z = (size_t)(box->corner[2] / box->width) + 1;
    return (z * grid->width + y) * grid->width + x;
}

/* From the border inwards; a cell is on the stack at most once. */
static void flood(const cells *grid)
{
    const size_t steps[3] = {1, grid->width, grid->width * grid->width};
    const size_t count = steps[2] * grid->width;
    size_t height = 1;
    grid->stack[0] = 0;
    grid->states[0] = CELL_OUTSIDE;
    while (height > 0) {
        const size_t cell = grid->stack[--height];
        for (int side = 0; side < 6; ++side) {
            const size_t step = steps[side / 2];
            const bool there = side % 2 == 0 ? cell + step < count : cell >= step;
            const size_t next = side % 2 == 0 ? cell + step : cell - step;
            if (there && grid->states[next] == CELL_UNSEEN) {
                grid->states[next] = CELL_OUTSIDE;
                grid->stack[height++] = (uint32_t)next;
            }
        }
    }
}

/* Faces: those of surface cells towards the outside, the common estimate of the area. */
static void count_cells(const cells *grid, double *inside, double *surface, double *faces)
{
    const size_t steps[3] = {1, grid->width, grid->width * grid->width};
    const size_t count = steps[2] * grid->width;
    *inside = *surface = *faces = 0.0;
    for (size_t cell = 0; cell < count; ++cell) {
        const uint8_t state = grid->states[cell];
        *inside += state == CELL_UNSEEN;
        *surface += state == CELL_SURFACE;
        for (int axis = 0; axis < 3 && state == CELL_SURFACE; ++axis) {
            *faces += grid->states[cell + steps[axis]] == CELL_OUTSIDE;
            *faces += grid->states[cell - steps[axis]] == CELL_OUTSIDE;
        }
    }
}

static bool measure_cells(const svo_tree_info *info, const uint64_t *codes, detail_measures *out)
{
    const double voxel = info->edge / (double)(1u << info->depth);
    cells grid = {.width = ((size_t)1 << info->depth) + 2};
    const size_t count = grid.width * grid.width * grid.width;
    double inside = 0.0;
    double surface = 0.0;
    double faces = 0.0;
    grid.states = calloc(count, 1);
    grid.stack = calloc(count, sizeof *grid.stack);
    const bool worked = grid.states != NULL && grid.stack != NULL;
    if (worked) {
        for (uint64_t leaf = 0; leaf < info->leaf_count; ++leaf) {
            oracle_box box;
            oracle_voxel_box(codes[leaf], info->depth, info->snap_bits, &box);
            grid.states[cell_of(&grid, &box)] = CELL_SURFACE;
        }
        flood(&grid);
        count_cells(&grid, &inside, &surface, &faces);
        out->volume = (inside + surface / 2.0) * voxel * voxel * voxel;
        out->area_by_faces = faces * voxel * voxel;
    }
    free(grid.states);
    free(grid.stack);
    return worked;
}

/* The nearest triangle to every voxel's center. */
static bool measure_distance(const detail_reference *reference, const svo_tree_info *info, const uint64_t *codes,
                             cl_command_queue queue, detail_measures *out)
{
    const size_t count = (size_t)info->leaf_count;
    svo_query_point *points = calloc(count + 1, sizeof *points);
    svo_nearest *nearest = calloc(count + 1, sizeof *nearest);
    bool worked = points != NULL && nearest != NULL;
    for (size_t leaf = 0; leaf < count && worked; ++leaf) {
        oracle_box box;
        oracle_voxel_box(codes[leaf], info->depth, info->snap_bits, &box);
        points[leaf].max_distance = INFINITY;
        for (int k = 0; k < 3; ++k) {
            points[leaf].position[k] =
                (float)(info->origin[k] + ((double)box.corner[k] + (double)box.width / 2.0) / info->scale);
        }
    }
    worked = worked && svo_tree_nearest(reference->tree, points, nearest, count, queue) == SVO_OK;
    out->distance = 0.0;
    for (size_t leaf = 0; leaf < count && worked; ++leaf) {
        out->distance = fmax(out->distance, (double)nearest[leaf].distance);
    }
    free(points);
    free(nearest);
    return worked;
}

bool detail_measure(const detail_reference *reference, const svo_tree *tree, cl_command_queue queue,
                    detail_measures *out)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    svo_tree_get_info(tree, &info);
    svo_tree_get_arrays(tree, &arrays);
    uint64_t *codes = calloc((size_t)info.leaf_count + 1, sizeof *codes);
    const double voxel = info.edge / (double)(1u << info.depth);
    *out = (detail_measures){0};
    const bool worked = codes != NULL &&
                        oracle_leaf_codes(arrays.child_mask, info.inner_count, info.depth, info.leaf_count, codes) &&
                        measure_cells(&info, codes, out) && measure_distance(reference, &info, codes, queue, out);
    for (uint64_t leaf = 0; leaf < info.leaf_count && worked; ++leaf) {
        out->area_by_fill += arrays.fills[info.inner_count + leaf] / FILL_OF_A_FACE * voxel * voxel;
    }
    free(codes);
    return worked;
}
