/* SPDX-License-Identifier: MIT */
/* E1: voxels that are missed and voxels too many, for every way to voxelize, at 64^3 to 1024^3. */
#include "errors/e1_voxelization.h"

#include <stdio.h>

#include "errors/voxel_methods.h"

#define DEPTH_FIRST 6u

static result_table *begin_table(error_run *run)
{
    result_table *table = result_add_table(run->results, "e1-voxelization", "E1: voxelization", "");
    result_set_note(
        table,
        "Each way makes the list of (voxel, triangle) pairs of the same snapped triangles; its voxels are compared "
        "with the exact set of those it aims at, closed voxels for the two separating tests, half-open ones for the "
        "others. The float32 ways follow the rules of their kind, the two tests for every voxel of a triangle's "
        "bounds, on %u threads of the host, the exact ones run on the device or renderer named above (stage voxelize). "
        "Medians of %zu rounds, interleaved, after one that does not count.",
        run->threads, run->rounds);
    result_add_column(table, "scene", "");
    result_add_column(table, "grid edge", "voxels");
    result_add_column(table, "method", "");
    result_add_column(table, "aims at", "");
    result_add_column(table, "time", "ms");
    result_add_column(table, "exact voxels", "");
    result_add_column(table, "missed", "");
    result_add_column(table, "surplus", "");
    result_add_column(table, "false negatives", "%");
    result_add_column(table, "false positives", "%");
    result_add_column(table, "error", "%");
    return table;
}

static void add_row(result_table *table, const char *name, unsigned depth, const voxel_method_result *one)
{
    const double percent = one->voxels > 0 ? 100.0 / (double)one->voxels : 0.0;
    result_add_text(table, "%s", name);
    result_add_number(table, (double)(1u << depth));
    result_add_text(table, "%s", one->method);
    result_add_text(table, "%s", one->target);
    result_add_number(table, one->ms);
    result_add_number(table, (double)one->voxels);
    result_add_number(table, (double)one->missed_voxels);
    result_add_number(table, (double)one->surplus_voxels);
    result_add_number(table, (double)one->missed_voxels * percent);
    result_add_number(table, (double)one->surplus_voxels * percent);
    result_add_number(table, 100.0 * voxel_method_error(one));
}

static int measure_scene(error_run *run, result_table *table, const char *name, const char *spec, unsigned last_depth)
{
    scene *made = errors_scene(run, spec);
    if (made == NULL) {
        return PROGRAM_FAILED;
    }
    int exit_code = PROGRAM_DONE;
    for (unsigned depth = DEPTH_FIRST; depth <= last_depth && exit_code == PROGRAM_DONE; ++depth) {
        voxel_method_result results[VOXEL_METHODS_MAX] = {0};
        size_t result_count = 0;
        progress_step(run->state->progress, "E1: voxelization");
        exit_code = voxel_methods_measure(run, scene_mesh(made), depth, 0.0, results, &result_count);
        for (size_t i = 0; i < result_count && exit_code == PROGRAM_DONE; ++i) {
            add_row(table, name, depth, &results[i]);
        }
    }
    scene_destroy(&made);
    return exit_code;
}

/* Curved surfaces, and flat ones of which many lie in the faces of voxels. */
static int measure(error_run *run)
{
    result_table *table = begin_table(run);
    const int exit_code = measure_scene(run, table, "statue", run->quick ? "statue:60000" : "statue:120000", 10);
    return exit_code == PROGRAM_DONE ? measure_scene(run, table, "atrium", "atrium:17000", run->quick ? 9 : 10)
                                     : exit_code;
}

static int run_all(suite *all)
{
    error_run run = errors_begin(all);
    return measure(&run);
}

const suite_subject errors_voxelization = {
    .name = "e1",
    .group = "errors",
    .summary = "error and run time of voxelization: false negatives and positives of each method",
    .run_all = run_all,
    .step_count = 10,
};
