/* SPDX-License-Identifier: MIT */
/* svocl verify: compares a tree with the exact reference (tools/lab/reference), voxel by voxel, pair by pair and vertex
   by vertex. */
#include <inttypes.h>

#include "program/commands.h"
#include "support/build_report.h"
#include "support/form_check.h"
#include "support/snap_check.h"
#include "support/solid_verdict.h"
#include "support/table.h"
#include "support/tree_check.h"

/* Differences, all of which must be 0, and how much was compared. */
typedef struct verdict {
    tree_differences tree;
    bool snap_compared; /* false for a tree from a file: the unsnapped mesh is missing */
    snap_differences snap;
    form_checks forms; /* none without --form */
    solid_verdict solid; /* none without --solid */
} verdict;

static bool is_exact(const verdict *found)
{
    return tree_check_is_exact(&found->tree) && found->snap.grid_values == 0 && found->snap.triangles == 0;
}

static void print_row(table *rows, const char *name, uint64_t voxels, uint64_t pairs)
{
    table_cell(rows, "%s", name);
    table_cell(rows, "%s", figure_count(voxels).text);
    table_cell(rows, "%s", figure_count(pairs).text);
}

static void print_verdict(const program *state, const svo_tree_info *info, const verdict *found)
{
    table_heading("%s at depth %u against the exact reference", state->options.input, info->depth);
    table *rows = table_create("lrr");
    table_cell(rows, "%s", "");
    table_cell(rows, "voxels");
    table_cell(rows, "pairs");
    print_row(rows, "expected", found->tree.expected_voxels, found->tree.expected_pairs);
    print_row(rows, "built", found->tree.built_voxels, found->tree.built_pairs);
    print_row(rows, "missed", found->tree.difference.missed_voxels, found->tree.difference.missed_pairs);
    print_row(rows, "surplus", found->tree.difference.surplus_voxels, found->tree.difference.surplus_pairs);
    table_print(rows);
    table_line("%s nodes differ", figure_count(found->tree.node_differences).text);
    if (found->snap_compared) {
        table_line("%s triangles are snapped differently, %u grid values differ",
                   figure_count(found->snap.triangles).text, found->snap.grid_values);
    }
    if (is_exact(found)) {
        table_line("exact: 0 missed, 0 surplus");
    }
    form_check_print(&found->forms);
    solid_verdict_print(state, &found->solid);
}

static cJSON *to_json(const program *state, const svo_tree_info *info, const verdict *found, const job *done)
{
    cJSON *document = json_document();
    json_add_text(document, "input", state->options.input);
    json_add_count(document, "missed_voxels", found->tree.difference.missed_voxels);
    json_add_count(document, "surplus_voxels", found->tree.difference.surplus_voxels);
    json_add_count(document, "missed_pairs", found->tree.difference.missed_pairs);
    json_add_count(document, "surplus_pairs", found->tree.difference.surplus_pairs);
    json_add_count(document, "node_differences", found->tree.node_differences);
    if (found->snap_compared) {
        json_add_count(document, "grid_differences", found->snap.grid_values);
        json_add_count(document, "snap_differences", found->snap.triangles);
    }
    json_add_count(document, "expected_voxels", found->tree.expected_voxels);
    json_add_count(document, "expected_pairs", found->tree.expected_pairs);
    cJSON_AddBoolToObject(document, "exact", is_exact(found));
    form_check_add_json(document, &found->forms);
    solid_verdict_add_json(document, state, &found->solid);
    if (done != NULL) {
        report_add_refused(document, done);
        job_add_what_ran(document, done);
    } else {
        json_add_count(document, "depth", info->depth);
    }
    return document;
}

static int report_verdict(program *state, const svo_tree_info *info, const verdict *found, const job *done)
{
    progress_destroy(&state->progress);
    if (state->options.json) {
        const int exit_code = json_print(state, to_json(state, info, found, done));
        if (exit_code != PROGRAM_DONE) {
            return exit_code;
        }
    } else if (!state->options.quiet) {
        print_verdict(state, info, found);
        if (done != NULL) {
            report_print_refused(done);
        }
    }
    if (!form_check_is_exact(&found->forms)) {
        return program_fail(state, PROGRAM_FAILED, "%s: a compact form expands to another tree", state->options.input);
    }
    if (!solid_verdict_is_exact(&found->solid)) {
        return program_fail(state, PROGRAM_FAILED, "%s: the solid is not exact: %" PRIu64 " voxels are wrong%s",
                            state->options.input, found->solid.found.voxels.wrong_voxels,
                            found->solid.found.counts_differ ? ", and so are its counts" : "");
    }
    if (is_exact(found)) {
        return PROGRAM_DONE;
    }
    const oracle_difference *d = &found->tree.difference;
    return program_fail(state, PROGRAM_FAILED,
                        "%s: the tree is not exact: %" PRIu64 " missed and %" PRIu64 " surplus voxels, %" PRIu64
                        " missed and %" PRIu64 " surplus pairs, %" PRIu64 " nodes and %" PRIu64
                        " snapped triangles differ",
                        state->options.input, d->missed_voxels, d->surplus_voxels, d->missed_pairs, d->surplus_pairs,
                        found->tree.node_differences, found->snap.triangles);
}

/* done: NULL for a tree from a file. */
static int verify(program *state, const svo_tree *tree, const job *done)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    verdict found = {0};
    svo_tree_get_info(tree, &info);
    svo_tree_get_arrays(tree, &arrays);
    if ((info.need & SVO_NEED_RAYS) == 0) {
        return program_fail(state, PROGRAM_FAILED,
                            "%s: the tree has no leaf lists to compare, build it with --need rays",
                            state->options.input);
    }
    bool good = true;
    progress_step(state->progress, "comparing snapped vertices");
    if (done != NULL) {
        found.snap_compared = true;
        good = snap_check(done->source.mesh, &state->options, &info, &arrays, &found.snap);
    }
    progress_step(state->progress, "comparing voxels with the reference");
    if (!good || !tree_check(&info, &arrays, &found.tree)) {
        return program_fail(state, PROGRAM_FAILED, "%s: the comparison ran out of memory or the tree is malformed",
                            state->options.input);
    }
    if (done != NULL) {
        progress_step(state->progress, "expanding compact forms");
        const int exit_code = form_check_run(state, &done->opened, tree, &found.forms);
        if (exit_code != PROGRAM_DONE) {
            return exit_code;
        }
    }
    const int exit_code = done != NULL ? solid_verdict_find(state, &done->opened, tree, &found.solid) : PROGRAM_DONE;
    const int reported = exit_code == PROGRAM_DONE ? report_verdict(state, &info, &found, done) : exit_code;
    solid_verdict_release(&found.solid);
    return reported;
}

static int verify_tree_file(program *state)
{
    int exit_code = input_refuse_device_options(state);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (state->options.form != 0 || state->options.solid != 0) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "option --%s does not apply to a .svo file, give the mesh",
                            state->options.form != 0 ? "form" : "solid");
    }
    svo_tree *tree = NULL;
    program_begin_progress(state, 3);
    exit_code = input_load_tree(state, &tree);
    if (exit_code == PROGRAM_DONE) {
        exit_code = verify(state, tree, NULL);
    }
    svo_tree_destroy(&tree);
    return exit_code;
}

int command_verify(program *state)
{
    if (input_is_tree(state)) {
        return verify_tree_file(state);
    }
    const uint32_t need = state->options.need & ~(uint32_t)SVO_NEED_NONE;
    job done;
    int exit_code = solid_verdict_check_depth(state);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = job_run(state, need | (uint32_t)SVO_NEED_RAYS, solid_is_wanted(state) ? 5 : 3, &done);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = verify(state, done.result.tree, &done);
    job_release(&done);
    return exit_code;
}
