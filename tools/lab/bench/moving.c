/* SPDX-License-Identifier: MIT */
/* Updates of a scene of which a share moves to and fro, beside full builds of the same vertices. */
#include "bench/moving.h"

#include <stdlib.h>

#include "bench/moving_rays.h"
#include "bench/moving_scene.h"
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
    moving_rays_begin(all);
    return PROGRAM_DONE;
}

/* A scene of which a share moves. */
typedef struct moving_run {
    suite *all;
    unsigned depth;
    moving_scene scene;
    double *times[TIME_COUNT]; /* of the rounds */
    double changed, pairs; /* of the last update */
} moving_run;

static int fail(const moving_run *run)
{
    return program_fail_library(run->all->state, svo_device_message(run->all->opened.device));
}

/* An update after the object has moved: there in odd rounds, back in even ones. */
static int run_update(moving_run *run, size_t round, double *times)
{
    svo_moving_report report = SVO_MOVING_REPORT_INIT;
    if (!moving_scene_update(&run->scene, round, run->all->opened.queue, &report)) {
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
    svo_tree *tree = NULL;
    if (svo_moving_get_mesh(run->scene.moving, &mesh) != SVO_OK) { /* so that the time is without it */
        return fail(run);
    }
    const double start_ms = input_now_ms();
    const bool is_built = moving_scene_build(&run->scene, opened->device, opened->cl, run->depth, opened->queue, &tree);
    times[BUILD] = input_now_ms() - start_ms;
    times[RATIO] = times[UPDATE] / times[BUILD];
    svo_tree_destroy(&tree);
    return is_built ? PROGRAM_DONE : fail(run);
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

static int run_share(suite *all, const input *source, unsigned depth, double share)
{
    moving_run run = {.all = all, .depth = depth};
    double *times = malloc(TIME_COUNT * (all->repeats + 1) * sizeof *times);
    int exit_code = PROGRAM_DONE;
    if (!moving_scene_cut(source->mesh, share, depth, &run.scene) || times == NULL) {
        moving_scene_release(&run.scene);
        free(times);
        return program_fail(all->state, PROGRAM_FAILED, "out of memory for %zu times", all->repeats);
    }
    for (size_t i = 0; i < TIME_COUNT; ++i) {
        run.times[i] = times + i * (all->repeats + 1);
    }
    run.scene.options.need = SVO_NEED_COLOR | SVO_NEED_NORMAL;
    if (!moving_scene_open(all->opened.device, depth, all->opened.queue, &run.scene)) {
        exit_code = fail(&run);
    }
    exit_code = exit_code == PROGRAM_DONE ? run_rounds(&run) : exit_code;
    if (exit_code == PROGRAM_DONE) {
        add_row(&run, source);
    }
    moving_scene_release(&run.scene);
    free(times);
    return exit_code;
}

static int run(suite *all, const input *source, unsigned depth)
{
    int exit_code = PROGRAM_DONE;
    for (size_t i = 0; i < SHARE_COUNT && exit_code == PROGRAM_DONE; ++i) {
        exit_code = run_share(all, source, depth, shares[i]);
        exit_code = exit_code == PROGRAM_DONE ? moving_rays_run(all, source, depth, shares[i]) : exit_code;
    }
    return exit_code;
}

const suite_subject bench_moving = {
    .words = &subject_table[SUBJECT_MOVING],
    .full = {.scenes = {"atrium", "statue"}, .depths = {8, 9}},
    .quick = {.scenes = {"atrium:17000"}, .depths = {7}},
    .begin = begin,
    .run = run,
};
