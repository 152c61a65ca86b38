/* SPDX-License-Identifier: MIT */
/*
 * Updates of a scene of which a share moves to and fro, beside full builds of the same vertices. After each update,
 * too: the objects' BVHs made ready, a BVH of the whole mesh made anew, the same rays through both.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/moving_scene.h"
#include "bench/subjects.h"
#include "measure/ray_sets.h"
#include "measure/spread.h"
#include "measure/suite.h"

/* ---- rays ---- */

#define RAY_COUNT ((size_t)1 << 18)

static const char rays_id[] = "moving-rays";

/* What is timed: the BVH of the objects, BVHs of the whole mesh, and two sets of rays through the first two. */
enum { OBJECTS, WHOLE, WHOLE_FAST, RAYS_RATIO, PRIMARY, WHOLE_PRIMARY, INCOHERENT, WHOLE_INCOHERENT, RAYS_TIME_COUNT };

static const char rays_note[] =
    "Moved: the share of the triangles; they are one object, which moves by half a voxel. Objects: svo_moving_make_bvh "
    "after an update, which refits that object. Whole: svo_tree_make_bvh of the same mesh, best; whole fast: in that "
    "quality. Ratio: of objects to whole within a round. Rays: the first hits of 262,144 rays, host arrays, through "
    "the BVH of the objects and through that of the whole mesh, interleaved; all hits are compared.";

/* Adds the table. */
static void moving_rays_begin(suite *all)
{
    result_table *table = suite_add_table(all, rays_id, "Scenes that move: rays", rays_note);
    result_add_column(table, "scene", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "triangles", "");
    result_add_column(table, "moved", "%");
    spread_add_columns(table, "objects", "ms");
    spread_add_columns(table, "whole", "ms");
    spread_add_columns(table, "whole fast", "ms");
    spread_add_columns(table, "ratio", "");
    result_add_column(table, "primary", "M/s");
    result_add_column(table, "whole primary", "M/s");
    result_add_column(table, "incoherent", "M/s");
    result_add_column(table, "whole incoherent", "M/s");
}

typedef struct rays_run {
    suite *all;
    unsigned depth;
    moving_scene scene;
    svo_ray *primary, *incoherent;
    svo_hit *hits, *whole_hits;
    double *times[RAYS_TIME_COUNT]; /* of the rounds */
} rays_run;

static int fail_rays(const rays_run *run)
{
    return program_fail_library(run->all->state, svo_device_message(run->all->opened.device));
}

/* The milliseconds of a batch; below 0: it failed. */
static double trace_ms(const rays_run *run, svo_tree *tree, const svo_ray *rays, svo_hit *hits)
{
    const double start_ms = input_now_ms();
    const svo_status status =
        svo_trace_triangles(svo_tree_target(tree), svo_in_host(rays), svo_in_host(hits), RAY_COUNT, SVO_TRACE_CLOSEST,
                            &(svo_submit){.queue = run->all->opened.queue});
    return status == SVO_OK ? input_now_ms() - start_ms : -1.0;
}

/* Hits without the leaves that were visited. */
static bool are_equal(const rays_run *run)
{
    for (size_t i = 0; i < RAY_COUNT; ++i) {
        if (memcmp(&run->hits[i], &run->whole_hits[i], offsetof(svo_hit, count)) != 0) {
            return false;
        }
    }
    return true;
}

/* The same rays through both. */
static int run_set(const rays_run *run, svo_tree *whole, const svo_ray *rays, double *ms, double *whole_ms)
{
    *ms = trace_ms(run, svo_moving_tree(run->scene.moving), rays, run->hits);
    *whole_ms = trace_ms(run, whole, rays, run->whole_hits);
    if (*ms < 0.0 || *whole_ms < 0.0) {
        return fail_rays(run);
    }
    return are_equal(run) ? PROGRAM_DONE
                          : program_fail(run->all->state, PROGRAM_FAILED,
                                         "hits of the objects' BVHs are not those of the BVH of the whole mesh");
}

/* The milliseconds of a BVH of the whole mesh; below 0: it failed. */
static double make_whole(const rays_run *run, svo_tree *whole, svo_bvh_quality quality)
{
    const double start_ms = input_now_ms();
    const svo_status status = svo_tree_make_bvh(whole, quality, run->all->opened.queue);
    return status == SVO_OK ? input_now_ms() - start_ms : -1.0;
}

static int measure_whole(const rays_run *run, svo_tree *whole, double *times)
{
    times[WHOLE_FAST] = make_whole(run, whole, SVO_BVH_FAST);
    times[WHOLE] = make_whole(run, whole, SVO_BVH_BEST);
    times[RAYS_RATIO] = times[OBJECTS] / times[WHOLE];
    int exit_code = times[WHOLE_FAST] < 0.0 || times[WHOLE] < 0.0 ? fail_rays(run) : PROGRAM_DONE;
    if (exit_code == PROGRAM_DONE) {
        exit_code = run_set(run, whole, run->primary, &times[PRIMARY], &times[WHOLE_PRIMARY]);
    }
    return exit_code == PROGRAM_DONE
               ? run_set(run, whole, run->incoherent, &times[INCOHERENT], &times[WHOLE_INCOHERENT])
               : exit_code;
}

static int run_round(rays_run *run, size_t round, double *times)
{
    const session *opened = &run->all->opened;
    svo_moving_bvh_report report = SVO_MOVING_BVH_REPORT_INIT;
    svo_tree *whole = NULL;
    if (!moving_scene_update(&run->scene, round, NULL) ||
        svo_moving_make_bvh(run->scene.moving, SVO_BVH_BEST, 0.0F, opened->queue, &report) != SVO_OK ||
        !moving_scene_build(&run->scene, opened->device, opened->cl, run->depth, opened->queue, &whole)) {
        return fail_rays(run);
    }
    times[OBJECTS] = report.total_ms;
    const int exit_code = measure_whole(run, whole, times);
    svo_tree_destroy(&whole);
    return exit_code;
}

/* The first two rounds, there and back, are not counted. */
static int run_ray_rounds(rays_run *run)
{
    int exit_code = PROGRAM_DONE;
    for (size_t round = 0; round < run->all->repeats + 2 && exit_code == PROGRAM_DONE; ++round) {
        double times[RAYS_TIME_COUNT] = {0.0};
        exit_code = run_round(run, round, times);
        for (size_t i = 0; i < (round >= 2 && exit_code == PROGRAM_DONE ? RAYS_TIME_COUNT : 0); ++i) {
            run->times[i][round - 2] = times[i];
        }
    }
    return exit_code;
}

static int open_scene(rays_run *run)
{
    const svo_moving_options *grid = &run->scene.options;
    svo_camera camera = {.vertical_fov = 0};
    double high[3];
    run->scene.options.need = SVO_NEED_RAYS;
    if (!moving_scene_open(run->all->opened.device, run->depth, run->all->opened.queue, &run->scene)) {
        return fail_rays(run);
    }
    for (int axis = 0; axis < 3; ++axis) {
        high[axis] = grid->origin[axis] + grid->edge;
    }
    if (svo_camera_fit(svo_tree_target(svo_moving_tree(run->scene.moving)), 1.0F, &camera) != SVO_OK) {
        return fail_rays(run);
    }
    ray_set_primary(&camera, 1, RAY_COUNT, run->primary);
    ray_set_incoherent(grid->origin, high, RAY_COUNT, run->incoherent);
    return PROGRAM_DONE;
}

static void add_rays_row(rays_run *run, const input *source)
{
    const double triangles = (double)source->mesh->triangle_count;
    result_table *table = result_find(run->all->results, rays_id);
    result_add_text(table, "%s", suite_scene_name(source));
    result_add_number(table, run->depth);
    result_add_number(table, triangles);
    result_add_number(table, 100.0 * (double)run->scene.object.triangle_count / triangles);
    for (int i = OBJECTS; i <= RAYS_RATIO; ++i) {
        spread_add(table, spread_of(run->times[i], run->all->repeats));
    }
    for (int i = PRIMARY; i < RAYS_TIME_COUNT; ++i) {
        const double ms = spread_of(run->times[i], run->all->repeats).median;
        result_add_number(table, (double)RAY_COUNT / (ms * 1e3));
    }
}

static bool allocate(rays_run *run, double **times)
{
    *times = malloc(RAYS_TIME_COUNT * (run->all->repeats + 1) * sizeof **times);
    run->primary = malloc(RAY_COUNT * sizeof *run->primary);
    run->incoherent = malloc(RAY_COUNT * sizeof *run->incoherent);
    run->hits = malloc(RAY_COUNT * sizeof *run->hits);
    run->whole_hits = malloc(RAY_COUNT * sizeof *run->whole_hits);
    for (size_t i = 0; *times != NULL && i < RAYS_TIME_COUNT; ++i) {
        run->times[i] = *times + i * (run->all->repeats + 1);
    }
    return *times != NULL && run->primary != NULL && run->incoherent != NULL && run->hits != NULL &&
           run->whole_hits != NULL;
}

/* Measures a scene of which a share of the area moves, and adds its row. */
static int moving_rays_run(suite *all, const input *source, unsigned depth, double share)
{
    rays_run run = {.all = all, .depth = depth};
    double *times = NULL;
    const bool is_cut = moving_scene_cut(source->mesh, share, depth, &run.scene);
    int exit_code = allocate(&run, &times) && is_cut
                        ? open_scene(&run)
                        : program_fail(all->state, PROGRAM_FAILED, "out of memory for %zu rays", RAY_COUNT);
    exit_code = exit_code == PROGRAM_DONE ? run_ray_rounds(&run) : exit_code;
    if (exit_code == PROGRAM_DONE) {
        add_rays_row(&run, source);
    }
    moving_scene_release(&run.scene);
    free(times);
    free(run.primary);
    free(run.incoherent);
    free(run.hits);
    free(run.whole_hits);
    return exit_code;
}

/* ---- updates ---- */

static const char table_id[] = "moving";

/* Shares of the area that moves, and so about of the pairs. */
static const double shares[] = {0.001, 0.01, 0.1, 1.0};
#define SHARE_COUNT (sizeof shares / sizeof shares[0])

/* What is timed: the stages of an update, all of it, a full build, and their ratio. */
enum { MOVE, VOXELIZE, WEIGH, MERGE, NODES, PAYLOAD, UPDATE, BUILD, RATIO, TIME_COUNT };

static const char note[] =
    "Colors and normals are weighted by area. Changed: the share of the (voxel, triangle) pairs that an update makes "
    "anew; the last triangles of the mesh are an object that moves by half a voxel. Columns of stages are medians, "
    "wall clock: vertices to the device, rounded and classified; pairs made and sorted; pairs weighed and sampled; "
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
    if (!moving_scene_update(&run->scene, round, &report)) {
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
