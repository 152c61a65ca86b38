/* SPDX-License-Identifier: MIT */
/* E1: false negatives and false positives of every voxelization method, at 64^3 to 1024^3. */
#include "errors/subjects.h"

#include <stdio.h>

#include "errors/voxel_methods.h"

#define DEPTH_FIRST 6u

static result_table *begin_table(error_run *run)
{
    result_table *table = result_add_table(run->results, "e1-voxelization", "E1: voxelization", "");
    result_set_note(
        table,
        "Each method lists the (voxel, triangle) pairs of the mesh as given. Its voxels are compared with the exact "
        "set of that mesh for its coverage: closed voxels for the two separating-axis tests, half-open ones for the "
        "others. The float32 methods run on %u host threads; the two tests visit every voxel of a triangle's bounds. "
        "svocl's own methods run on the device or renderer named above (stage voxelize). Until 0.1 they rounded "
        "vertices to the nearest of 2^20 steps: those lists are a reference's, without a time. %s; methods run "
        "interleaved.",
        run->threads, run->rounds_note);
    result_add_column(table, "scene", "");
    result_add_column(table, "grid edge", "voxels");
    result_add_column(table, "method", "");
    result_add_column(table, "coverage", "");
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
    result_add_text(table, "%s", one->coverage);
    result_add_number(table, one->ms);
    result_add_number(table, (double)one->voxels);
    result_add_number(table, (double)one->missed_voxels);
    result_add_number(table, (double)one->surplus_voxels);
    result_add_number(table, (double)one->missed_voxels * percent);
    result_add_number(table, (double)one->surplus_voxels * percent);
    result_add_number(table, 100.0 * voxel_method_error(one));
}

static int measure_scene(error_run *run, result_table *table, const error_scene *given, unsigned last_depth)
{
    suite_input made = {.text = ""};
    int exit_code = suite_open(run->state, given->spec, &made);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    for (unsigned depth = DEPTH_FIRST; depth <= last_depth && exit_code == PROGRAM_DONE; ++depth) {
        voxel_method_result results[VOXEL_METHODS_MAX] = {0};
        size_t result_count = 0;
        progress_step(run->state->progress, "E1: voxelization");
        exit_code = voxel_methods_measure(run, made.source.mesh, depth, 0.0, results, &result_count);
        for (size_t i = 0; i < result_count && exit_code == PROGRAM_DONE; ++i) {
            add_row(table, errors_scene_name(given, &made.source), depth, &results[i]);
        }
    }
    input_close(&made.source);
    return exit_code;
}

/* A curved surface, and flat ones of which many lie on voxel faces. */
static int measure(error_run *run)
{
    const error_scene own[] = {
        {"statue", run->quick ? "statue:60000" : "statue:120000"}, {"atrium", "atrium:17000"}, {NULL, NULL}};
    result_table *table = begin_table(run);
    int exit_code = PROGRAM_DONE;
    error_scene given = errors_scene_at(run, own, 0);
    for (size_t i = 1; given.spec != NULL && exit_code == PROGRAM_DONE; given = errors_scene_at(run, own, i++)) {
        exit_code = measure_scene(run, table, &given, !run->quick ? 10 : i == 1 ? 9 : 8);
    }
    return exit_code;
}

static int run_all(suite *all)
{
    error_run run = errors_begin(all);
    return measure(&run);
}

const suite_subject errors_voxelization = {
    .words = &subject_table[SUBJECT_E1],
    .run_all = run_all,
    .takes_scenes = true,
    .step_count = 10,
};
