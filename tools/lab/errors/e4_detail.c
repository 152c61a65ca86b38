/* SPDX-License-Identifier: MIT */
/*
 * E4: errors of a level of detail (distance of its voxels from the surface, area and enclosed volume), with the time
 * and memory that it takes. A flood fill from outside finds the enclosed voxels: half-open voxels are 6-separating, so
 * it stays outside a closed surface.
 */
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "errors/errors.h"
#include "errors/subjects.h"
#include "measure/spread.h"
#include "reference/oracle.h"
#include "support/info_of.h"
#include "support/input.h"
#include "support/session.h"

/* ---- what is measured ---- */

typedef struct detail_reference {
    svo_tree *tree; /* with lists, at the ray depth */
    double area, volume; /* of the snapped mesh, in double: world units */
} detail_reference;

typedef struct detail_measures {
    double distance; /* the largest from a voxel's center to the surface: world units */
    double area_by_fill, area_by_faces, volume; /* world units */
} detail_measures;

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

static void detail_reference_free(detail_reference *made)
{
    svo_tree_destroy(&made->tree);
}

/* mesh: closed, its triangles facing outwards. Returns false with nothing to release. */
static bool detail_reference_create(const session *opened, const svo_mesh *mesh, detail_reference *out)
{
    const svo_plan_options for_rays = {.struct_size = sizeof for_rays, .need = SVO_NEED_RAYS};
    svo_plan *plan = NULL;
    *out = (detail_reference){0};
    bool worked = svo_plan_create(opened->device, mesh, 6, &for_rays, &plan) == SVO_OK;
    if (worked) {
        const unsigned depth = info_of_plan(plan).ray_depth;
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
    worked = worked && svo_tree_nearest(reference->tree, svo_in_host(points), svo_in_host(nearest), count,
                                        &(svo_submit){.queue = queue}) == SVO_OK;
    out->distance = 0.0;
    for (size_t leaf = 0; leaf < count && worked; ++leaf) {
        out->distance = fmax(out->distance, (double)nearest[leaf].distance);
    }
    free(points);
    free(nearest);
    return worked;
}

/* tree: of the same mesh, downloaded, with fill. */
static bool detail_measure(const detail_reference *reference, const svo_tree *tree, cl_command_queue queue,
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

/* ---- the subject ---- */

#define FIRST_DEPTH 3u

static result_table *begin_table(error_run *run)
{
    result_table *table = result_add_table(run->results, "e4-detail", "E4: level of detail", "");
    result_set_note(
        table,
        "One closed scene at each depth. Distance: the largest distance of a voxel center from the surface (one-sided "
        "Hausdorff distance), found by svo_tree_nearest; the surface never leaves its voxels. Area, compared with the "
        "mesh: the sum of the leaves' fill, and the common estimate from the number of outer voxel faces. Volume, "
        "compared with the mesh: the enclosed voxels, with those of the surface counted half. Distances in %% are "
        "relative to the edge of the grid. Time: plan and build of nodes and fill. Size: nodes and fill. %s.",
        run->rounds_note);
    result_add_column(table, "scene", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "voxels", "");
    result_add_column(table, "size", "B");
    result_add_column(table, "time", "ms");
    result_add_column(table, "distance of centers, largest", "voxels");
    result_add_column(table, "distance of centers", "%");
    result_add_column(table, "area by fill, error", "%");
    result_add_column(table, "area by faces, error", "%");
    result_add_column(table, "volume, error", "%");
    return table;
}

typedef struct detail_build {
    error_run *run;
    const svo_mesh *mesh;
    unsigned depth;
    svo_tree *tree;
} detail_build;

static double build_once(void *user)
{
    detail_build *work = user;
    const session *opened = &work->run->opened;
    const svo_plan_options plan_options = {.struct_size = sizeof plan_options, .need = SVO_NEED_FILL};
    svo_plan *plan = NULL;
    svo_tree_destroy(&work->tree);
    const double started_ms = input_now_ms();
    const bool worked =
        svo_plan_create(opened->device, work->mesh, work->depth, &plan_options, &plan) == SVO_OK &&
        svo_build(plan, opened->cl != NULL ? opened->cl : opened->frontend, opened->queue, &work->tree, NULL) == SVO_OK;
    const double ms = input_now_ms() - started_ms;
    svo_plan_destroy(&plan);
    return worked ? ms : -1.0;
}

static double percent_off(double measured, double exact)
{
    return exact > 0.0 ? 100.0 * fabs(measured - exact) / exact : NAN;
}

static int add_depth(error_run *run, result_table *table, const char *name, const detail_reference *reference,
                     const svo_mesh *mesh, unsigned depth)
{
    detail_build work = {.run = run, .mesh = mesh, .depth = depth};
    interleaved_method building = {.work_ms = build_once, .user = &work};
    detail_measures found;
    bool worked = interleave_measure(&building, 1, run->rounds) &&
                  svo_tree_download(work.tree, run->opened.queue) == SVO_OK &&
                  detail_measure(reference, work.tree, run->opened.queue, &found);
    if (worked) {
        svo_tree_info info = SVO_TREE_INFO_INIT;
        svo_tree_get_info(work.tree, &info);
        const double voxel = info.edge / (double)(1u << depth);
        result_add_text(table, "%s", name);
        result_add_number(table, depth);
        result_add_number(table, (double)info.leaf_count);
        result_add_number(table, (double)(info.inner_count * 5 + info.node_count * 2));
        result_add_number(table, building.median_ms);
        result_add_number(table, found.distance / voxel);
        result_add_number(table, 100.0 * found.distance / info.edge);
        result_add_number(table, percent_off(found.area_by_fill, reference->area));
        result_add_number(table, percent_off(found.area_by_faces, reference->area));
        result_add_number(table, percent_off(found.volume, reference->volume));
    }
    svo_tree_destroy(&work.tree);
    return worked ? PROGRAM_DONE : errors_fail(run);
}

static int measure_scene(error_run *run, result_table *table, const error_scene *given, unsigned last_depth)
{
    detail_reference reference;
    suite_input made = {.text = ""};
    int exit_code = suite_open(run->state, given->spec, &made);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    progress_step(run->state->progress, "E4: level of detail");
    const svo_mesh *mesh = made.source.mesh;
    exit_code = detail_reference_create(&run->opened, mesh, &reference) ? PROGRAM_DONE : errors_fail(run);
    for (unsigned depth = FIRST_DEPTH; depth <= last_depth && exit_code == PROGRAM_DONE; ++depth) {
        exit_code = add_depth(run, table, errors_scene_name(given, &made.source), &reference, mesh, depth);
    }
    detail_reference_free(&reference);
    input_close(&made.source);
    return exit_code;
}

static int measure(error_run *run)
{
    const error_scene own[] = {{"knot", run->quick ? "knot:20000" : "knot:100000"},
                               {"statue", run->quick ? "statue:20000" : "statue:120000"},
                               {NULL, NULL}};
    result_table *table = begin_table(run);
    int exit_code = PROGRAM_DONE;
    error_scene given = errors_scene_at(run, own, 0);
    for (size_t i = 1; given.spec != NULL && exit_code == PROGRAM_DONE; given = errors_scene_at(run, own, i++)) {
        exit_code = measure_scene(run, table, &given, run->quick ? 8 : 9);
    }
    return exit_code;
}

static int run_all(suite *all)
{
    error_run run = errors_begin(all);
    return measure(&run);
}

const suite_subject errors_detail = {
    .words = &subject_table[SUBJECT_E4],
    .run_all = run_all,
    .takes_scenes = true,
    .step_count = 2,
};
