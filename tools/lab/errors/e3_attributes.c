/* SPDX-License-Identifier: MIT */
/* E3: errors of voxels' mean colors and normals, and their dependence on the order of samples. */
#include "errors/subjects.h"

#include "errors/attribute_methods.h"
#include "measure/vertex_attributes.h"

static result_table *begin_table(error_run *run)
{
    result_table *table = result_add_table(run->results, "e3-attributes", "E3: attributes", "");
    result_set_note(table,
                    "Each leaf's mean color and normal, compared with the area-weighted mean in double over the parts "
                    "of triangles inside it. Colors: error of the worst channel, in 1/255. Normals: angle to the "
                    "direction of the mean, in degrees. The running average keeps three 8-bit channels and an 8-bit "
                    "count in one word, updated by compare-and-swap; float atomics use compare-and-swap too. Both "
                    "receive precomputed samples, one per (voxel, triangle) pair, and average leaves only; svocl's "
                    "times (stages link and filter) include sampling, clipping and all levels above. Order: difference "
                    "between orders of the samples or triangles. All methods run on the OpenCL device, interleaved. "
                    "%s.",
                    run->rounds_note);
    result_add_column(table, "attribute", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "samples per voxel", "");
    result_add_column(table, "method", "");
    result_add_column(table, "time", "ms");
    result_add_column(table, "error, mean", "");
    result_add_column(table, "error, 99th percentile", "");
    result_add_column(table, "error, largest", "");
    result_add_column(table, "order, mean", "");
    result_add_column(table, "order, largest", "");
    return table;
}

static void add_row(result_table *table, attribute kind, unsigned depth, double pairs_per_leaf,
                    const attribute_method_result *one)
{
    result_add_text(table, "%s", kind == ATTRIBUTE_COLOR ? "color, 1/255" : "normal, degrees");
    result_add_number(table, depth);
    result_add_number(table, pairs_per_leaf);
    result_add_text(table, "%s", one->method);
    result_add_number(table, one->ms);
    result_add_number(table, one->mean);
    result_add_number(table, one->percentile_99);
    result_add_number(table, one->largest);
    result_add_number(table, one->order_mean);
    result_add_number(table, one->order_largest);
}

static int measure_depth(error_run *run, result_table *table, const svo_mesh *mesh, attribute kind, unsigned depth)
{
    attribute_method_result results[ATTRIBUTE_METHODS_MAX] = {0};
    size_t result_count = 0;
    double pairs_per_leaf = 0.0;
    const int exit_code = attribute_methods_measure(run, mesh, kind, depth, results, &result_count, &pairs_per_leaf);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    for (size_t i = 0; i < result_count; ++i) {
        add_row(table, kind, depth, pairs_per_leaf, &results[i]);
    }
    return PROGRAM_DONE;
}

static int measure_mesh(error_run *run, result_table *table, const svo_mesh *mesh)
{
    const unsigned last_depth = run->quick ? 7 : 9;
    int exit_code = PROGRAM_DONE;
    for (attribute kind = ATTRIBUTE_COLOR; kind < ATTRIBUTE_COUNT && exit_code == PROGRAM_DONE; ++kind) {
        progress_step(run->state->progress, "E3: attributes");
        for (unsigned depth = 3; depth <= last_depth && exit_code == PROGRAM_DONE; ++depth) {
            exit_code = measure_depth(run, table, mesh, kind, depth);
        }
    }
    return exit_code;
}

static int measure_scene(error_run *run, result_table *table, const error_scene *given)
{
    suite_input made = {.text = ""};
    int exit_code = suite_open(run->state, given->spec, &made);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    vertex_attributes own;
    if (vertex_attributes_create(made.source.mesh, &own)) {
        exit_code = measure_mesh(run, table, &own.mesh);
        vertex_attributes_free(&own);
    } else {
        exit_code = errors_fail(run);
    }
    if (run->scenes[0] != NULL) { /* rows do not name their scene */
        result_extend_note(table, "Scene: %s%s.", suite_scene_name(&made.source),
                           made.source.mesh->colors == NULL ? ", its colors by position" : "");
    }
    input_close(&made.source);
    return exit_code;
}

static int measure(error_run *run)
{
    const error_scene own[] = {{NULL, run->quick ? "statue:20000" : "statue:120000"}, {NULL, NULL}};
    result_table *table = begin_table(run);
    int exit_code = PROGRAM_DONE;
    error_scene given = errors_scene_at(run, own, 0);
    for (size_t i = 1; given.spec != NULL && exit_code == PROGRAM_DONE; given = errors_scene_at(run, own, i++)) {
        exit_code = measure_scene(run, table, &given);
    }
    return exit_code;
}

static int run_all(suite *all)
{
    error_run run = errors_begin(all);
    return measure(&run);
}

const suite_subject errors_attributes = {
    .words = &subject_table[SUBJECT_E3],
    .run_all = run_all,
    .takes_scenes = true,
    .step_count = 2,
};
