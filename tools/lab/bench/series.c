/* SPDX-License-Identifier: MIT */
/* Interleaved builds, and medians and quartiles of their stages. */
#include "bench/series.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/info_of.h"

/* ---- methods ---- */

static void explain(series_method *method, const char *reason)
{
    snprintf(method->reason, sizeof method->reason, "%s", reason);
}

void series_use_cl(suite *all, series_method *method)
{
    method->frontend = all->opened.cl;
}

void series_use_gl(suite *all, int frontend, int share, series_method *method)
{
    if (all->opened.gl == NULL) {
        explain(method, all->opened.reason.text);
        return;
    }
    svo_message reason = {""};
    method->frontend = opengl_further_frontend(all->opened.gl, frontend, share, &reason);
    if (method->frontend == NULL) {
        explain(method, reason.text);
    }
}

void series_use_gl_compute(suite *all, series_method *method)
{
    method->in_gl = true;
    if (all->opened.gl == NULL) {
        explain(method, all->opened.reason.text);
    }
}

/* ---- one build ---- */

static uint64_t bytes_of_tree(const svo_tree *tree)
{
    uint64_t sum = 0;
    for (int i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        size_t bytes = 0;
        const cl_mem buffer = svo_tree_get_buffer(tree, (svo_tree_buffer)i);
        if (buffer != NULL && clGetMemObjectInfo(buffer, CL_MEM_SIZE, sizeof bytes, &bytes, NULL) == CL_SUCCESS) {
            sum += bytes;
        }
    }
    return sum;
}

static void keep_facts(const svo_plan *plan, const svo_tree *tree, series_method *method)
{
    const svo_plan_info info = info_of_plan(plan);
    method->info = (svo_tree_info)SVO_TREE_INFO_INIT;
    svo_tree_get_info(tree, &method->info);
    method->peak_bytes = info.peak_bytes;
    method->tree_bytes = bytes_of_tree(tree);
    method->list_bytes = 0;
    for (size_t i = 0; i < info.buffer_count; ++i) {
        svo_buffer_info buffer = SVO_BUFFER_INFO_INIT;
        svo_plan_get_buffer(plan, i, &buffer);
        method->list_bytes += strcmp(buffer.name, "fragments") == 0 ? buffer.bytes : 0;
    }
}

static void keep_times(const svo_build_report *report, double wall_ms, double *times)
{
    for (size_t stage = 0; stage < SVO_STAGE_COUNT; ++stage) {
        times[stage] = report->stage_times[stage].clock != NULL ? report->stage_times[stage].ms : 0.0;
    }
    times[SERIES_WALL] = wall_ms;
}

static svo_status build(suite *all, const svo_mesh *mesh, unsigned depth, series_method *method, double *times)
{
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    cl_command_queue queue = all->opened.queue;
    method->plan.struct_size = sizeof method->plan;
    method->report = (svo_build_report){.struct_size = sizeof method->report};
    const double start_ms = input_now_ms();
    svo_status status = svo_plan_create(all->opened.device, mesh, depth, &method->plan, &plan);
    if (status != SVO_OK) {
        goto cleanup;
    }
    status = method->in_gl ? opengl_build(all->opened.gl, plan, queue, &tree, &method->report)
                           : svo_build(plan, method->frontend, queue, &tree, &method->report);
    if (status != SVO_OK) {
        goto cleanup;
    }
    keep_times(&method->report, input_now_ms() - start_ms, times);
    keep_facts(plan, tree, method);
    if (method->for_rays) {
        const double built_ms = input_now_ms();
        status = svo_tree_make_bvh(tree, SVO_BVH_BEST, queue);
        times[SERIES_RAYS] = input_now_ms() - built_ms;
        method->ray_bytes = info_of_tree(tree).ray_bytes;
    }
cleanup:
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    return status;
}

/* ---- one round ---- */

/* Failures that leave the method out instead of ending the run. */
static bool is_limit(svo_status status)
{
    return status == SVO_UNSUPPORTED || status == SVO_NO_GL || status == SVO_OUT_OF_DEVICE_MEMORY;
}

int series_run_round(suite *all, const svo_mesh *mesh, unsigned depth, series_method *method, size_t round)
{
    if (method->reason[0] != '\0') {
        return PROGRAM_DONE;
    }
    const svo_status status = build(all, mesh, depth, method, method->times + round * SERIES_CLOCKS);
    if (is_limit(status)) {
        explain(method, program_words(svo_device_message(all->opened.device)));
        return PROGRAM_DONE;
    }
    method->rounds = round;
    return status == SVO_OK ? PROGRAM_DONE : program_fail_library(all->state, svo_device_message(all->opened.device));
}

bool series_begin(const suite *all, series_method *methods, size_t method_count)
{
    bool there = true;
    for (size_t i = 0; i < method_count; ++i) {
        methods[i].times = calloc((all->repeats + 1) * SERIES_CLOCKS, sizeof *methods[i].times);
        there = there && methods[i].times != NULL;
    }
    return there;
}

void series_release(series_method *methods, size_t method_count)
{
    for (size_t i = 0; i < method_count; ++i) {
        free(methods[i].times);
        methods[i].times = NULL;
    }
}

/* ---- statistics ---- */

double series_round_ms(const series_method *method, size_t round, unsigned clocks)
{
    double sum = 0.0;
    for (unsigned clock = 0; clock < SERIES_CLOCKS; ++clock) {
        sum += (clocks & SERIES_BIT(clock)) != 0 ? method->times[round * SERIES_CLOCKS + clock] : 0.0;
    }
    return sum;
}

/* Over the rounds: the sums of one method, or their ratios to the other's. */
static spread spread_over_rounds(const series_method *method, const series_method *other, unsigned clocks)
{
    if (method->reason[0] != '\0' || (other != NULL && other->reason[0] != '\0')) {
        return spread_none();
    }
    double *values = calloc(method->rounds + 1, sizeof *values);
    if (values == NULL) {
        return spread_none();
    }
    for (size_t round = 1; round <= method->rounds; ++round) {
        values[round - 1] =
            series_round_ms(method, round, clocks) / (other != NULL ? series_round_ms(other, round, clocks) : 1.0);
    }
    const spread result = spread_of(values, method->rounds);
    free(values);
    return result;
}

spread series_ms(const series_method *method, unsigned clocks)
{
    return spread_over_rounds(method, NULL, clocks);
}

spread series_ratio(const series_method *method, const series_method *other, unsigned clocks)
{
    return spread_over_rounds(method, other, clocks);
}

double series_first_ms(const series_method *method, unsigned clocks)
{
    return method->reason[0] == '\0' ? series_round_ms(method, 0, clocks) : (double)NAN;
}

const char *series_clock(const series_method *method, svo_stage stage)
{
    const char *clock = method->reason[0] == '\0' ? method->report.stage_times[stage].clock : NULL;
    return clock != NULL ? clock : "";
}

/* ---- the series ---- */

static int check(suite *all, const input *source, const series_method *methods, size_t method_count)
{
    const series_method *first = NULL;
    for (size_t i = 0; i < method_count; ++i) {
        if (methods[i].reason[0] != '\0') {
            continue;
        }
        first = first != NULL ? first : &methods[i];
        if (methods[i].report.fragments != first->report.fragments ||
            methods[i].info.node_count != first->info.node_count) {
            return program_fail(all->state, PROGRAM_FAILED,
                                "%s: %s made %" PRIu64 " fragments and %" PRIu64 " nodes, %s %" PRIu64 " and %" PRIu64,
                                source->name, first->name, first->report.fragments, first->info.node_count,
                                methods[i].name, methods[i].report.fragments, methods[i].info.node_count);
        }
    }
    return PROGRAM_DONE;
}

/* Says in the note which methods are missing. */
static void add_reasons(result_table *table, const series_method *methods, size_t method_count)
{
    for (size_t i = 0; i < method_count; ++i) {
        if (methods[i].reason[0] != '\0') {
            result_extend_note(table, "Without %s: %s.", methods[i].name, methods[i].reason);
        }
    }
}

static int run_rounds(suite *all, const svo_mesh *mesh, unsigned depth, series_method *methods, size_t method_count)
{
    if (!series_begin(all, methods, method_count)) {
        return program_fail(all->state, PROGRAM_FAILED, "out of memory");
    }
    int exit_code = PROGRAM_DONE;
    for (size_t round = 0; round <= all->repeats; ++round) {
        for (size_t i = 0; i < method_count && exit_code == PROGRAM_DONE; ++i) {
            exit_code = series_run_round(all, mesh, depth, &methods[i], round);
        }
    }
    return exit_code;
}

int series_run(suite *all, const char *table_id, const input *source, unsigned depth, series_method *methods,
               size_t method_count, series_row add_row)
{
    result_table *table = result_find(all->results, table_id);
    int exit_code = run_rounds(all, source->mesh, depth, methods, method_count);
    if (exit_code == PROGRAM_DONE) {
        exit_code = check(all, source, methods, method_count);
    }
    for (size_t i = 0; i < method_count && exit_code == PROGRAM_DONE; ++i) {
        if (methods[i].reason[0] == '\0') {
            add_row(table, source, depth, &methods[i], &methods[0]);
        }
    }
    add_reasons(table, methods, method_count);
    series_release(methods, method_count);
    return exit_code;
}
