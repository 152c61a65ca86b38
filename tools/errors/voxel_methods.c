/* SPDX-License-Identifier: MIT */
/* Times all ways in turns, then compares what each of them found. */
#include "errors/voxel_methods.h"

#include <stdlib.h>
#include <string.h>

#include "measure/threads.h"
#include "measure/interleave.h"
#include "support/input.h"
#include "support/tree_check.h"

#define TRIANGLES_AT_A_TIME 256u

typedef struct voxel_bench voxel_bench;

/* One way to be timed. */
typedef struct voxel_way {
    voxel_bench *bench;
    svo_frontend *frontend; /* NULL: a float way */
    float_way floats;
    float_list lists[CREW_MAX]; /* of the last round, one per thread */
} voxel_way;

struct voxel_bench {
    error_run *run;
    const svo_mesh *mesh;
    unsigned depth;
    svo_plan_options plan_options;
    svo_plan *plan; /* of the nodes alone */
    svo_tree *tree; /* with lists: the geometry that the float ways read */
    svo_tree_info info;
    svo_tree_arrays arrays;
    oracle_pairs expected[2]; /* by coverage */
    voxel_way ways[VOXEL_WAYS_MAX];
    size_t way_count;
};

const char *voxel_way_name(float_way way)
{
    static const char *const names[FLOAT_WAY_COUNT] = {"float32 test, world coordinates", "float32 test, box-centred",
                                                       "plain rasterization", "4x multisampling", "expansion alone"};
    return names[way];
}

static const char *frontend_way_name(const svo_frontend *frontend)
{
    static const char *const names[][2] = {
        {"cl", "exact integers, cl"}, {"gl-expand", "exact integers, gl-expand"}, {"gl-hw", "exact integers, gl-hw"}};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        if (strcmp(names[i][0], svo_frontend_name(frontend)) == 0) {
            return names[i][1];
        }
    }
    return "exact integers";
}

/* ---- times ---- */

static void list_portion(void *user, unsigned member, size_t begin, size_t end)
{
    voxel_way *way = user;
    float_way_list(way->floats, &way->bench->info, &way->bench->arrays, begin, end, &way->lists[member]);
}

static void release_lists(voxel_way *way)
{
    for (size_t i = 0; i < CREW_MAX; ++i) {
        free(way->lists[i].pairs);
        way->lists[i] = (float_list){0};
    }
}

static double run_floats(void *user)
{
    voxel_way *way = user;
    for (size_t i = 0; i < CREW_MAX; ++i) {
        way->lists[i].count = 0; /* the room stays: growing it is not what is measured */
    }
    const double started_ms = input_now_ms();
    crew_run(way->bench->run->threads, (size_t)way->bench->info.list_triangle_count, TRIANGLES_AT_A_TIME, list_portion,
             way);
    const double ms = input_now_ms() - started_ms;
    bool failed = false;
    for (size_t i = 0; i < CREW_MAX; ++i) {
        failed = failed || way->lists[i].failed;
    }
    return failed ? -1.0 : ms;
}

static double run_frontend(void *user)
{
    const voxel_way *way = user;
    const voxel_bench *bench = way->bench;
    svo_build_report report = {.struct_size = sizeof report};
    svo_tree *tree = NULL;
    const svo_status status = svo_build(bench->plan, way->frontend, bench->run->opened.queue, &tree, &report);
    svo_tree_destroy(&tree);
    return status == SVO_OK ? report.stages[SVO_STAGE_VOXELIZE].ms : -1.0;
}

static void add_way(voxel_bench *bench, svo_frontend *frontend, float_way floats)
{
    bench->ways[bench->way_count++] = (voxel_way){.bench = bench, .frontend = frontend, .floats = floats};
}

static void list_ways(voxel_bench *bench)
{
    const session *opened = &bench->run->opened;
    if (opened->cl != NULL) {
        add_way(bench, opened->cl, FLOAT_WAY_COUNT);
    }
    if (opened->frontend != opened->cl) {
        add_way(bench, opened->frontend, FLOAT_WAY_COUNT);
    }
    static const float_way order[FLOAT_WAY_COUNT] = {FLOAT_CENTRED, FLOAT_PLANES, FLOAT_EXPANDED, FLOAT_SAMPLES,
                                                     FLOAT_PIXELS};
    for (size_t i = 0; i < FLOAT_WAY_COUNT; ++i) {
        add_way(bench, NULL, order[i]);
    }
}

static bool measure(voxel_bench *bench, voxel_way_result *results)
{
    turn turns[VOXEL_WAYS_MAX];
    for (size_t i = 0; i < bench->way_count; ++i) {
        voxel_way *way = &bench->ways[i];
        turns[i] = (turn){.work_ms = way->frontend != NULL ? run_frontend : run_floats, .user = way};
    }
    const bool worked = turns_measure(turns, bench->way_count, bench->run->rounds);
    for (size_t i = 0; i < bench->way_count && worked; ++i) {
        results[i].ms = turns[i].median_ms;
    }
    return worked;
}

/* ---- errors ---- */

/* What the way found, in order. */
static bool float_pairs(voxel_way *way, oracle_pairs *out)
{
    float_list all = {0};
    for (size_t i = 0; i < CREW_MAX; ++i) {
        all.capacity += way->lists[i].count;
    }
    all.pairs = malloc(all.capacity * sizeof *all.pairs + 1);
    all.failed = all.pairs == NULL;
    for (size_t i = 0; i < CREW_MAX && !all.failed; ++i) {
        memcpy(all.pairs + all.count, way->lists[i].pairs, way->lists[i].count * sizeof *all.pairs);
        all.count += way->lists[i].count;
    }
    release_lists(way);
    return float_way_sort(&all, out);
}

static bool frontend_pairs(const voxel_bench *bench, svo_frontend *frontend, oracle_pairs *out)
{
    svo_plan_options with_lists = bench->plan_options;
    with_lists.need = SVO_NEED_RAYS;
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    svo_tree_info info;
    svo_tree_arrays arrays;
    uint64_t empty_leaf_count = 0;
    bool worked = svo_plan_create(bench->run->opened.device, bench->mesh, bench->depth, &with_lists, &plan) == SVO_OK &&
                  svo_build(plan, frontend, bench->run->opened.queue, &tree, NULL) == SVO_OK &&
                  svo_tree_download(tree, bench->run->opened.queue) == SVO_OK;
    if (worked) {
        svo_tree_get_info(tree, &info);
        svo_tree_get_arrays(tree, &arrays);
        worked = tree_check_list_pairs(&info, &arrays, out, &empty_leaf_count) && empty_leaf_count == 0;
    }
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    return worked;
}

static bool compare(voxel_bench *bench, voxel_way *way, voxel_way_result *result)
{
    const bool exact = way->frontend != NULL;
    const oracle_coverage coverage = exact ? ORACLE_HALF_OPEN : float_way_coverage(way->floats);
    const oracle_pairs *expected = &bench->expected[coverage];
    oracle_pairs found = {0};
    oracle_difference difference;
    if (!(exact ? frontend_pairs(bench, way->frontend, &found) : float_pairs(way, &found))) {
        return false;
    }
    oracle_compare(expected, &found, &difference);
    oracle_pairs_free(&found);
    result->way = exact ? frontend_way_name(way->frontend) : voxel_way_name(way->floats);
    result->target = coverage == ORACLE_CLOSED ? "closed" : "half-open";
    result->voxels = oracle_pairs_voxel_count(expected);
    result->pairs = expected->count;
    result->missed_voxels = difference.missed_voxels;
    result->surplus_voxels = difference.surplus_voxels;
    result->missed_pairs = difference.missed_pairs;
    result->surplus_pairs = difference.surplus_pairs;
    return true;
}

/* ---- all of it ---- */

/* The plan that is timed, the geometry, and the exact sets. */
static bool prepare(voxel_bench *bench)
{
    const session *opened = &bench->run->opened;
    svo_plan_options with_lists = bench->plan_options;
    svo_plan *plan = NULL;
    with_lists.need = SVO_NEED_RAYS;
    bool worked =
        svo_plan_create(opened->device, bench->mesh, bench->depth, &bench->plan_options, &bench->plan) == SVO_OK &&
        svo_plan_create(opened->device, bench->mesh, bench->depth, &with_lists, &plan) == SVO_OK &&
        svo_build(plan, opened->frontend, opened->queue, &bench->tree, NULL) == SVO_OK &&
        svo_tree_download(bench->tree, opened->queue) == SVO_OK;
    svo_plan_destroy(&plan);
    if (!worked) {
        return false;
    }
    svo_tree_get_info(bench->tree, &bench->info);
    svo_tree_get_arrays(bench->tree, &bench->arrays);
    const oracle_mesh mesh = {bench->arrays.vertices, bench->arrays.indices, bench->arrays.triangle_ids,
                              (size_t)bench->info.list_triangle_count};
    for (int coverage = ORACLE_HALF_OPEN; coverage <= ORACLE_CLOSED && worked; ++coverage) {
        const oracle_request request = {bench->depth, bench->info.snap_bits, (oracle_coverage)coverage, ORACLE_SAT};
        worked = oracle_enumerate(&mesh, &request, &bench->expected[coverage]);
    }
    return worked;
}

int voxel_ways_measure(error_run *run, const svo_mesh *mesh, unsigned depth, double edge, voxel_way_result *results,
                       size_t *result_count)
{
    voxel_bench *bench = calloc(1, sizeof *bench);
    if (bench == NULL) {
        return errors_fail(run);
    }
    bench->run = run;
    bench->mesh = mesh;
    bench->depth = depth;
    bench->plan_options =
        (svo_plan_options){.struct_size = sizeof bench->plan_options, .need = (uint32_t)SVO_NEED_NONE, .edge = edge};
    list_ways(bench);
    bool worked = prepare(bench) && measure(bench, results);
    for (size_t i = 0; i < bench->way_count; ++i) {
        worked = worked && compare(bench, &bench->ways[i], &results[i]);
        release_lists(&bench->ways[i]);
    }
    *result_count = bench->way_count;
    oracle_pairs_free(&bench->expected[ORACLE_HALF_OPEN]);
    oracle_pairs_free(&bench->expected[ORACLE_CLOSED]);
    svo_tree_destroy(&bench->tree);
    svo_plan_destroy(&bench->plan);
    free(bench);
    return worked ? PROGRAM_DONE : errors_fail(run);
}

double voxel_way_error(const voxel_way_result *result)
{
    return result->voxels > 0 ? (double)(result->missed_voxels + result->surplus_voxels) / (double)result->voxels : 0.0;
}
