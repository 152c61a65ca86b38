/* SPDX-License-Identifier: MIT */
/* Builds in turns, and the order statistics of their stages. */
#include "bench/series.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- ways ---- */

static void explain(series_way *way, const char *reason)
{
    snprintf(way->reason, sizeof way->reason, "%.250s", reason);
}

void series_use_cl(bench_suite *all, series_way *way)
{
    way->frontend = all->opened.cl;
}

void series_use_gl(bench_suite *all, int frontend, int share, series_way *way)
{
    if (all->opened.gl == NULL) {
        explain(way, all->opened.reason.text);
        return;
    }
    svo_message reason = {""};
    way->frontend = opengl_further_frontend(all->opened.gl, frontend, share, &reason);
    if (way->frontend == NULL) {
        explain(way, reason.text);
    }
}

void series_use_gl_compute(bench_suite *all, series_way *way)
{
    way->in_gl = true;
    if (all->opened.gl == NULL) {
        explain(way, all->opened.reason.text);
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

static void keep_facts(const svo_plan *plan, const svo_tree *tree, series_way *way)
{
    svo_tree_get_info(tree, &way->info);
    way->peak_bytes = svo_plan_peak_bytes(plan);
    way->tree_bytes = bytes_of_tree(tree);
    way->list_bytes = 0;
    const size_t count = svo_plan_get_buffer(plan, 0, NULL);
    for (size_t i = 0; i < count; ++i) {
        svo_buffer_info buffer;
        svo_plan_get_buffer(plan, i, &buffer);
        way->list_bytes += strcmp(buffer.name, "fragments") == 0 ? buffer.bytes : 0;
    }
}

static void keep_times(const svo_build_report *report, double wall_ms, double *times)
{
    for (size_t stage = 0; stage < SVO_STAGE_COUNT; ++stage) {
        times[stage] = report->stages[stage].clock != NULL ? report->stages[stage].ms : 0.0;
    }
    times[SERIES_WALL] = wall_ms;
}

static svo_status build(bench_suite *all, const svo_mesh *mesh, unsigned depth, series_way *way, double *times)
{
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    way->plan.struct_size = sizeof way->plan;
    way->report = (svo_build_report){.struct_size = sizeof way->report};
    const double start_ms = input_now_ms();
    svo_status status = svo_plan_create(all->opened.device, mesh, depth, &way->plan, &plan);
    if (status == SVO_OK) {
        status = way->in_gl ? opengl_build(all->opened.gl, plan, all->opened.queue, &tree, &way->report)
                            : svo_build(plan, way->frontend, all->opened.queue, &tree, &way->report);
    }
    if (status == SVO_OK) {
        keep_times(&way->report, input_now_ms() - start_ms, times);
        keep_facts(plan, tree, way);
    }
    if (status == SVO_OK && way->for_rays) {
        const double built_ms = input_now_ms();
        status = svo_tree_prepare_rays(tree, all->opened.queue);
        times[SERIES_RAYS] = input_now_ms() - built_ms;
        way->ray_bytes = svo_tree_ray_bytes(tree);
    }
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    return status;
}

/* ---- one turn ---- */

/* What a way may lack without the series being at fault. */
static bool is_limit(svo_status status)
{
    return status == SVO_UNSUPPORTED || status == SVO_NO_GL || status == SVO_OUT_OF_DEVICE_MEMORY;
}

int series_turn(bench_suite *all, const svo_mesh *mesh, unsigned depth, series_way *way, size_t turn)
{
    if (way->reason[0] != '\0') {
        return PROGRAM_DONE;
    }
    const svo_status status = build(all, mesh, depth, way, way->times + turn * SERIES_CLOCKS);
    if (is_limit(status)) {
        explain(way, program_words(svo_device_message(all->opened.device)));
        return PROGRAM_DONE;
    }
    way->turns = turn;
    return status == SVO_OK ? PROGRAM_DONE : program_fail_library(all->state, svo_device_message(all->opened.device));
}

bool series_begin(const bench_suite *all, series_way *ways, size_t way_count)
{
    bool there = true;
    for (size_t i = 0; i < way_count; ++i) {
        ways[i].times = calloc((all->repeats + 1) * SERIES_CLOCKS, sizeof *ways[i].times);
        there = there && ways[i].times != NULL;
    }
    return there;
}

void series_release(series_way *ways, size_t way_count)
{
    for (size_t i = 0; i < way_count; ++i) {
        free(ways[i].times);
        ways[i].times = NULL;
    }
}

/* ---- figures ---- */

double series_turn_ms(const series_way *way, size_t turn, unsigned clocks)
{
    double sum = 0.0;
    for (unsigned clock = 0; clock < SERIES_CLOCKS; ++clock) {
        sum += (clocks & SERIES_BIT(clock)) != 0 ? way->times[turn * SERIES_CLOCKS + clock] : 0.0;
    }
    return sum;
}

/* Over the turns of both: the sums of one, or their ratio to the other's. */
static spread spread_over_turns(const series_way *way, const series_way *other, unsigned clocks)
{
    if (way->reason[0] != '\0' || (other != NULL && other->reason[0] != '\0')) {
        return spread_none();
    }
    double *values = calloc(way->turns + 1, sizeof *values);
    if (values == NULL) {
        return spread_none();
    }
    for (size_t turn = 1; turn <= way->turns; ++turn) {
        values[turn - 1] =
            series_turn_ms(way, turn, clocks) / (other != NULL ? series_turn_ms(other, turn, clocks) : 1.0);
    }
    const spread result = spread_of(values, way->turns);
    free(values);
    return result;
}

spread series_ms(const series_way *way, unsigned clocks)
{
    return spread_over_turns(way, NULL, clocks);
}

spread series_ratio(const series_way *way, const series_way *other, unsigned clocks)
{
    return spread_over_turns(way, other, clocks);
}

double series_first_ms(const series_way *way, unsigned clocks)
{
    return way->reason[0] == '\0' ? series_turn_ms(way, 0, clocks) : (double)NAN;
}

const char *series_clock(const series_way *way, svo_stage stage)
{
    const char *clock = way->reason[0] == '\0' ? way->report.stages[stage].clock : NULL;
    return clock != NULL ? clock : "";
}

/* ---- the series ---- */

static int check(bench_suite *all, const input *source, const series_way *ways, size_t way_count)
{
    const series_way *first = NULL;
    for (size_t i = 0; i < way_count; ++i) {
        if (ways[i].reason[0] != '\0') {
            continue;
        }
        first = first != NULL ? first : &ways[i];
        if (ways[i].report.fragments != first->report.fragments || ways[i].info.node_count != first->info.node_count) {
            return program_fail(all->state, PROGRAM_FAILED,
                                "%s: %s made %" PRIu64 " fragments and %" PRIu64 " nodes, %s %" PRIu64 " and %" PRIu64,
                                source->name, first->name, first->report.fragments, first->info.node_count,
                                ways[i].name, ways[i].report.fragments, ways[i].info.node_count);
        }
    }
    return PROGRAM_DONE;
}

/* "; gl-hw: reason" to the end of the note, unless it is there already. */
static void add_reasons(result_table *table, const series_way *ways, size_t way_count)
{
    for (size_t i = 0; i < way_count && table != NULL; ++i) {
        char text[320];
        snprintf(text, sizeof text, "%.40s: %.256s", ways[i].name, ways[i].reason);
        if (ways[i].reason[0] != '\0' && strstr(table->note, text) == NULL) {
            result_set_note(table, "%s; %s", table->note, text);
        }
    }
}

static int take_turns(bench_suite *all, const svo_mesh *mesh, unsigned depth, series_way *ways, size_t way_count)
{
    if (!series_begin(all, ways, way_count)) {
        return program_fail(all->state, PROGRAM_FAILED, "out of memory");
    }
    int exit_code = PROGRAM_DONE;
    for (size_t turn = 0; turn <= all->repeats; ++turn) {
        for (size_t i = 0; i < way_count && exit_code == PROGRAM_DONE; ++i) {
            exit_code = series_turn(all, mesh, depth, &ways[i], turn);
        }
    }
    return exit_code;
}

int series_run(bench_suite *all, const char *table_id, const input *source, unsigned depth, series_way *ways,
               size_t way_count, series_row add_row)
{
    result_table *table = result_find(all->results, table_id);
    int exit_code = take_turns(all, source->mesh, depth, ways, way_count);
    if (exit_code == PROGRAM_DONE) {
        exit_code = check(all, source, ways, way_count);
    }
    for (size_t i = 0; i < way_count && exit_code == PROGRAM_DONE; ++i) {
        if (ways[i].reason[0] == '\0') {
            add_row(table, source, depth, &ways[i], &ways[0]);
        }
    }
    add_reasons(table, ways, way_count);
    series_release(ways, way_count);
    return exit_code;
}
