/* SPDX-License-Identifier: MIT */
/* Builds trees, compares them and collects the results. */
#include "stress/stress.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "measure/float_methods.h"
#include "measure/tree_check.h"
#include "support/input.h"

size_t stress_amount(const stress *run, size_t per_count, size_t least)
{
    return run->count > 0 ? run->count * per_count : least;
}

unsigned stress_depth(const stress *run, unsigned depth, unsigned least)
{
    return run->count > 0 ? depth : least;
}

stress_case stress_begin(const char *format, ...)
{
    stress_case one = {.method = "svocl", .unit = "pairs", .judged = true, .passed = true};
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(one.name, sizeof one.name, format, arguments);
    va_end(arguments);
    return one;
}

void stress_fail(stress_case *one, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    if (one->passed) {
        vsnprintf(one->reason, sizeof one->reason, format, arguments);
    }
    va_end(arguments);
    one->passed = false;
}

void stress_end(stress *run, const stress_case *one)
{
    if (run->case_count == run->case_capacity) {
        const size_t capacity = run->case_capacity + 64;
        stress_case *grown = realloc(run->cases, capacity * sizeof *grown);
        if (grown == NULL) {
            run->failed = true;
            return;
        }
        run->cases = grown;
        run->case_capacity = capacity;
    }
    run->cases[run->case_count++] = *one;
}

static svo_status build_tree(const stress *run, svo_frontend *frontend, svo_plan *plan, stress_tree *out)
{
    const session *opened = &run->opened;
    const svo_status status =
        svo_build(plan, frontend != NULL ? frontend : opened->frontend, opened->queue, &out->tree, &out->report);
    return status != SVO_OK ? status : svo_tree_download(out->tree, opened->queue);
}

/* Plans, builds and downloads; out->ms covers all three, also after a failure. */
static svo_status build_timed(const stress *run, svo_frontend *frontend, const svo_mesh *mesh, unsigned depth,
                              const svo_plan_options *plan_options, stress_tree *out)
{
    svo_plan *plan = NULL;
    const double started_ms = input_now_ms();
    svo_status status = svo_plan_create(run->opened.device, mesh, depth, plan_options, &plan);
    if (status != SVO_OK) {
        goto cleanup;
    }
    status = build_tree(run, frontend, plan, out);

cleanup:
    out->ms = input_now_ms() - started_ms;
    svo_plan_destroy(&plan);
    return status;
}

bool stress_build(stress *run, svo_frontend *frontend, const svo_mesh *mesh, unsigned depth,
                  const svo_plan_options *plan_options, stress_case *one, stress_tree *out)
{
    svo_plan_options sized = *plan_options;
    sized.struct_size = sizeof sized;
    *out = (stress_tree){.report = {.struct_size = sizeof out->report}};
    const svo_status status = build_timed(run, frontend, mesh, depth, &sized, out);
    one->ms += out->ms;
    if (status != SVO_OK) {
        stress_fail(one, "%s", program_words(svo_device_message(run->opened.device)));
        stress_tree_free(out);
        return false;
    }
    out->info = (svo_tree_info)SVO_TREE_INFO_INIT;
    svo_tree_get_info(out->tree, &out->info);
    out->arrays = (svo_tree_arrays)SVO_TREE_ARRAYS_INIT;
    svo_tree_get_arrays(out->tree, &out->arrays);
    if (svo_tree_hash(out->tree, SVO_HASH_ALL, out->hash) != SVO_OK ||
        svo_tree_hash(out->tree, SVO_HASH_NODES, out->nodes_hash) != SVO_OK) {
        stress_fail(one, "the tree cannot be hashed");
    }
    return true;
}

void stress_tree_free(stress_tree *built)
{
    svo_tree_destroy(&built->tree);
    *built = (stress_tree){0};
}

void stress_compare(const svo_mesh *mesh, const svo_plan_options *given, const stress_tree *built, stress_case *one)
{
    options grid = {.has_origin = given->edge > 0.0, .edge = given->edge};
    memcpy(grid.origin, given->origin, sizeof grid.origin);
    tree_differences found;
    snap_differences snap;
    if (!tree_check(mesh, &built->info, &built->arrays, &found) ||
        !snap_check(mesh, &grid, &built->info, &built->arrays, &snap)) {
        stress_fail(one, "the comparison ran out of memory or the tree is malformed");
        return;
    }
    one->false_negatives += found.difference.missed_pairs;
    one->false_positives += found.difference.surplus_pairs;
    one->figure += (double)found.expected_pairs;
    if (!tree_check_is_exact(&found)) {
        stress_fail(one, "depth %u, %s: not the exact tree", built->info.depth,
                    svo_name(SVO_NAME_COVERAGE, (svo_coverage)built->info.coverage));
    }
    if (snap.grid_values != 0 || snap.triangles != 0) {
        stress_fail(one, "depth %u: rounded differently than the reference", built->info.depth);
    }
}

void stress_check(stress *run, const svo_mesh *mesh, unsigned depth, const svo_plan_options *given, stress_case *one)
{
    svo_plan_options with_lists = *given;
    with_lists.need |= (uint32_t)SVO_NEED_RAYS;
    stress_tree built;
    if (stress_build(run, NULL, mesh, depth, &with_lists, one, &built)) {
        stress_compare(mesh, given, &built, one);
        stress_tree_free(&built);
    }
}

static void float_case(stress *run, float_method method, const char *what, const svo_mesh *mesh,
                       const stress_tree *built)
{
    stress_case one = stress_begin("%s", what);
    oracle_pairs expected = {0};
    oracle_pairs actual = {0};
    one.method = float_method_name(method);
    one.judged = false;
    const double started_ms = input_now_ms();
    bool good = float_method_run(method, &built->info, &built->arrays, &actual);
    one.ms = input_now_ms() - started_ms;
    good = good && mesh_list_pairs(mesh, &built->info, float_method_coverage(method), &expected);
    if (good) {
        oracle_difference difference;
        oracle_compare(&expected, &actual, &difference);
        one.false_negatives = difference.missed_pairs;
        one.false_positives = difference.surplus_pairs;
        one.figure = (double)expected.count;
        one.passed = difference.missed_pairs == 0 && difference.surplus_pairs == 0;
        stress_end(run, &one);
    }
    run->failed = run->failed || !good;
    oracle_pairs_free(&expected);
    oracle_pairs_free(&actual);
}

void stress_float_methods(stress *run, const char *what, const svo_mesh *mesh, const stress_tree *built)
{
    for (int method = 0; method < FLOAT_METHOD_COUNT; ++method) {
        float_case(run, (float_method)method, what, mesh, built);
    }
}
