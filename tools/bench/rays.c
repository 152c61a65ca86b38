/* SPDX-License-Identifier: MIT */
/*
 * svocl bench rays: millions of rays per second against the triangles of a tree, interleaved with Embree's
 * rtcIntersect1 on as many threads, for the same rays and the same snapped triangles; or with a grid of the tree's leaf
 * lists on the same device.
 *
 * The mesh is snapped to integers before the build, so that grid units are world units and both libraries get the same
 * bits for every vertex and every ray.
 */
#include "bench/rays.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "bench/grid_rays.h"
#include "measure/embree.h"
#include "measure/quantization.h"
#include "measure/ray_judge.h"
#include "measure/ray_sets.h"
#include "measure/spread.h"
#include "support/job.h"
#include "support/json.h"
#include "support/options_parse.h"
#include "support/table.h"

#define DEFAULT_INPUT   "scene:statue:120000"
#define QUICK_INPUT     "scene:knot:8000"
#define DEFAULT_REPEATS 7u
#define QUICK_REPEATS   3u

/* One set of rays, and its results. */
typedef struct ray_set {
    const char *name;
    svo_ray *rays;
    spread ours_ms, theirs_ms, ratio; /* ratio: the other's time to svocl's, within each round; none without it */
    ray_verdict verdict;
} ray_set;

#define SET_COUNT 2

typedef struct ray_bench {
    program *state;
    job work;
    svo_mesh snapped; /* the input with integer coordinates */
    float *positions;
    embree *peer; /* NULL: not asked for */
    grid_rays *grid; /* the same */
    unsigned threads;
    size_t ray_count, repeats;
    svo_hit *ours, *theirs;
    cl_mem device_rays, device_hits, grid_hits;
    ray_set sets[SET_COUNT];
} ray_bench;

/* ---- the scene ---- */

/* Quantizes coordinates to integers 0 .. 2^20 - 1. Coordinates that are not finite stay so, and the build refuses their
   triangles. */
static int snap_mesh(ray_bench *bench)
{
    const svo_mesh *mesh = bench->work.source.mesh;
    bench->positions = quantization_positions(mesh);
    if (bench->positions == NULL) {
        return program_fail(bench->state, PROGRAM_FAILED, "out of memory for %zu vertices", mesh->vertex_count);
    }
    bench->snapped = quantization_mesh(mesh, bench->positions);
    bench->work.source.mesh = &bench->snapped;
    return PROGRAM_DONE;
}

static cl_mem make_buffer(const ray_bench *bench, size_t bytes)
{
    cl_int error = CL_SUCCESS;
    return clCreateBuffer(svo_device_cl_context(bench->work.opened.device), CL_MEM_READ_WRITE, bytes, NULL, &error);
}

/* Embree's copy of the triangles that the tree holds. */
static int open_peer(ray_bench *bench)
{
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    const svo_tree_info *info = &bench->work.result.info;
    svo_tree_get_arrays(bench->work.result.tree, &arrays);
    float *vertices = calloc((size_t)info->vertex_count * 3 + 1, sizeof *vertices);
    if (vertices != NULL) {
        for (size_t i = 0; i < (size_t)info->vertex_count * 3; ++i) {
            vertices[i] = (float)arrays.vertices[i];
        }
        bench->peer = embree_create(vertices, (size_t)info->vertex_count, arrays.indices,
                                    (size_t)info->list_triangle_count, false);
    }
    free(vertices);
    return bench->peer != NULL ? PROGRAM_DONE
                               : program_fail(bench->state, PROGRAM_FAILED, "Embree cannot take the triangles");
}

static int open_grid(ray_bench *bench)
{
    const uint32_t depth = bench->work.result.info.depth;
    if (depth > GRID_RAYS_DEPTH_MAX) {
        return program_fail(bench->state, PROGRAM_WRONG_USAGE, "--vs grid takes depths up to %d, not %u",
                            GRID_RAYS_DEPTH_MAX, depth);
    }
    bench->grid = grid_rays_create(&bench->work.opened, bench->work.result.tree);
    bench->grid_hits = make_buffer(bench, bench->ray_count * sizeof(svo_hit));
    return bench->grid != NULL && bench->grid_hits != NULL
               ? PROGRAM_DONE
               : program_fail(bench->state, PROGRAM_FAILED, "the grid cannot be made: no memory, or no kernel");
}

/* Opens what --vs asks for. */
static int open_rival(ray_bench *bench)
{
    const int versus = bench->state->options.versus;
    return versus == OPTION_VERSUS_EMBREE ? open_peer(bench)
           : versus == OPTION_VERSUS_GRID ? open_grid(bench)
                                          : PROGRAM_DONE;
}

static bool is_compared(const ray_bench *bench)
{
    return bench->peer != NULL || bench->grid != NULL;
}

/* ---- rays ---- */

static int make_rays(ray_bench *bench)
{
    static const char *const names[SET_COUNT] = {"primary", "incoherent"};
    const size_t count = bench->ray_count;
    const svo_tree *tree = bench->work.result.tree;
    svo_camera camera;
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL};
    double high[3] = {0, 0, 0};
    for (size_t i = 0; i < bench->snapped.vertex_count * 3; ++i) {
        const double at = (double)bench->positions[i];
        low[i % 3] = isfinite(at) ? fmin(low[i % 3], at) : low[i % 3];
        high[i % 3] = isfinite(at) ? fmax(high[i % 3], at) : high[i % 3];
    }
    bool there = true;
    for (int k = 0; k < SET_COUNT; ++k) {
        bench->sets[k].name = names[k];
        bench->sets[k].rays = calloc(count, sizeof(svo_ray));
        there = there && bench->sets[k].rays != NULL;
    }
    bench->ours = calloc(count, sizeof(svo_hit));
    bench->theirs = calloc(count, sizeof(svo_hit));
    bench->device_rays = make_buffer(bench, count * sizeof(svo_ray));
    bench->device_hits = make_buffer(bench, count * sizeof(svo_hit));
    if (!there || bench->ours == NULL || bench->theirs == NULL || bench->device_rays == NULL ||
        bench->device_hits == NULL) {
        return program_fail(bench->state, PROGRAM_FAILED, "out of memory for %zu rays", count);
    }
    svo_camera_frame(tree, 1.0f, &camera);
    ray_set_primary(&camera, count, bench->sets[0].rays);
    ray_set_incoherent(low, high, count, bench->sets[1].rays);
    return PROGRAM_DONE;
}

/* ---- measuring ---- */

/* One pass of svocl, from the call to completion; below 0 on failure. */
static double trace_ours(ray_bench *bench)
{
    const session *opened = &bench->work.opened;
    cl_event event = NULL;
    const double start_ms = input_now_ms();
    if (svo_tree_trace_enqueue(bench->work.result.tree, bench->device_rays, bench->device_hits, bench->ray_count,
                               SVO_TRACE_CLOSEST, opened->queue, 0, NULL, &event) != SVO_OK) {
        return -1.0;
    }
    const cl_int error = clWaitForEvents(1, &event);
    const double ms = input_now_ms() - start_ms;
    clReleaseEvent(event);
    return error == CL_SUCCESS ? ms : -1.0;
}

/* The same of the other tracer; 0 without one. */
static double trace_theirs(ray_bench *bench, const ray_set *set)
{
    return bench->peer != NULL   ? embree_trace(bench->peer, set->rays, bench->theirs, bench->ray_count, bench->threads)
           : bench->grid != NULL ? grid_rays_trace(bench->grid, bench->device_rays, bench->grid_hits, bench->ray_count)
                                 : 0.0;
}

/* Reads back the hits of what ran on the device. */
static bool read_hits(ray_bench *bench)
{
    const size_t bytes = bench->ray_count * sizeof(svo_hit);
    cl_command_queue queue = bench->work.opened.queue;
    return clEnqueueReadBuffer(queue, bench->device_hits, CL_TRUE, 0, bytes, bench->ours, 0, NULL, NULL) ==
               CL_SUCCESS &&
           (bench->grid == NULL || clEnqueueReadBuffer(queue, bench->grid_hits, CL_TRUE, 0, bytes, bench->theirs, 0,
                                                       NULL, NULL) == CL_SUCCESS);
}

/* Interleaves both; the first round warms up and does not count. */
static int measure_set(ray_bench *bench, ray_set *set)
{
    const size_t bytes = bench->ray_count * sizeof(svo_ray);
    cl_command_queue queue = bench->work.opened.queue;
    double *times = calloc(3 * bench->repeats, sizeof *times);
    bool worked = times != NULL && clEnqueueWriteBuffer(queue, bench->device_rays, CL_TRUE, 0, bytes, set->rays, 0,
                                                        NULL, NULL) == CL_SUCCESS;
    for (size_t round = 0; round <= bench->repeats && worked; ++round) {
        const double ours = trace_ours(bench);
        const double theirs = trace_theirs(bench, set);
        worked = ours >= 0 && theirs >= 0;
        if (round > 0) {
            times[round - 1] = ours;
            times[bench->repeats + round - 1] = theirs;
            times[2 * bench->repeats + round - 1] = theirs / ours;
        }
    }
    worked = worked && read_hits(bench);
    if (worked) {
        const bool compared = is_compared(bench);
        set->ours_ms = spread_of(times, bench->repeats);
        set->theirs_ms = compared ? spread_of(times + bench->repeats, bench->repeats) : spread_none();
        set->ratio = compared ? spread_of(times + 2 * bench->repeats, bench->repeats) : spread_none();
    }
    free(times);
    return worked ? PROGRAM_DONE : program_fail_library(bench->state, svo_device_message(bench->work.opened.device));
}

static void judge_set(ray_bench *bench, ray_set *set)
{
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    const svo_tree_info *info = &bench->work.result.info;
    svo_tree_get_arrays(bench->work.result.tree, &arrays);
    const oracle_ray_scene snapped = {.vertices = arrays.vertices,
                                      .indices = arrays.indices,
                                      .triangle_count = (size_t)info->list_triangle_count,
                                      .origin = {info->origin[0], info->origin[1], info->origin[2]},
                                      .scale = info->scale};
    if (is_compared(bench)) { /* its indices do not count refused triangles */
        for (size_t i = 0; i < bench->ray_count; ++i) {
            const uint32_t triangle = bench->theirs[i].triangle;
            bench->theirs[i].triangle = triangle != SVO_NO_TRIANGLE ? arrays.triangle_ids[triangle] : triangle;
        }
    }
    set->verdict = ray_judge(&snapped, arrays.triangle_ids, set->rays, bench->ours,
                             is_compared(bench) ? bench->theirs : NULL, bench->ray_count);
}

/* ---- reporting ---- */

static double mrays(const ray_bench *bench, double ms)
{
    return ms > 0 ? (double)bench->ray_count / ms * 1e-3 : 0.0;
}

/* What --vs names. */
static const char *rival_name(const ray_bench *bench)
{
    return bench->peer != NULL ? "embree" : bench->grid != NULL ? "grid" : NULL;
}

static void add_rival_number(cJSON *to, const ray_bench *bench, const char *name, double number)
{
    char key[32];
    (void)snprintf(key, sizeof key, "%s_%s", rival_name(bench), name);
    cJSON_AddNumberToObject(to, key, number);
}

static cJSON *set_to_json(const ray_bench *bench, const ray_set *set)
{
    cJSON *one = cJSON_CreateObject();
    json_add_text(one, "name", set->name);
    json_add_count(one, "rays", bench->ray_count);
    json_add_count(one, "hits", set->verdict.hits);
    cJSON_AddNumberToObject(one, "leaves_per_ray", set->verdict.leaves);
    cJSON_AddNumberToObject(one, "ours_mrays", mrays(bench, set->ours_ms.median));
    if (is_compared(bench)) {
        add_rival_number(one, bench, "mrays", mrays(bench, set->theirs_ms.median));
        cJSON_AddNumberToObject(one, "ratio", set->ratio.median);
        json_add_count(one, "wrong_ids", set->verdict.wrong_ids);
        json_add_count(one, "missed", set->verdict.missed);
        json_add_count(one, "differing", set->verdict.differing);
        json_add_count(one, "tied", set->verdict.tied);
        add_rival_number(one, bench, "wrong_ids", (double)set->verdict.their_wrong_ids);
        add_rival_number(one, bench, "missed", (double)set->verdict.their_missed);
    }
    return one;
}

static cJSON *to_json(const ray_bench *bench)
{
    cJSON *document = json_document();
    json_add_text(document, "input", bench->work.source.name);
    job_add_what_ran(document, &bench->work);
    json_add_count(document, "triangles", bench->work.result.info.list_triangle_count);
    json_add_count(document, "threads", bench->threads);
    json_add_count(document, "repeats", bench->repeats);
    json_add_text(document, "vs", rival_name(bench));
    json_add_text(document, "embree_version", bench->peer != NULL ? embree_version(bench->peer) : NULL);
    json_add_count(document, "ours_bytes", svo_tree_ray_bytes(bench->work.result.tree));
    if (bench->grid != NULL) {
        json_add_count(document, "grid_bytes", grid_rays_bytes(bench->grid));
        json_add_count(document, "grid_cell_bytes", grid_rays_cell_bytes(bench->grid));
    }
    cJSON *sets = cJSON_AddArrayToObject(document, "sets");
    for (int k = 0; k < SET_COUNT; ++k) {
        cJSON_AddItemToArray(sets, set_to_json(bench, &bench->sets[k]));
    }
    return document;
}

static void print_table(const ray_bench *bench)
{
    progress_hide(bench->state->progress);
    table_line("%s: %s triangles at depth %u, %s rays per set, medians of %zu rounds", bench->work.source.name,
               figure_count(bench->work.result.info.list_triangle_count).text, bench->work.result.info.depth,
               figure_count(bench->ray_count).text, bench->repeats);
    if (bench->grid != NULL) {
        table_line("svocl's BVH %s; grid %s, of which bricks and cells %s",
                   figure_bytes(svo_tree_ray_bytes(bench->work.result.tree)).text,
                   figure_bytes(grid_rays_bytes(bench->grid)).text,
                   figure_bytes(grid_rays_cell_bytes(bench->grid)).text);
    }
    table *rows = table_create("lrrrrrrr");
    const bool has_grid = bench->grid != NULL;
    const char *const heads[] = {"rays",
                                 "svocl",
                                 has_grid ? "grid" : "Embree",
                                 "ratio",
                                 "differing",
                                 "tied",
                                 "wrong",
                                 has_grid ? "grid wrong" : "Embree wrong"};
    for (size_t i = 0; i < sizeof heads / sizeof heads[0]; ++i) {
        table_cell(rows, "%s", heads[i]);
    }
    for (int k = 0; k < SET_COUNT; ++k) {
        const ray_set *set = &bench->sets[k];
        const bool compared = is_compared(bench);
        table_cell(rows, "%s", set->name);
        table_cell(rows, "%s", figure_rate(mrays(bench, set->ours_ms.median) * 1e6).text);
        table_cell(rows, "%s", compared ? figure_rate(mrays(bench, set->theirs_ms.median) * 1e6).text : "");
        if (compared) {
            table_cell(rows, "%.2f", set->ratio.median);
        } else {
            table_cell(rows, "%s", "");
        }
        table_cell(rows, "%zu", set->verdict.differing);
        table_cell(rows, "%zu", set->verdict.tied);
        table_cell(rows, "%zu", set->verdict.wrong_ids + set->verdict.missed);
        table_cell(rows, "%zu", set->verdict.their_wrong_ids + set->verdict.their_missed);
    }
    table_print(rows);
}

/* ---- the command ---- */

static unsigned count_threads(const options *given)
{
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    return given->threads != 0 ? (unsigned)given->threads : online > 0 ? (unsigned)online : 1;
}

/* What the bench owns by then is released by release(). */
static int prepare(ray_bench *bench)
{
    program *state = bench->state;
    int exit_code = input_open(state, &bench->work.source);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = session_open(state, &bench->work.opened);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = snap_mesh(bench);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = job_build(state, SVO_NEED_RAYS, &bench->work);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = open_rival(bench);
    return exit_code != PROGRAM_DONE ? exit_code : make_rays(bench);
}

static int run_bench(ray_bench *bench)
{
    int exit_code = prepare(bench);
    for (int k = 0; k < SET_COUNT && exit_code == PROGRAM_DONE; ++k) {
        progress_step(bench->state->progress, "tracing rays");
        exit_code = measure_set(bench, &bench->sets[k]);
        if (exit_code == PROGRAM_DONE) {
            judge_set(bench, &bench->sets[k]);
        }
    }
    return exit_code;
}

static void release(ray_bench *bench)
{
    for (int k = 0; k < SET_COUNT; ++k) {
        free(bench->sets[k].rays);
    }
    if (bench->device_rays != NULL) {
        clReleaseMemObject(bench->device_rays);
    }
    if (bench->device_hits != NULL) {
        clReleaseMemObject(bench->device_hits);
    }
    if (bench->grid_hits != NULL) {
        clReleaseMemObject(bench->grid_hits);
    }
    free(bench->ours);
    free(bench->theirs);
    grid_rays_destroy(&bench->grid);
    embree_destroy(&bench->peer);
    job_release(&bench->work);
    free(bench->positions);
}

/* Saves, and prints as JSON or as a table. */
static int show(const ray_bench *bench)
{
    const options *given = &bench->state->options;
    cJSON *document = to_json(bench);
    if (given->output_path != NULL) {
        const int exit_code = json_save(bench->state, given->output_path, document);
        if (exit_code != PROGRAM_DONE) {
            cJSON_Delete(document);
            return exit_code;
        }
    }
    if (given->json) {
        return json_print(bench->state, document);
    }
    cJSON_Delete(document);
    if (given->output_path == NULL || !given->quiet) {
        print_table(bench);
    }
    return PROGRAM_DONE;
}

int bench_rays_alone(program *state)
{
    options *given = &state->options;
    if (given->versus == OPTION_VERSUS_OPENVDB) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "option --vs openvdb does not apply to bench rays");
    }
    if (given->versus == OPTION_VERSUS_EMBREE && !embree_is_there()) {
        return program_fail(state, PROGRAM_FAILED, "--vs embree: this program was built without libembree-dev");
    }
    given->input = given->input != NULL ? given->input : given->quick ? QUICK_INPUT : DEFAULT_INPUT;
    ray_bench bench = {.state = state,
                       .threads = count_threads(given),
                       .ray_count = (size_t)given->ray_count,
                       .repeats = given->has_repeat ? (size_t)given->repeat
                                  : given->quick    ? QUICK_REPEATS
                                                    : DEFAULT_REPEATS};
    given->repeat = 1; /* builds */
    given->depth_for_rays = !given->has_depth;
    program_begin_progress(state, 3 + SET_COUNT);
    int exit_code = run_bench(&bench);
    if (exit_code == PROGRAM_DONE) {
        exit_code = show(&bench);
    }
    release(&bench);
    return exit_code;
}

/* ---- the subject ---- */

static const char table_id[] = "rays";

static const char note[] =
    "Wall clock, on the snapped mesh. Embree: rtcIntersect1, interleaved with svocl, on as many threads. Ratio: "
    "svocl's rays per second to Embree's, within each round. Wrong: another triangle than the reference, or none.";

static int begin(suite *all)
{
    result_table *results = suite_add_table(all, table_id, "Rays against triangles, closest hit", note);
    if (!embree_is_there()) {
        result_extend_note(results, "Without Embree: this program was built without libembree-dev.");
    }
    result_add_column(results, "scene", "");
    result_add_column(results, "triangles", "");
    result_add_column(results, "depth", "");
    result_add_column(results, "rays", "");
    result_add_column(results, "count", "");
    result_add_column(results, "hits", "");
    spread_add_columns(results, "svocl time", "ms");
    result_add_column(results, "svocl", "M/s");
    spread_add_columns(results, "Embree time", "ms");
    result_add_column(results, "Embree", "M/s");
    spread_add_columns(results, "ratio", "");
    result_add_column(results, "wrong", "");
    result_add_column(results, "Embree wrong", "");
    return PROGRAM_DONE;
}

static void add_row(result_table *results, const ray_bench *bench, const ray_set *set)
{
    const bool compared = bench->peer != NULL;
    result_add_text(results, "%s", suite_scene_name(&bench->work.source));
    result_add_number(results, (double)bench->work.result.info.list_triangle_count);
    result_add_number(results, bench->work.result.info.depth);
    result_add_text(results, "%s", set->name);
    result_add_number(results, (double)bench->ray_count);
    result_add_number(results, (double)set->verdict.hits);
    spread_add(results, set->ours_ms);
    result_add_number(results, mrays(bench, set->ours_ms.median));
    spread_add(results, set->theirs_ms);
    result_add_number(results, compared ? mrays(bench, set->theirs_ms.median) : (double)NAN);
    spread_add(results, set->ratio);
    result_add_number(results, compared ? (double)(set->verdict.wrong_ids + set->verdict.missed) : (double)NAN);
    result_add_number(results,
                      compared ? (double)(set->verdict.their_wrong_ids + set->verdict.their_missed) : (double)NAN);
}

/* Opens a device handle of its own and reads the input again, because the mesh is snapped. */
static int run(suite *all, const input *source, unsigned depth)
{
    options *given = &all->state->options;
    const options before = *given;
    given->input = source->name;
    given->frontend = options_ask_for_gl(given) ? given->frontend : OPTION_FRONTEND_CL;
    given->repeat = 1; /* builds */
    given->depth_for_rays = depth == SUITE_DEPTH_FOR_RAYS;
    given->depth = given->depth_for_rays ? OPTION_DEFAULT_DEPTH : depth;
    given->versus = embree_is_there() ? OPTION_VERSUS_EMBREE : 0;
    ray_bench bench = {.state = all->state,
                       .threads = count_threads(given),
                       .ray_count = (size_t)given->ray_count,
                       .repeats = all->repeats};
    progress_hold(all->state->progress, true);
    const int exit_code = run_bench(&bench);
    progress_hold(all->state->progress, false);
    for (int k = 0; k < SET_COUNT && exit_code == PROGRAM_DONE; ++k) {
        add_row(result_find(all->results, table_id), &bench, &bench.sets[k]);
    }
    release(&bench);
    *given = before;
    return exit_code;
}

const suite_subject bench_rays = {
    .name = "rays",
    .group = "all",
    .summary = "rays against triangles, compared with Embree",
    .full = {.scenes = {"statue:120000", "atrium"}, .depths = {SUITE_DEPTH_FOR_RAYS}},
    .quick = {.scenes = {"knot:8000"}, .depths = {SUITE_DEPTH_FOR_RAYS}},
    .begin = begin,
    .run = run,
};
