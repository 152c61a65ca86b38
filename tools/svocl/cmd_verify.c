/* SPDX-License-Identifier: MIT */
/* svocl verify: compares a tree with the exact reference (tools/reference), voxel by voxel, pair by pair and vertex
   by vertex. */
#include <inttypes.h>

#include "support/build_report.h"
#include "support/snap_check.h"
#include "support/solid_check.h"
#include "support/solid_report.h"
#include "support/table.h"
#include "support/tree_check.h"
#include "svocl/commands.h"

/* Differences, all of which must be 0, and how much was compared. */
typedef struct verdict {
    tree_differences tree;
    bool snap_compared; /* false for a tree from a file: the unsnapped mesh is missing */
    snap_differences snap;
    solid_result solid; /* none without --solid */
    solid_differences filled;
} verdict;

static bool surface_is_exact(const verdict *found)
{
    return tree_check_is_exact(&found->tree) && found->snap.grid_values == 0 && found->snap.triangles == 0;
}

static bool solid_is_exact(const verdict *found)
{
    return found->solid.solid == NULL || solid_check_is_exact(&found->filled);
}

static bool is_exact(const verdict *found)
{
    return surface_is_exact(found) && solid_is_exact(found);
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
    if (surface_is_exact(found)) {
        table_line("exact: 0 missed, 0 surplus");
    }
    solid_print(state, &found->solid);
    if (found->solid.solid != NULL) {
        table_line("%s voxels are not as the reference says, of %s inside",
                   figure_count(found->filled.voxels.wrong_voxels).text,
                   figure_count(found->filled.voxels.inside_voxels).text);
        if (found->filled.voxels.split_voxels > 0) {
            table_line("%s voxels lie on the other side than the one that decides their cell, for the surface is open",
                       figure_count(found->filled.voxels.split_voxels).text);
        }
    }
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
    solid_add_json(document, state, &found->solid);
    if (found->solid.solid != NULL) {
        json_add_count(document, "wrong_solid_voxels", found->filled.voxels.wrong_voxels);
        json_add_count(document, "split_solid_voxels", found->filled.voxels.split_voxels);
        cJSON_AddBoolToObject(document, "solid_counts_differ", found->filled.counts_differ);
    }
    cJSON_AddBoolToObject(document, "exact", is_exact(found));
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
    if (is_exact(found)) {
        return PROGRAM_DONE;
    }
    if (surface_is_exact(found)) {
        return program_fail(state, PROGRAM_FAILED, "%s: the solid is not exact: %" PRIu64 " voxels are wrong%s",
                            state->options.input, found->filled.voxels.wrong_voxels,
                            found->filled.counts_differ ? ", and its counts" : "");
    }
    const oracle_difference *d = &found->tree.difference;
    return program_fail(state, PROGRAM_FAILED,
                        "%s: the tree is not exact: %" PRIu64 " missed and %" PRIu64 " surplus voxels, %" PRIu64
                        " missed and %" PRIu64 " surplus pairs, %" PRIu64 " nodes and %" PRIu64
                        " snapped triangles differ",
                        state->options.input, d->missed_voxels, d->surplus_voxels, d->missed_pairs, d->surplus_pairs,
                        found->tree.node_differences, found->snap.triangles);
}

/* Fills the tree and compares, with --solid. */
static int verify_solid(program *state, const job *done, const svo_tree_info *info, const svo_tree_arrays *arrays,
                        verdict *found)
{
    const svo_solid_rule rule = (svo_solid_rule)(state->options.solid - 1);
    if (!solid_is_wanted(state)) {
        return PROGRAM_DONE;
    }
    if (info->depth > SOLID_CHECK_DEPTH_MAX) {
        return program_fail(state, PROGRAM_FAILED, "%s: --solid is compared up to depth %u, not at depth %u",
                            state->options.input, SOLID_CHECK_DEPTH_MAX, info->depth);
    }
    const int exit_code = solid_make(state, done->opened.device, done->result.tree, &found->solid);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    progress_step(state->progress, "comparing the inside with the reference");
    if (svo_compact_download(found->solid.solid, NULL) != SVO_OK) {
        return program_fail_library(state, svo_device_message(done->opened.device));
    }
    return solid_check(info, arrays, found->solid.solid, &found->solid.info, rule, &found->filled)
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_FAILED,
                              "%s: the comparison of the inside ran out of memory or the solid is malformed",
                              state->options.input);
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
    const int exit_code = done != NULL ? verify_solid(state, done, &info, &arrays, &found) : PROGRAM_DONE;
    const int reported = exit_code == PROGRAM_DONE ? report_verdict(state, &info, &found, done) : exit_code;
    solid_release(&found.solid);
    return reported;
}

static int verify_tree_file(program *state)
{
    int exit_code = input_refuse_build_options(state);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (solid_is_wanted(state)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--solid does not apply to a .svo file, give the mesh");
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
    int exit_code = job_run(state, need | (uint32_t)SVO_NEED_RAYS, solid_is_wanted(state) ? 4 : 2, &done);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = verify(state, done.result.tree, &done);
    job_release(&done);
    return exit_code;
}
