/* SPDX-License-Identifier: MIT */
/*
 * Cases whose trees are compared with the exact reference pair by pair: T1 scenes, T3 and T4 classes of triangles, T7
 * the ill-conditioned scene, T8 garbage, T9 depths, T10 capacities.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "scenes/scenes.h"
#include "stress/cases.h"
#include "stress/stress.h"

#define CASE_DEPTH 6

static const svo_plan_options own_grid = {.edge = TRIANGLE_SET_UNITS};

static void scenes(stress *run, svo_coverage coverage)
{
    stress_case one = stress_begin("T1 scenes, %s", svo_name(SVO_NAME_COVERAGE, coverage));
    const svo_plan_options plan_options = {.coverage = coverage};
    for (size_t i = 0; scene_describe(i) != NULL; ++i) {
        char spec[64];
        snprintf(spec, sizeof spec, "%s:%zu:%u", scene_describe(i)->name, stress_amount(run, 1000, 50),
                 (unsigned)(run->seed & 0xffffu));
        scene *made = NULL;
        svo_message message = {""};
        if (scene_create(spec, &made, &message) != SVO_OK) {
            stress_fail(&one, "%s: %s", spec, program_words(message.text));
            continue;
        }
        stress_check(run, scene_mesh(made), stress_depth(run, 7, 3), &plan_options, &one);
        scene_destroy(&made);
    }
    stress_end(run, &one);
}

/* All three coverages on the caller's grid, then the float32 methods on the same triangles. */
static void shape_at_origin(stress *run, triangle_shape shape)
{
    const char *row = shape == TRIANGLES_SLIVERS || shape == TRIANGLES_NEEDLES ? "T3" : "T4";
    const size_t triangle_count = shape == TRIANGLES_HUGE ? stress_amount(run, 1, 1) : stress_amount(run, 50, 8);
    stress_case one = stress_begin("%s %s", row, triangle_shape_name(shape));
    triangle_set made;
    if (!triangle_set_create(shape, run->seed, triangle_count, &made)) {
        run->failed = true;
        return;
    }
    stress_tree built;
    bool has_tree = false;
    for (int coverage = SVO_COVERAGE_THIN; coverage >= SVO_COVERAGE_HALF_OPEN; --coverage) {
        svo_plan_options plan_options = own_grid;
        plan_options.coverage = (svo_coverage)coverage;
        plan_options.need = SVO_NEED_RAYS;
        has_tree = stress_build(run, NULL, &made.mesh, stress_depth(run, CASE_DEPTH, 4), &plan_options, &one, &built);
        if (has_tree) {
            stress_compare(&made.mesh, &plan_options, &built, &one);
        }
        if (has_tree && coverage != SVO_COVERAGE_HALF_OPEN) {
            stress_tree_free(&built);
        }
    }
    stress_end(run, &one);
    if (has_tree) {
        stress_float_methods(run, one.name, &made.mesh, &built);
        stress_tree_free(&built);
    }
    triangle_set_free(&made);
}

/* A unit-sized mesh far from the origin. The grid is fitted in double, so the snap adds no error to that of the
   positions. */
static void shape_at_offset(stress *run, triangle_shape shape, double offset, bool with_float_methods)
{
    stress_case one = stress_begin("T4 %s at %.9g", triangle_shape_name(shape), offset);
    const svo_plan_options plan_options = {.need = SVO_NEED_RAYS};
    triangle_set made;
    if (!triangle_set_create(shape, run->seed + 1, stress_amount(run, 20, 4), &made)) {
        run->failed = true;
        return;
    }
    triangle_set_move(&made, 1.0 / TRIANGLE_SET_UNITS, offset);
    stress_tree built;
    if (stress_build(run, NULL, &made.mesh, stress_depth(run, CASE_DEPTH, 4), &plan_options, &one, &built)) {
        stress_compare(&made.mesh, &plan_options, &built, &one);
        stress_end(run, &one);
        if (with_float_methods) {
            stress_float_methods(run, one.name, &made.mesh, &built);
        }
        stress_tree_free(&built);
    } else {
        stress_end(run, &one);
    }
    triangle_set_free(&made);
}

static void offsets(stress *run)
{
    static const double distances[] = {1e3, 65536.0, 1048576.0, 1e6, 1e9, 1e12};
    for (size_t i = 0; i < sizeof distances / sizeof distances[0]; ++i) {
        shape_at_offset(run, TRIANGLES_COPLANAR, distances[i], i == 0);
        shape_at_offset(run, TRIANGLES_SLIVERS, distances[i], i == 0);
    }
}

/* One triangle across the whole grid and many triangles of about a voxel or less, with an initial list capacity that
   is far too small. */
static void ill_conditioned_scene(stress *run)
{
    stress_case one = stress_begin("T7 ill-conditioned scene");
    triangle_set made;
    const size_t triangle_count = 1 + stress_amount(run, 1000, 20);
    if (!triangle_set_create(TRIANGLES_SMALL, run->seed, triangle_count, &made)) {
        run->failed = true;
        return;
    }
    static const double across[9] = {0.0, 1000.0, 5.0, 1048575.0, 4000.0, 70000.0, 20000.0, 1048570.0, 1040000.0};
    memcpy(made.positions, across, sizeof across);
    for (size_t t = 1; t < triangle_count; ++t) {
        const double shrink = t % 2 == 0 ? 1.0 / 1024.0 : 1.0 / 8.0;
        double *corners = made.positions + t * 9;
        for (size_t i = 3; i < 9; ++i) {
            corners[i] = rint(corners[i % 3] + (corners[i] - corners[i % 3]) * shrink);
        }
    }
    svo_plan_options plan_options = own_grid;
    plan_options.fragment_capacity = 1;
    stress_check(run, &made.mesh, stress_depth(run, 9, 5), &plan_options, &one);
    triangle_set_free(&made);
    stress_end(run, &one);
}

/* Every eighth coordinate is a special value of floating-point arithmetic, every sixteenth index is out of range. */
static void garbage(stress *run, const char *what, const svo_plan_options *plan_options)
{
    const double values[] = {(double)NAN, (double)INFINITY, -(double)INFINITY, -0.0, 1e-310, 1e38, -1e38, 5e-324};
    stress_case one = stress_begin("T8 garbage, %s", what);
    triangle_set made;
    random_stream random = {run->seed};
    if (!triangle_set_create(TRIANGLES_SMALL, run->seed, stress_amount(run, 50, 10), &made)) {
        run->failed = true;
        return;
    }
    for (size_t i = 0; i < made.mesh.vertex_count * 3; ++i) {
        const uint32_t pick = random_index(&random, 128);
        made.positions[i] = pick < 8 ? values[pick] : made.positions[i];
    }
    stress_check(run, &made.mesh, stress_depth(run, CASE_DEPTH, 4), plan_options, &one);
    stress_check(run, &made.mesh, stress_depth(run, CASE_DEPTH, 4), plan_options, &one); /* the same each time */
    static const uint32_t indices[12] = {0, 1, 2, 3, 4, UINT32_MAX, 0, 0, 0, 1000000000, 1, 2};
    svo_mesh indexed = made.mesh;
    indexed.indices = indices;
    indexed.triangle_count = 4;
    stress_check(run, &indexed, stress_depth(run, CASE_DEPTH, 4), plan_options, &one);
    indexed.triangle_count = 0;
    stress_check(run, &indexed, stress_depth(run, CASE_DEPTH, 4), plan_options, &one);
    triangle_set_free(&made);
    stress_end(run, &one);
}

static void depths(stress *run)
{
    static const unsigned depth_list[] = {1, 2, 10, 11, 12, 13, 16};
    stress_case one = stress_begin("T9 depths 1 to 16");
    triangle_set made;
    if (!triangle_set_create(TRIANGLES_SMALL, run->seed, 8 + run->count, &made)) {
        run->failed = true;
        return;
    }
    for (size_t i = 0; i < made.mesh.vertex_count * 3; ++i) { /* a few voxels wide even at depth 16 */
        made.positions[i] =
            rint(made.positions[i / 9 * 9 + i % 3] + (made.positions[i] - made.positions[i / 9 * 9 + i % 3]) / 64.0);
    }
    for (size_t i = 0; i < sizeof depth_list / sizeof depth_list[0]; ++i) {
        stress_check(run, &made.mesh, depth_list[i], &own_grid, &one);
    }
    stress_end(run, &one);
    stress_case refused = stress_begin("T9 depths 0 and 17 refused");
    refused.unit = "depths";
    for (unsigned depth = 0; depth <= 17; depth += 17) {
        const svo_plan_options plan_options = {.struct_size = sizeof plan_options};
        svo_plan *plan = NULL;
        if (svo_plan_create(run->opened.device, &made.mesh, depth, &plan_options, &plan) != SVO_INVALID_ARGUMENT) {
            stress_fail(&refused, "depth %u is not refused", depth);
        }
        svo_plan_destroy(&plan);
        refused.figure += 1.0;
    }
    stress_end(run, &refused);
    triangle_set_free(&made);
}

/* List capacities of one fragment, of exactly the required count, and of one less. */
static void capacities(stress *run)
{
    stress_case one = stress_begin("T10 capacities");
    triangle_set made;
    stress_tree built;
    if (!triangle_set_create(TRIANGLES_SMALL, run->seed, stress_amount(run, 100, 10), &made)) {
        run->failed = true;
        return;
    }
    svo_plan_options plan_options = own_grid;
    plan_options.need = SVO_NEED_RAYS;
    if (stress_build(run, NULL, &made.mesh, stress_depth(run, CASE_DEPTH, 4), &plan_options, &one, &built)) {
        const uint64_t exact = built.report.fragments;
        const uint64_t capacity_list[] = {1, exact, exact - 1};
        for (size_t i = 0; i < 3; ++i) {
            plan_options.fragment_capacity = capacity_list[i];
            stress_check(run, &made.mesh, stress_depth(run, CASE_DEPTH, 4), &plan_options, &one);
        }
        stress_tree_free(&built);
    }
    triangle_set_free(&made);
    stress_end(run, &one);
}

void stress_cases_builds(stress *run)
{
    const int last_coverage = run->count > 0 ? SVO_COVERAGE_THIN : SVO_COVERAGE_HALF_OPEN;
    for (int coverage = SVO_COVERAGE_HALF_OPEN; coverage <= last_coverage; ++coverage) {
        scenes(run, (svo_coverage)coverage);
    }
    for (int shape = 0; shape < TRIANGLE_SHAPE_COUNT; ++shape) {
        shape_at_origin(run, (triangle_shape)shape);
    }
    offsets(run);
    ill_conditioned_scene(run);
    garbage(run, "own grid", &own_grid);
    garbage(run, "fitted grid", &(svo_plan_options){0});
    depths(run);
    capacities(run);
}
