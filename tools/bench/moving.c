/* SPDX-License-Identifier: MIT */
/*
 * Updates of a scene of which a share moves, beside full builds of the same vertices. The last triangles of a mesh are
 * an object that moves to and fro, the others are the static mesh.
 */
#include "bench/moving.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "measure/spread.h"

static const char table_id[] = "moving";

/* Shares of the area that moves, and so about of the pairs. */
static const double shares[] = {0.001, 0.01, 0.1, 1.0};
#define SHARE_COUNT (sizeof shares / sizeof shares[0])

/* What is timed: the stages of an update, all of it, a full build, and their ratio. */
enum { MOVE, VOXELIZE, WEIGH, MERGE, NODES, PAYLOAD, UPDATE, BUILD, RATIO, TIME_COUNT };

static const char note[] =
    "Colors and normals are weighted by area. Changed: the share of the (voxel, triangle) pairs that an update makes "
    "anew; the last triangles of the mesh are an object that moves by half a voxel. Columns of stages are medians, "
    "wall clock: vertices to the device, snapped and classified; pairs made and sorted; pairs weighed and sampled; "
    "lists merged; nodes; payload. Build: plan and build of the same mesh, grid and unit of weight, after each update. "
    "Ratio: of the two within a round.";

static int begin(suite *all)
{
    static const char *const stages[] = {"move", "voxelize", "weigh", "merge", "nodes", "payload"};
    result_table *table = suite_add_table(all, table_id, "Scenes that move: updates beside full builds", note);
    result_add_column(table, "scene", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "pairs", "");
    result_add_column(table, "changed", "%");
    for (size_t i = 0; i < sizeof stages / sizeof stages[0]; ++i) {
        result_add_column(table, stages[i], "ms");
    }
    spread_add_columns(table, "update", "ms");
    spread_add_columns(table, "build", "ms");
    spread_add_columns(table, "ratio", "");
    return PROGRAM_DONE;
}

/* A scene of which a share moves. */
typedef struct moving_run {
    suite *all;
    unsigned depth;
    svo_mesh fixed, object; /* views of the scene's mesh */
    uint32_t *indices; /* owned; of the object */
    svo_moving_options options;
    svo_moving *moving;
    double step; /* world units that the object moves */
    double *times[TIME_COUNT]; /* of the rounds */
    double changed, pairs; /* of the last update */
} moving_run;

static int fail(const moving_run *run)
{
    return program_fail_library(run->all->state, svo_device_message(run->all->opened.device));
}

/* Leaves out vertices before and after those of the object. */
static bool cut_vertices(const svo_mesh *mesh, moving_run *run)
{
    const size_t corners = run->object.triangle_count * 3;
    const uint32_t *from = run->object.indices;
    uint32_t first = UINT32_MAX;
    uint32_t last = 0;
    run->indices = malloc((corners + 1) * sizeof *run->indices);
    for (size_t i = 0; i < corners; ++i) {
        first = from[i] < first ? from[i] : first;
        last = from[i] > last ? from[i] : last;
    }
    for (size_t i = 0; i < corners && run->indices != NULL; ++i) {
        run->indices[i] = from[i] - first;
    }
    svo_mesh *object = &run->object;
    object->indices = run->indices;
    object->vertex_count = last - first + 1;
    object->positions = mesh->positions != NULL ? mesh->positions + (size_t)first * 3 : NULL;
    object->positions_double = mesh->positions_double != NULL ? mesh->positions_double + (size_t)first * 3 : NULL;
    object->normals = mesh->normals != NULL ? mesh->normals + (size_t)first * 3 : NULL;
    object->colors = mesh->colors != NULL ? mesh->colors + (size_t)first * 4 : NULL;
    object->uvs = mesh->uvs != NULL ? mesh->uvs + (size_t)first * 2 : NULL;
    return run->indices != NULL;
}

static double coordinate(const svo_mesh *mesh, size_t vertex, int axis)
{
    const size_t at = vertex * 3 + (size_t)axis;
    return mesh->positions_double != NULL ? mesh->positions_double[at] : (double)mesh->positions[at];
}

static double area_of(const svo_mesh *mesh, size_t triangle)
{
    const uint32_t *corners = mesh->indices + triangle * 3;
    double squares = 0.0;
    for (int k = 0; k < 3; ++k) {
        double edges[2][2];
        for (int corner = 0; corner < 2; ++corner) {
            for (int axis = 0; axis < 2; ++axis) {
                const int at = (k + axis) % 3;
                edges[corner][axis] = coordinate(mesh, corners[corner + 1], at) - coordinate(mesh, corners[0], at);
            }
        }
        const double normal = edges[0][0] * edges[1][1] - edges[0][1] * edges[1][0];
        squares += normal * normal;
    }
    return 0.5 * sqrt(squares);
}

/* How many of the last triangles have a share of the area. */
static size_t count_moved(const svo_mesh *mesh, double share)
{
    const size_t triangles = mesh->triangle_count;
    double total = 0.0;
    double moved = 0.0;
    size_t count = 0;
    for (size_t t = 0; t < triangles; ++t) {
        total += area_of(mesh, t);
    }
    while (count + 1 < triangles && (count == 0 || moved < share * total)) {
        moved += area_of(mesh, triangles - ++count);
    }
    return count;
}

/* Cuts the mesh, which has indices, in two. */
static bool cut(const svo_mesh *mesh, double share, moving_run *run)
{
    const size_t triangles = mesh->triangle_count;
    const size_t moved = count_moved(mesh, share);
    run->fixed = *mesh;
    run->fixed.triangle_count = triangles - moved;
    run->object = *mesh;
    run->object.triangle_count = moved;
    run->object.indices = mesh->indices + (triangles - moved) * 3;
    if (mesh->triangle_materials != NULL) {
        run->object.triangle_materials = mesh->triangle_materials + (triangles - moved);
    }
    return cut_vertices(mesh, run);
}

/* A cube around the mesh with some room. */
static void choose_grid(const svo_mesh *mesh, svo_moving_options *to)
{
    double low[3] = {INFINITY, INFINITY, INFINITY};
    double high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < mesh->vertex_count * 3; ++i) {
        const double x = coordinate(mesh, i / 3, (int)(i % 3));
        low[i % 3] = fmin(low[i % 3], x);
        high[i % 3] = fmax(high[i % 3], x);
    }
    to->edge = 1.02 * fmax(high[0] - low[0], fmax(high[1] - low[1], high[2] - low[2]));
    for (int k = 0; k < 3; ++k) {
        to->origin[k] = low[k] - 0.01 * to->edge;
    }
}

/* An update after the object has moved: there in odd rounds, back in even ones. */
static int run_update(moving_run *run, size_t round, double *times)
{
    const double shift = round % 2 != 0 ? run->step : 0.0;
    const double transform[12] = {1, 0, 0, shift, 0, 1, 0, shift, 0, 0, 1, shift};
    svo_moving_report report = SVO_MOVING_REPORT_INIT;
    if (svo_moving_set_transform(run->moving, 0, transform) != SVO_OK ||
        svo_moving_update(run->moving, run->all->opened.queue, &report) != SVO_OK) {
        return fail(run);
    }
    run->pairs = (double)report.fragments;
    run->changed = 50.0 * (double)report.changed_fragments / (double)report.fragments;
    times[MOVE] = report.move_ms;
    times[VOXELIZE] = report.voxelize_ms;
    times[WEIGH] = report.weigh_ms;
    times[MERGE] = report.merge_ms;
    times[NODES] = report.nodes_ms;
    times[PAYLOAD] = report.payload_ms;
    times[UPDATE] = report.total_ms;
    return PROGRAM_DONE;
}

/* A full build of the scene's mesh; its tree must be that of the update. */
static int run_build(moving_run *run, double *times)
{
    session *opened = &run->all->opened;
    svo_mesh mesh;
    svo_moving_info info = SVO_MOVING_INFO_INIT;
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    if (svo_moving_get_mesh(run->moving, &mesh) != SVO_OK || svo_moving_get_info(run->moving, &info) != SVO_OK) {
        return fail(run);
    }
    svo_plan_options pinned = {
        .struct_size = sizeof pinned, .need = info.need, .edge = run->options.edge, .weight_log2 = info.weight_log2};
    memcpy(pinned.origin, run->options.origin, sizeof pinned.origin);
    const double start_ms = input_now_ms();
    const bool built = svo_plan_create(opened->device, &mesh, run->depth, &pinned, &plan) == SVO_OK &&
                       svo_build(plan, opened->cl, opened->queue, &tree, NULL) == SVO_OK;
    times[BUILD] = input_now_ms() - start_ms;
    times[RATIO] = times[UPDATE] / times[BUILD];
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    return built ? PROGRAM_DONE : fail(run);
}

/* The first two rounds, there and back, are not counted. */
static int run_rounds(moving_run *run)
{
    int exit_code = PROGRAM_DONE;
    for (size_t round = 0; round < run->all->repeats + 2 && exit_code == PROGRAM_DONE; ++round) {
        double times[TIME_COUNT] = {0.0};
        exit_code = run_update(run, round, times);
        exit_code = exit_code == PROGRAM_DONE ? run_build(run, times) : exit_code;
        for (size_t i = 0; i < (round >= 2 && exit_code == PROGRAM_DONE ? TIME_COUNT : 0); ++i) {
            run->times[i][round - 2] = times[i];
        }
    }
    return exit_code;
}

static void add_row(moving_run *run, const input *source)
{
    result_table *table = result_find(run->all->results, table_id);
    result_add_text(table, "%s", suite_scene_name(source));
    result_add_number(table, run->depth);
    result_add_number(table, run->pairs);
    result_add_number(table, run->changed);
    for (size_t i = 0; i < UPDATE; ++i) {
        result_add_number(table, spread_of(run->times[i], run->all->repeats).median);
    }
    for (size_t i = UPDATE; i < TIME_COUNT; ++i) {
        spread_add(table, spread_of(run->times[i], run->all->repeats));
    }
}

static int open_scene(moving_run *run)
{
    uint32_t object = 0;
    return svo_moving_create(run->all->opened.device, &run->fixed, run->depth, &run->options, run->all->opened.queue,
                             &run->moving) == SVO_OK &&
                   svo_moving_add(run->moving, &run->object, NULL, &object) == SVO_OK
               ? PROGRAM_DONE
               : fail(run);
}

static int run_share(suite *all, const input *source, unsigned depth, double share)
{
    moving_run run = {.all = all, .depth = depth, .options = SVO_MOVING_OPTIONS_INIT};
    double *times = malloc(TIME_COUNT * (all->repeats + 1) * sizeof *times);
    int exit_code = PROGRAM_DONE;
    if (!cut(source->mesh, share, &run) || times == NULL) {
        free(run.indices);
        free(times);
        return program_fail(all->state, PROGRAM_FAILED, "out of memory for %zu times", all->repeats);
    }
    for (size_t i = 0; i < TIME_COUNT; ++i) {
        run.times[i] = times + i * (all->repeats + 1);
    }
    choose_grid(source->mesh, &run.options);
    run.options.need = SVO_NEED_COLOR | SVO_NEED_NORMAL;
    run.options.max_area = 1e3 * run.options.edge * run.options.edge;
    run.step = 0.5 * run.options.edge / (double)(1u << depth);
    exit_code = open_scene(&run);
    exit_code = exit_code == PROGRAM_DONE ? run_rounds(&run) : exit_code;
    if (exit_code == PROGRAM_DONE) {
        add_row(&run, source);
    }
    svo_moving_destroy(&run.moving);
    free(run.indices);
    free(times);
    return exit_code;
}

static int run(suite *all, const input *source, unsigned depth)
{
    int exit_code = PROGRAM_DONE;
    for (size_t i = 0; i < SHARE_COUNT && exit_code == PROGRAM_DONE; ++i) {
        exit_code = run_share(all, source, depth, shares[i]);
    }
    return exit_code;
}

const suite_subject bench_moving = {
    .name = "moving",
    .group = "all",
    .summary = "scenes that move: updates beside full builds",
    .full = {.scenes = {"atrium", "statue"}, .depths = {8, 9}},
    .quick = {.scenes = {"atrium:17000"}, .depths = {7}},
    .begin = begin,
    .run = run,
};
