/* SPDX-License-Identifier: MIT */
/*
 * svocl verify: compares a tree with the exact reference (tools/lab/reference), voxel by voxel, pair by pair and vertex
 * by vertex; with --tree-form, what its compact forms expand to with the tree; with --solid, the inside; with --parts,
 * regions of a folder of parts. Exact is the tree of the mesh as it was given, in numbers of any size.
 */
#include <inttypes.h>
#include <string.h>

#include "measure/parts_check.h"
#include "measure/solid_check.h"
#include "measure/tree_check.h"
#include "program/commands.h"
#include "support/build_report.h"
#include "support/json.h"
#include "support/options_parse.h"
#include "support/parts_input.h"
#include "support/parts_job.h"
#include "support/session.h"
#include "support/table.h"

/* ---- compact forms ---- */

/* One form and what it expands to. */
typedef struct form_check {
    svo_compact_info info;
    char hash[SVO_HASH_TEXT_BYTES]; /* SVO_HASH_NODES */
    bool same_nodes; /* as that of the tree */
    bool same_payload;
} form_check;

typedef struct form_checks {
    form_check forms[SVO_FORM_COUNT];
    size_t count; /* 0: none was asked for */
} form_checks;

/* Whether two arrays are equal; both are NULL where the trees hold none. */
static bool same(const void *a, const void *b, uint64_t bytes)
{
    return a == NULL || b == NULL ? a == b : memcmp(a, b, (size_t)bytes) == 0;
}

static bool same_payload(const svo_tree *a, const svo_tree *b)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree_arrays of_a = SVO_TREE_ARRAYS_INIT;
    svo_tree_arrays of_b = SVO_TREE_ARRAYS_INIT;
    svo_tree_get_info(a, &info);
    svo_tree_get_arrays(a, &of_a);
    svo_tree_get_arrays(b, &of_b);
    const uint64_t count = info.node_count - info.level_begin[info.payload_level];
    return same(of_a.colors, of_b.colors, count * 4) && same(of_a.normals, of_b.normals, count * 6) &&
           same(of_a.materials, of_b.materials, count * 2) && same(of_a.fills, of_b.fills, count * 2);
}

/* Compares what the compact tree expands to. */
static svo_status expand(const session *opened, svo_compact *compact, const svo_tree *tree, form_check *check)
{
    char expected[SVO_HASH_TEXT_BYTES];
    svo_tree *expanded = NULL;
    svo_status status = svo_compact_expand(compact, opened->queue, &expanded);
    if (status != SVO_OK) {
        return status;
    }
    status = svo_tree_download(expanded, opened->queue);
    if (status != SVO_OK) {
        goto cleanup;
    }
    status = svo_tree_hash(expanded, SVO_HASH_NODES, check->hash);
    if (status != SVO_OK) {
        goto cleanup;
    }
    status = svo_tree_hash(tree, SVO_HASH_NODES, expected);
    if (status == SVO_OK) {
        check->same_nodes = strcmp(expected, check->hash) == 0;
        check->same_payload = check->same_nodes && same_payload(tree, expanded);
    }

cleanup:
    svo_tree_destroy(&expanded);
    return status;
}

static svo_status check_form(const session *opened, const svo_tree *tree, svo_form form, form_check *check)
{
    svo_compact_options asked = SVO_COMPACT_OPTIONS_INIT;
    svo_compact *compact = NULL;
    asked.form = form;
    check->info = (svo_compact_info)SVO_COMPACT_INFO_INIT;
    svo_status status = svo_compact_create(opened->device, tree, &asked, opened->queue, &compact);
    if (status != SVO_OK) {
        return status;
    }
    status = svo_compact_get_info(compact, &check->info);
    if (status == SVO_OK) {
        status = expand(opened, compact, tree, check);
    }
    svo_compact_destroy(&compact);
    return status;
}

/* Makes, expands and compares what --tree-form names. tree: with host arrays. Returns the exit code, its line
   printed. */
static int form_check_run(program *state, const session *opened, const svo_tree *tree, form_checks *out)
{
    const int wanted = state->options.tree_form;
    *out = (form_checks){.count = 0};
    for (int form = 0; form < SVO_FORM_COUNT; ++form) {
        if (wanted == OPTION_FORM_ALL || wanted == 1 + form) {
            if (check_form(opened, tree, (svo_form)form, &out->forms[out->count]) != SVO_OK) {
                return program_fail_library(state, svo_device_message(opened->device));
            }
            ++out->count;
        }
    }
    return PROGRAM_DONE;
}

/* Whether all of them are the tree again; true for none. */
static bool form_check_is_exact(const form_checks *checks)
{
    bool exact = true;
    for (size_t i = 0; i < checks->count; ++i) {
        exact = exact && checks->forms[i].same_nodes && checks->forms[i].same_payload;
    }
    return exact;
}

/* A line for each form; nothing for none. */
static void form_check_print(const form_checks *checks)
{
    if (checks->count == 0) {
        return;
    }
    table *rows = table_create("lrll");
    table_cell(rows, "form");
    table_cell(rows, "bytes");
    table_cell(rows, "expands to");
    table_cell(rows, "%s", "");
    for (size_t i = 0; i < checks->count; ++i) {
        const form_check *check = &checks->forms[i];
        table_cell(rows, "%s", svo_name(SVO_NAME_FORM, check->info.form));
        table_cell(rows, "%s", figure_count(check->info.total_bytes).text);
        table_cell(rows, "%s", check->hash);
        table_cell(rows, "%s",
                   !check->same_nodes     ? "other nodes"
                   : !check->same_payload ? "other payload"
                                          : "the same tree");
    }
    table_print(rows);
}

static void form_check_add_json(cJSON *document, const form_checks *checks)
{
    cJSON *forms = checks->count > 0 ? cJSON_AddArrayToObject(document, "forms") : NULL;
    for (size_t i = 0; i < checks->count; ++i) {
        const form_check *check = &checks->forms[i];
        cJSON *one = cJSON_CreateObject();
        json_add_text(one, "form", svo_name(SVO_NAME_FORM, check->info.form));
        json_add_count(one, "bytes", check->info.total_bytes);
        json_add_text(one, "hash", check->hash);
        cJSON_AddBoolToObject(one, "same_nodes", check->same_nodes);
        cJSON_AddBoolToObject(one, "same_payload", check->same_payload);
        cJSON_AddItemToArray(forms, one);
    }
}

/* ---- the inside ---- */

typedef struct solid_verdict {
    solid_result made; /* none without --solid */
    solid_differences found;
} solid_verdict;

/* Refuses --solid at a depth above SOLID_CHECK_DEPTH_MAX, and by a rule that the reference does not know, before
   anything is built. Returns the exit code, its line printed. */
static int solid_verdict_check(program *state)
{
    if (solid_is_wanted(state) && solid_rule(state) == SVO_SOLID_GENERALIZED) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "--solid generalized is not compared: the exact reference counts crossings");
    }
    return !solid_is_wanted(state) || state->options.depth <= SOLID_CHECK_DEPTH_MAX
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_WRONG_USAGE, "--solid is compared up to depth %d, not at depth %" PRIu64,
                              SOLID_CHECK_DEPTH_MAX, state->options.depth);
}

/* Makes the solid that --solid asks for and compares it. tree: downloaded, with SVO_NEED_RAYS. Returns the exit code,
   its line printed. Release the verdict in any case. */
static int solid_verdict_find(program *state, const session *opened, const svo_tree *tree, solid_verdict *out)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    svo_tree_get_info(tree, &info);
    svo_tree_get_arrays(tree, &arrays);
    *out = (solid_verdict){.made = {.solid = NULL}};
    const int exit_code = solid_make(state, opened->device, tree, &out->made);
    if (exit_code != PROGRAM_DONE || out->made.solid == NULL) {
        return exit_code;
    }
    progress_step(state->progress, "comparing the inside with the reference");
    if (svo_compact_download(out->made.solid, NULL) != SVO_OK) {
        return program_fail_library(state, svo_device_message(opened->device));
    }
    return solid_check(&info, &arrays, out->made.solid, &out->made.info, solid_rule(state), &out->found)
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_FAILED,
                              "%s: the comparison of the inside ran out of memory or the solid is malformed",
                              state->options.input);
}

static void solid_verdict_release(solid_verdict *verdict)
{
    solid_release(&verdict->made);
}

/* True without --solid. */
static bool solid_verdict_is_exact(const solid_verdict *verdict)
{
    return verdict->made.solid == NULL || solid_check_is_exact(&verdict->found);
}

/* The solid's table and what differs; nothing without --solid. */
static void solid_verdict_print(const program *state, const solid_verdict *verdict)
{
    const oracle_solid_difference *voxels = &verdict->found.voxels;
    if (verdict->made.solid == NULL) {
        return;
    }
    solid_print(state, &verdict->made);
    table_line("%s voxels are not as the reference says, of %s inside", figure_count(voxels->wrong_voxels).text,
               figure_count(voxels->inside_voxels).text);
    if (voxels->split_voxels > 0) {
        table_line("%s voxels lie on the other side than the one that decides their cell, for the surface is open",
                   figure_count(voxels->split_voxels).text);
    }
}

static void solid_verdict_add_json(cJSON *document, const program *state, const solid_verdict *verdict)
{
    if (verdict->made.solid == NULL) {
        return;
    }
    cJSON *object = solid_add_json(document, state, &verdict->made);
    json_add_count(object, "wrong_voxels", verdict->found.voxels.wrong_voxels);
    json_add_count(object, "split_voxels", verdict->found.voxels.split_voxels);
    cJSON_AddBoolToObject(object, "exact", solid_verdict_is_exact(verdict));
}

/* ---- the tree ---- */

/* Differences, all of which must be 0, and how much was compared. */
typedef struct verdict {
    tree_differences tree;
    bool snap_compared; /* false for a tree from a file: the grid that was asked for is missing */
    snap_differences snap;
    form_checks forms; /* none without --tree-form */
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

static void print_counts(const tree_differences *tree)
{
    const oracle_difference *difference = &tree->difference;
    table *rows = table_create("lrr");
    table_cell(rows, "%s", "");
    table_cell(rows, "voxels");
    table_cell(rows, "pairs");
    print_row(rows, "expected", tree->expected_voxels, tree->expected_pairs);
    print_row(rows, "built", tree->built_voxels, tree->built_pairs);
    print_row(rows, "missed", difference->missed_voxels, difference->missed_pairs);
    print_row(rows, "surplus", difference->surplus_voxels, difference->surplus_pairs);
    table_print(rows);
}

static void print_verdict(const program *state, const svo_tree_info *info, const verdict *found)
{
    table_heading("%s at depth %u against the exact reference", state->options.input, info->depth);
    print_counts(&found->tree);
    table_line("%s nodes differ", figure_count(found->tree.node_differences).text);
    if (found->snap_compared) {
        table_line("%s triangles are rounded differently, %u grid values differ",
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
        json_add_count(document, "rounding_differences", found->snap.triangles);
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
                        " rounded triangles differ",
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
    if (done == NULL && info.positions == SVO_POSITIONS_ROUNDED && info.coverage == SVO_COVERAGE_THIN) {
        return program_fail(state, PROGRAM_FAILED, "%s: the tree has no positions to compare with, give the mesh",
                            state->options.input);
    }
    bool good = true;
    progress_step(state->progress, "comparing rounded vertices");
    if (done != NULL) {
        found.snap_compared = true;
        good = snap_check(done->source.mesh, &state->options, &info, &arrays, &found.snap);
    }
    progress_step(state->progress, "comparing voxels with the reference");
    if (!good || !tree_check(done != NULL ? done->source.mesh : NULL, &info, &arrays, &found.tree)) {
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
    if (state->options.tree_form != 0 || state->options.solid != 0) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "option --%s does not apply to a .svo file, give the mesh",
                            state->options.tree_form != 0 ? "tree-form" : "solid");
    }
    if (input_is_compact(state)) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "%s is a compact tree, which has no leaf lists to compare; give the mesh, and --tree-form",
                            state->options.input);
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

/* ---- a folder of parts ---- */

#define REGIONS 100

static int report_parts(program *state, const parts_differences *found)
{
    const bool exact = found->missed_voxels == 0 && found->surplus_voxels == 0;
    if (state->options.json) {
        cJSON *document = json_document();
        json_add_text(document, "input", state->options.input);
        json_add_text(document, "parts", state->options.parts_path);
        json_add_count(document, "regions", found->regions);
        json_add_count(document, "expected_voxels", found->expected_voxels);
        json_add_count(document, "built_voxels", found->built_voxels);
        json_add_count(document, "missed_voxels", found->missed_voxels);
        json_add_count(document, "surplus_voxels", found->surplus_voxels);
        cJSON_AddBoolToObject(document, "exact", exact);
        const int exit_code = json_print(state, document);
        if (exit_code != PROGRAM_DONE) {
            return exit_code;
        }
    } else if (!state->options.quiet) {
        table_heading("%s in regions against the exact reference", state->options.parts_path);
        table *rows = table_create("lr");
        table_cell(rows, "regions");
        table_cell(rows, "%s", figure_count(found->regions).text);
        table_cell(rows, "voxels expected");
        table_cell(rows, "%s", figure_count(found->expected_voxels).text);
        table_cell(rows, "built");
        table_cell(rows, "%s", figure_count(found->built_voxels).text);
        table_cell(rows, "missed");
        table_cell(rows, "%s", figure_count(found->missed_voxels).text);
        table_cell(rows, "surplus");
        table_cell(rows, "%s", figure_count(found->surplus_voxels).text);
        table_print(rows);
    }
    return exact
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_FAILED,
                              "%s: not exact: %" PRIu64 " missed and %" PRIu64 " surplus voxels in %" PRIu64 " regions",
                              state->options.parts_path, found->missed_voxels, found->surplus_voxels, found->regions);
}

static int verify_parts(program *state)
{
    static const char where[] = "with --parts, whose tree is built";
    const size_t count = state->options.sample != 0 ? (size_t)state->options.sample : REGIONS;
    const char *folder = state->options.parts_path;
    input source = {0};
    svo_parts *parts = NULL;
    svo_parts_tree *tree = NULL;
    parts_differences found = {0};
    svo_message message = {""};
    int exit_code = options_refuse_groups(
        state, OPTION_BUILD | OPTION_METHODS | OPTION_DEVICE | OPTION_FORM | OPTION_SOLID | OPTION_UNFOLDED, where);
    if (exit_code == PROGRAM_DONE) {
        exit_code = parts_open(state, folder, &parts);
    }
    program_begin_progress(state, 2);
    if (exit_code == PROGRAM_DONE) {
        exit_code = input_open(state, &source);
    }
    if (exit_code == PROGRAM_DONE) {
        progress_step(state->progress, "comparing regions with the reference");
        svo_status status = svo_parts_tree_open(folder, &tree, &message);
        if (status == SVO_OK) {
            status = parts_check(parts, tree, source.mesh, count, state->options.seed, &found, &message);
        }
        exit_code = status == SVO_OK ? PROGRAM_DONE : parts_fail(state, status, message.text);
    }
    progress_destroy(&state->progress);
    svo_parts_tree_close(&tree);
    svo_parts_close(&parts);
    input_close(&source);
    return exit_code == PROGRAM_DONE ? report_parts(state, &found) : exit_code;
}

int command_verify(program *state)
{
    if (state->options.parts_path != NULL) {
        return verify_parts(state);
    }
    if (state->options.sample != 0) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--sample requires --parts");
    }
    if (input_is_tree(state)) {
        return verify_tree_file(state);
    }
    static const char *const of_alpha[] = {"drop-alpha", NULL};
    const uint32_t need = state->options.need & ~(uint32_t)SVO_NEED_NONE;
    job done;
    int exit_code = options_refuse(state, of_alpha, "to verify, which knows shapes alone");
    if (exit_code == PROGRAM_DONE) {
        exit_code = solid_verdict_check(state);
    }
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
