/* SPDX-License-Identifier: MIT */
/* Times all methods interleaved, then compares their voxels with the exact ones. */
#include "errors/voxel_methods.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "measure/nearest_lists.h"
#include "measure/spread.h"
#include "measure/tree_check.h"
#include "path/threads.h"
#include "support/input.h"

#define TRIANGLES_PER_CHUNK 256u

typedef struct voxel_bench voxel_bench;

typedef enum voxel_method_kind { METHOD_FRONTEND = 0, METHOD_NEAREST, METHOD_FLOATS } voxel_method_kind;

typedef struct voxel_method {
    voxel_bench *bench;
    voxel_method_kind kind;
    svo_frontend *frontend; /* of METHOD_FRONTEND */
    float_method floats; /* of METHOD_FLOATS */
    float_list lists[THREADS_MAX]; /* of the last round, one per thread */
} voxel_method;

struct voxel_bench {
    error_run *run;
    const svo_mesh *mesh;
    unsigned depth;
    svo_plan_options plan_options;
    svo_plan *plan; /* of the nodes alone */
    svo_tree *tree; /* with lists: the geometry that the float32 methods read */
    svo_tree_info info;
    svo_tree_arrays arrays;
    oracle_pairs expected[2]; /* by coverage */
    voxel_method methods[VOXEL_METHODS_MAX];
    size_t method_count;
};

const char *voxel_method_name(float_method method)
{
    static const char *const names[FLOAT_METHOD_COUNT] = {"float32 test, world coordinates",
                                                          "float32 test, box-centered", "plain rasterization",
                                                          "4x multisampling", "expansion alone"};
    return names[method];
}

static const char *frontend_method_name(const svo_frontend *frontend)
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

static void list_chunk(void *user, unsigned thread_index, size_t begin, size_t end)
{
    voxel_method *method = user;
    float_method_list(method->floats, &method->bench->info, &method->bench->arrays, begin, end,
                      &method->lists[thread_index]);
}

static void release_lists(voxel_method *method)
{
    for (size_t i = 0; i < THREADS_MAX; ++i) {
        free(method->lists[i].pairs);
        method->lists[i] = (float_list){0};
    }
}

static double run_floats(void *user)
{
    voxel_method *method = user;
    for (size_t i = 0; i < THREADS_MAX; ++i) {
        method->lists[i].count = 0; /* keeps the memory: allocation is not measured */
    }
    const double started_ms = input_now_ms();
    threads_run(method->bench->run->threads, (size_t)method->bench->info.list_triangle_count, TRIANGLES_PER_CHUNK,
                list_chunk, method);
    const double ms = input_now_ms() - started_ms;
    bool failed = false;
    for (size_t i = 0; i < THREADS_MAX; ++i) {
        failed = failed || method->lists[i].failed;
    }
    return failed ? -1.0 : ms;
}

static double run_frontend(void *user)
{
    const voxel_method *method = user;
    const voxel_bench *bench = method->bench;
    svo_build_report report = {.struct_size = sizeof report};
    svo_tree *tree = NULL;
    const svo_status status = svo_build(bench->plan, method->frontend, bench->run->opened.queue, &tree, &report);
    svo_tree_destroy(&tree);
    return status == SVO_OK ? report.stage_times[SVO_STAGE_VOXELIZE].ms : -1.0;
}

static void add_method(voxel_bench *bench, voxel_method method)
{
    method.bench = bench;
    bench->methods[bench->method_count++] = method;
}

static void list_methods(voxel_bench *bench)
{
    const session *opened = &bench->run->opened;
    if (opened->cl != NULL) {
        add_method(bench, (voxel_method){.kind = METHOD_FRONTEND, .frontend = opened->cl});
    }
    if (opened->frontend != opened->cl) {
        add_method(bench, (voxel_method){.kind = METHOD_FRONTEND, .frontend = opened->frontend});
    }
    add_method(bench, (voxel_method){.kind = METHOD_NEAREST});
    static const float_method order[FLOAT_METHOD_COUNT] = {FLOAT_CENTERED, FLOAT_PLANES, FLOAT_EXPANDED, FLOAT_SAMPLES,
                                                           FLOAT_PIXELS};
    for (size_t i = 0; i < FLOAT_METHOD_COUNT; ++i) {
        add_method(bench, (voxel_method){.kind = METHOD_FLOATS, .floats = order[i]});
    }
}

static bool measure(voxel_bench *bench, voxel_method_result *results)
{
    interleaved_method timed[VOXEL_METHODS_MAX];
    size_t timed_count = 0;
    for (size_t i = 0; i < bench->method_count; ++i) {
        voxel_method *method = &bench->methods[i];
        if (method->kind != METHOD_NEAREST) {
            timed[timed_count++] = (interleaved_method){
                .work_ms = method->kind == METHOD_FRONTEND ? run_frontend : run_floats, .user = method};
        }
    }
    const bool worked = interleave_measure(timed, timed_count, bench->run->rounds);
    timed_count = 0;
    for (size_t i = 0; i < bench->method_count && worked; ++i) {
        const bool is_timed = bench->methods[i].kind != METHOD_NEAREST;
        results[i].ms = is_timed ? timed[timed_count++].median_ms : (double)NAN;
    }
    return worked;
}

/* ---- errors ---- */

/* The pairs of the last round, sorted. */
static bool float_pairs(voxel_method *method, oracle_pairs *out)
{
    float_list all = {0};
    for (size_t i = 0; i < THREADS_MAX; ++i) {
        all.capacity += method->lists[i].count;
    }
    all.pairs = malloc(all.capacity * sizeof *all.pairs + 1);
    all.failed = all.pairs == NULL;
    for (size_t i = 0; i < THREADS_MAX && !all.failed; ++i) {
        if (method->lists[i].count > 0) { /* else there may be no array */
            memcpy(all.pairs + all.count, method->lists[i].pairs, method->lists[i].count * sizeof *all.pairs);
            all.count += method->lists[i].count;
        }
    }
    release_lists(method);
    return float_method_sort(&all, out);
}

static bool frontend_pairs(const voxel_bench *bench, svo_frontend *frontend, oracle_pairs *out)
{
    svo_plan_options with_lists = bench->plan_options;
    with_lists.need = SVO_NEED_RAYS;
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
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

static bool method_pairs(const voxel_bench *bench, voxel_method *method, oracle_pairs *out)
{
    switch (method->kind) {
    case METHOD_FRONTEND:
        return frontend_pairs(bench, method->frontend, out);
    case METHOD_NEAREST:
        return nearest_list_pairs(bench->mesh, &bench->info, ORACLE_HALF_OPEN, out);
    default:
        return float_pairs(method, out);
    }
}

static const char *method_name(const voxel_method *method)
{
    switch (method->kind) {
    case METHOD_FRONTEND:
        return frontend_method_name(method->frontend);
    case METHOD_NEAREST:
        return "integers of 20 bits (as until 0.1)";
    default:
        return voxel_method_name(method->floats);
    }
}

static bool compare(voxel_bench *bench, voxel_method *method, voxel_method_result *result)
{
    const oracle_coverage coverage =
        method->kind == METHOD_FLOATS ? float_method_coverage(method->floats) : ORACLE_HALF_OPEN;
    const oracle_pairs *expected = &bench->expected[coverage];
    oracle_pairs found = {0};
    oracle_difference difference;
    if (!method_pairs(bench, method, &found)) {
        return false;
    }
    oracle_compare(expected, &found, &difference);
    oracle_pairs_free(&found);
    result->method = method_name(method);
    result->coverage = coverage == ORACLE_CLOSED ? "closed" : "half-open";
    result->voxels = oracle_pairs_voxel_count(expected);
    result->pairs = expected->count;
    result->missed_voxels = difference.missed_voxels;
    result->surplus_voxels = difference.surplus_voxels;
    result->missed_pairs = difference.missed_pairs;
    result->surplus_pairs = difference.surplus_pairs;
    return true;
}

/* ---- the measurement ---- */

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
    bench->info = (svo_tree_info)SVO_TREE_INFO_INIT;
    svo_tree_get_info(bench->tree, &bench->info);
    bench->arrays = (svo_tree_arrays)SVO_TREE_ARRAYS_INIT;
    svo_tree_get_arrays(bench->tree, &bench->arrays);
    for (int coverage = ORACLE_HALF_OPEN; coverage <= ORACLE_CLOSED && worked; ++coverage) {
        worked = mesh_list_pairs(bench->mesh, &bench->info, (oracle_coverage)coverage, &bench->expected[coverage]);
    }
    return worked;
}

int voxel_methods_measure(error_run *run, const svo_mesh *mesh, unsigned depth, double edge,
                          voxel_method_result *results, size_t *result_count)
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
    list_methods(bench);
    bool worked = prepare(bench) && measure(bench, results);
    for (size_t i = 0; i < bench->method_count; ++i) {
        worked = worked && compare(bench, &bench->methods[i], &results[i]);
        release_lists(&bench->methods[i]);
    }
    *result_count = bench->method_count;
    oracle_pairs_free(&bench->expected[ORACLE_HALF_OPEN]);
    oracle_pairs_free(&bench->expected[ORACLE_CLOSED]);
    svo_tree_destroy(&bench->tree);
    svo_plan_destroy(&bench->plan);
    free(bench);
    return worked ? PROGRAM_DONE : errors_fail(run);
}

double voxel_method_error(const voxel_method_result *result)
{
    return result->voxels > 0 ? (double)(result->missed_voxels + result->surplus_voxels) / (double)result->voxels : 0.0;
}
