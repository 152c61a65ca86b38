/* SPDX-License-Identifier: MIT */
/*
 * E4: errors of a level of detail (distance of its voxels from the surface, area and enclosed volume), with the time
 * and memory that it takes.
 */
#include "errors/e4_detail.h"

#include <math.h>

#include "errors/detail_measures.h"
#include "errors/errors.h"
#include "measure/interleave.h"
#include "support/input.h"

#define FIRST_DEPTH 3u

static result_table *begin_table(error_run *run)
{
    result_table *table = result_add_table(run->results, "e4-detail", "E4: level of detail", "");
    result_set_note(
        table,
        "One closed scene at each depth. Distance: the largest distance of a voxel center from the surface (one-sided "
        "Hausdorff distance), found by svo_tree_nearest; the surface never leaves its voxels. Area, compared with the "
        "mesh: the sum of the leaves' fill, and the common estimate from the number of outer voxel faces. Volume, "
        "compared with the mesh: the enclosed voxels, with those of the surface counted half. Distances in %% are "
        "relative to the edge of the grid. Time: plan and build of nodes and fill. Size: nodes and fill. %s.",
        run->rounds_note);
    result_add_column(table, "scene", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "voxels", "");
    result_add_column(table, "size", "B");
    result_add_column(table, "time", "ms");
    result_add_column(table, "distance of centers, largest", "voxels");
    result_add_column(table, "distance of centers", "%");
    result_add_column(table, "area by fill, error", "%");
    result_add_column(table, "area by faces, error", "%");
    result_add_column(table, "volume, error", "%");
    return table;
}

typedef struct detail_build {
    error_run *run;
    const svo_mesh *mesh;
    unsigned depth;
    svo_tree *tree;
} detail_build;

static double build_once(void *user)
{
    detail_build *work = user;
    const session *opened = &work->run->opened;
    const svo_plan_options plan_options = {.struct_size = sizeof plan_options, .need = SVO_NEED_FILL};
    svo_plan *plan = NULL;
    svo_tree_destroy(&work->tree);
    const double started_ms = input_now_ms();
    const bool worked =
        svo_plan_create(opened->device, work->mesh, work->depth, &plan_options, &plan) == SVO_OK &&
        svo_build(plan, opened->cl != NULL ? opened->cl : opened->frontend, opened->queue, &work->tree, NULL) == SVO_OK;
    const double ms = input_now_ms() - started_ms;
    svo_plan_destroy(&plan);
    return worked ? ms : -1.0;
}

static double percent_off(double measured, double exact)
{
    return exact > 0.0 ? 100.0 * fabs(measured - exact) / exact : NAN;
}

static int add_depth(error_run *run, result_table *table, const char *name, const detail_reference *reference,
                     const svo_mesh *mesh, unsigned depth)
{
    detail_build work = {.run = run, .mesh = mesh, .depth = depth};
    interleaved_method building = {.work_ms = build_once, .user = &work};
    detail_measures found;
    bool worked = interleave_measure(&building, 1, run->rounds) &&
                  svo_tree_download(work.tree, run->opened.queue) == SVO_OK &&
                  detail_measure(reference, work.tree, run->opened.queue, &found);
    if (worked) {
        svo_tree_info info = SVO_TREE_INFO_INIT;
        svo_tree_get_info(work.tree, &info);
        const double voxel = info.edge / (double)(1u << depth);
        result_add_text(table, "%s", name);
        result_add_number(table, depth);
        result_add_number(table, (double)info.leaf_count);
        result_add_number(table, (double)(info.inner_count * 5 + info.node_count * 2));
        result_add_number(table, building.median_ms);
        result_add_number(table, found.distance / voxel);
        result_add_number(table, 100.0 * found.distance / info.edge);
        result_add_number(table, percent_off(found.area_by_fill, reference->area));
        result_add_number(table, percent_off(found.area_by_faces, reference->area));
        result_add_number(table, percent_off(found.volume, reference->volume));
    }
    svo_tree_destroy(&work.tree);
    return worked ? PROGRAM_DONE : errors_fail(run);
}

static int measure_scene(error_run *run, result_table *table, const error_scene *given, unsigned last_depth)
{
    detail_reference reference;
    suite_input made = {.text = ""};
    int exit_code = suite_open(run->state, given->spec, &made);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    progress_step(run->state->progress, "E4: level of detail");
    const svo_mesh *mesh = made.source.mesh;
    exit_code = detail_reference_create(&run->opened, mesh, &reference) ? PROGRAM_DONE : errors_fail(run);
    for (unsigned depth = FIRST_DEPTH; depth <= last_depth && exit_code == PROGRAM_DONE; ++depth) {
        exit_code = add_depth(run, table, errors_scene_name(given, &made.source), &reference, mesh, depth);
    }
    detail_reference_free(&reference);
    input_close(&made.source);
    return exit_code;
}

static int measure(error_run *run)
{
    const error_scene own[] = {{"knot", run->quick ? "knot:20000" : "knot:100000"},
                               {"statue", run->quick ? "statue:20000" : "statue:120000"},
                               {NULL, NULL}};
    result_table *table = begin_table(run);
    int exit_code = PROGRAM_DONE;
    error_scene given = errors_scene_at(run, own, 0);
    for (size_t i = 1; given.spec != NULL && exit_code == PROGRAM_DONE; given = errors_scene_at(run, own, i++)) {
        exit_code = measure_scene(run, table, &given, run->quick ? 8 : 9);
    }
    return exit_code;
}

static int run_all(suite *all)
{
    error_run run = errors_begin(all);
    return measure(&run);
}

const suite_subject errors_detail = {
    .words = &subject_table[SUBJECT_E4],
    .run_all = run_all,
    .takes_scenes = true,
    .step_count = 2,
};
