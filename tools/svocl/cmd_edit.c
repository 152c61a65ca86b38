/* SPDX-License-Identifier: MIT */
/* svocl edit: the steps of a script, on the voxels of a file or of a tree, to a file of voxels or a tree. */
#include <stdio.h>
#include <string.h>

#include "support/info_of.h"
#include "support/job.h"
#include "support/json.h"
#include "support/options_parse.h"
#include "support/output.h"
#include "support/table.h"
#include "support/tree_form.h"
#include "svocl/commands.h"
#include "svocl/edit_mesh.h"
#include "svocl/edit_script.h"

/* What was read, made and written. */
typedef struct editing {
    const char *script_path;
    output_kind to;
    svo_edit *edit;
    uint64_t voxels_before;
    uint64_t step_count;
    double edit_ms; /* of the steps, without what they read */
    svo_edit_info info; /* after the last one */
    job made; /* source.voxels: the edited ones, where a list is needed */
    svo_compact *compact;
    svo_voxels_save_info written;
    svo_tree_info tree;
} editing;

/* ---- voxels ---- */

/* The voxels of a file, or the leaves of a tree's. name takes the place of INPUT meanwhile. */
static int read_voxels(program *state, const char *name, voxel_input *out)
{
    svo_tree *tree = NULL;
    svo_message message = {""};
    const char *before = state->options.input;
    state->options.input = name;
    *out = (voxel_input){.list = SVO_VOXELS_INFO_INIT};
    int exit_code = PROGRAM_DONE;
    if (voxel_input_is_given(state)) {
        exit_code = voxel_input_open(state, out);
    } else if (!input_is_tree(state)) {
        exit_code = program_fail(state, PROGRAM_WRONG_USAGE, "%s is no file of voxels or of a tree", name);
    } else {
        exit_code = input_load_tree(state, &tree);
        if (exit_code == PROGRAM_DONE && svo_tree_get_voxels(tree, &out->voxels, &message) != SVO_OK) {
            exit_code = program_fail_library(state, message.text);
        }
        svo_tree_destroy(&tree);
    }
    state->options.input = before;
    return exit_code;
}

static int create_edit(program *state, const voxel_input *opened, svo_edit **out)
{
    svo_message message = {""};
    const svo_edit_options asked = {.struct_size = sizeof asked, .max_bytes = state->options.max_memory};
    return svo_edit_create(opened->voxels, &asked, out, &message) == SVO_OK ? PROGRAM_DONE
                                                                            : program_fail_library(state, message.text);
}

/* ---- steps ---- */

static int fail_step(program *state, const edit_script *script, const svo_message *message)
{
    return edit_script_fail(state, script, PROGRAM_FAILED, program_words(message->text));
}

/* The voxels of the file that a step names. */
static int read_operand(program *state, const edit_script *script, const script_step *step, session *opened,
                        voxel_input *out)
{
    if (!step->is_mesh) {
        return read_voxels(state, step->file, out);
    }
    *out = (voxel_input){.list = SVO_VOXELS_INFO_INIT};
    return edit_mesh_make(state, script, step, opened, &out->voxels);
}

static int apply_file(program *state, const edit_script *script, script_step *step, editing *done)
{
    voxel_input opened;
    svo_edit *other = NULL;
    svo_message message = {""};
    int exit_code = output_protect(state, step->file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = read_operand(state, script, step, &done->made.opened, &opened);
    if (exit_code == PROGRAM_DONE) {
        exit_code = create_edit(state, &opened, &other);
    }
    voxel_input_close(&opened);
    step->step.other = other;
    if (exit_code == PROGRAM_DONE && svo_edit_apply(done->edit, &step->step, &message) != SVO_OK) {
        exit_code = fail_step(state, script, &message);
    }
    svo_edit_destroy(&other);
    return exit_code;
}

static int go_back_or_forth(program *state, const edit_script *script, const script_step *step, svo_edit *edit)
{
    const bool is_undo = step->action == SCRIPT_UNDO;
    for (uint32_t i = 0; i < step->count; ++i) {
        if ((is_undo ? svo_edit_undo(edit) : svo_edit_redo(edit)) != SVO_OK) {
            return edit_script_fail(state, script, PROGRAM_FAILED,
                                    is_undo ? "there is no step to undo" : "there is no step to redo");
        }
    }
    return PROGRAM_DONE;
}

static int do_step(program *state, const edit_script *script, script_step *step, editing *done)
{
    svo_edit *edit = done->edit;
    svo_message message = {""};
    switch (step->action) {
    case SCRIPT_UNDO:
    case SCRIPT_REDO:
        return go_back_or_forth(state, script, step, edit);
    case SCRIPT_COPY:
        return svo_edit_copy(edit, &step->step, step->offset, &message) == SVO_OK ? PROGRAM_DONE
                                                                                  : fail_step(state, script, &message);
    default:
        if (step->file != NULL) {
            return apply_file(state, script, step, done);
        }
        return svo_edit_apply(edit, &step->step, &message) == SVO_OK ? PROGRAM_DONE
                                                                     : fail_step(state, script, &message);
    }
}

static int run_script(program *state, editing *done)
{
    edit_script script;
    script_step step;
    int exit_code = edit_script_open(state, done->script_path, &script);
    progress_step(state->progress, "editing");
    while (exit_code == PROGRAM_DONE) {
        exit_code = edit_script_next(state, &script, &step);
        if (exit_code != PROGRAM_DONE || step.action == SCRIPT_END) {
            break;
        }
        const double started_ms = input_now_ms();
        exit_code = do_step(state, &script, &step, done);
        done->edit_ms += step.file == NULL ? input_now_ms() - started_ms : 0.0;
        ++done->step_count;
    }
    edit_script_close(&script);
    return exit_code;
}

/* Edits INPUT. */
static int edit_voxels(program *state, editing *done)
{
    voxel_input opened;
    progress_step(state->progress, "reading the voxels");
    int exit_code = read_voxels(state, state->options.input, &opened);
    if (exit_code == PROGRAM_DONE) {
        exit_code = create_edit(state, &opened, &done->edit);
    }
    if (exit_code == PROGRAM_DONE) {
        voxel_input_warn(state, &opened, NULL);
    }
    voxel_input_close(&opened);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    done->info = (svo_edit_info)SVO_EDIT_INFO_INIT;
    (void)svo_edit_get_info(done->edit, &done->info);
    done->voxels_before = done->info.voxel_count;
    exit_code = run_script(state, done);
    (void)svo_edit_get_info(done->edit, &done->info);
    return exit_code;
}

/* The edited voxels become a list, the source of a build. */
static int list_voxels(program *state, editing *done)
{
    svo_message message = {""};
    voxel_input *result = &done->made.source.voxels;
    done->made.source.name = state->options.input;
    if (svo_edit_get_voxels(done->edit, &result->voxels, &message) != SVO_OK) {
        return program_fail_library(state, message.text);
    }
    svo_edit_destroy(&done->edit);
    result->list = (svo_voxels_info)SVO_VOXELS_INFO_INIT;
    (void)svo_voxels_get_info(result->voxels, &result->list);
    if (options_is_given(&state->options, "axes")) {
        (void)svo_voxels_set_axes(result->voxels, (svo_axes)state->options.axes);
    }
    return PROGRAM_DONE;
}

/* ---- writing ---- */

static int write_file(program *state, editing *done)
{
    output_file file;
    svo_message message = {""};
    const char *path = state->options.output_path;
    int exit_code = list_voxels(state, done);
    progress_step(state->progress, "writing the voxels");
    if (exit_code == PROGRAM_DONE) {
        exit_code = output_open(state, path, &file);
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (svo_voxels_save(done->made.source.voxels.voxels, output_sink(&file), svo_voxel_format_of_path(path),
                        &done->written, &message) != SVO_OK &&
        file.error == 0) { /* else output_commit reports it */
        output_abandon(&file);
        return program_fail(state, PROGRAM_FAILED, "%s: %s", path, program_words(message.text));
    }
    return output_commit(state, &file);
}

static svo_plan_options tree_options(const program *state)
{
    const options *given = &state->options;
    return (svo_plan_options){.struct_size = sizeof(svo_plan_options),
                              .need = given->need,
                              .payload_level = (uint32_t)given->payload_level,
                              .progress = state->progress != NULL ? job_show_progress : NULL,
                              .progress_user = state->progress};
}

static unsigned depth_of(const program *state)
{
    return state->options.has_depth ? (unsigned)state->options.depth : 0;
}

/* Without kernels, unless a builder is asked for. */
static int make_tree(program *state, editing *done)
{
    build_result *result = &done->made.result;
    const session *opened = &done->made.opened;
    const svo_plan_options asked = tree_options(state);
    if (state->options.has_builder) {
        const int exit_code = list_voxels(state, done);
        return exit_code == PROGRAM_DONE ? job_build(state, state->options.need, &done->made) : exit_code;
    }
    progress_step(state->progress, "writing the tree");
    if (svo_edit_commit(done->edit, opened->device, depth_of(state), &asked, opened->queue, &result->tree, NULL) !=
            SVO_OK ||
        svo_tree_download(result->tree, opened->queue) != SVO_OK) {
        return program_fail_library(state, svo_device_message(opened->device));
    }
    result->info = (svo_tree_info)SVO_TREE_INFO_INIT;
    (void)svo_tree_get_info(result->tree, &result->info);
    return PROGRAM_DONE;
}

/* A compact tree at once, whose nodes are those of the tree. */
static int make_compact(program *state, editing *done)
{
    const session *opened = &done->made.opened;
    const svo_plan_options asked = tree_options(state);
    const svo_compact_options form = tree_form_options(&state->options);
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    progress_step(state->progress, "writing the tree");
    if (svo_edit_commit_compact(done->edit, opened->device, depth_of(state), &asked, &form, opened->queue,
                                &done->compact) != SVO_OK) {
        return program_fail_library(state, svo_device_message(opened->device));
    }
    (void)svo_compact_get_info(done->compact, &info);
    done->made.result.info = (svo_tree_info){
        .depth = info.depth, .leaf_count = info.leaf_count, .node_count = info.inner_count + info.leaf_count};
    return tree_form_pack(state, opened, &done->compact);
}

static int make_output(program *state, editing *done)
{
    const session *opened = &done->made.opened;
    const bool is_direct = !state->options.has_builder && tree_form_options(&state->options).minimize == 0;
    int exit_code = done->to == OUTPUT_COMPACT && is_direct ? make_compact(state, done) : make_tree(state, done);
    if (exit_code == PROGRAM_DONE && done->to == OUTPUT_COMPACT && done->compact == NULL) {
        exit_code = tree_form_make(state, opened, done->made.result.tree, &done->compact);
    }
    return exit_code != PROGRAM_DONE || done->compact == NULL ||
                   svo_compact_download(done->compact, opened->queue) == SVO_OK
               ? exit_code
               : program_fail_library(state, svo_device_message(opened->device));
}

static int write_tree(program *state, editing *done)
{
    job *made = &done->made;
    int exit_code = made->opened.device != NULL ? PROGRAM_DONE : session_open(state, &made->opened);
    if (exit_code == PROGRAM_DONE) {
        exit_code = make_output(state, done);
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    done->tree = made->result.info;
    return tree_output_write(state, made->result.tree, done->compact, state->options.output_path);
}

/* ---- the report ---- */

static int report_json(program *state, const editing *done)
{
    cJSON *document = json_document();
    json_add_text(document, "input", state->options.input);
    json_add_text(document, "script", done->script_path);
    json_add_text(document, "file", state->options.output_path);
    json_add_count(document, "steps", done->step_count);
    json_add_count(document, "voxels_before", done->voxels_before);
    json_add_count(document, "voxels", done->info.voxel_count);
    cJSON_AddNumberToObject(document, "edit_ms", done->edit_ms);
    json_add_count(document, "edit_bytes", done->info.peak_bytes);
    cJSON *object = cJSON_AddObjectToObject(document, "written");
    if (done->to == OUTPUT_VOXELS) {
        json_add_count(object, "bytes", done->written.bytes);
    } else {
        json_add_count(object, "leaves", done->tree.leaf_count);
        json_add_count(object, "nodes", done->tree.node_count);
        json_add_count(object, "depth", done->tree.depth);
    }
    if (done->compact != NULL) {
        tree_form_add_json(document, done->compact);
    }
    return json_print(state, document);
}

static int report(program *state, const editing *done)
{
    progress_destroy(&state->progress);
    if (state->options.json) {
        return report_json(state, done);
    }
    if (state->options.quiet) {
        return PROGRAM_DONE;
    }
    table_heading("%s -> %s", state->options.input, output_name(state->options.output_path));
    table *rows = table_create("ll");
    table_cell(rows, "steps");
    table_cell(rows, "%s in %s", figure_count(done->step_count).text, figure_ms(done->edit_ms).text);
    table_cell(rows, "voxels");
    table_cell(rows, "%s, before %s", figure_count(done->info.voxel_count).text,
               figure_count(done->voxels_before).text);
    table_cell(rows, "memory");
    table_cell(rows, "%s at most", figure_bytes(done->info.peak_bytes).text);
    table_cell(rows, "written");
    if (done->to == OUTPUT_VOXELS) {
        table_cell(rows, "%s", figure_bytes(done->written.bytes).text);
    } else {
        table_cell(rows, "%s leaves, %s nodes, depth %u", figure_count(done->tree.leaf_count).text,
                   figure_count(done->tree.node_count).text, done->tree.depth);
    }
    if (done->compact != NULL) {
        tree_form_add_rows(rows, done->compact);
    }
    table_print(rows);
    return PROGRAM_DONE;
}

/* ---- the command ---- */

static int check_arguments(program *state, const editing *done)
{
    static const char *const of_trees[] = {"depth", "need", "builder", "payload-level", "compress", NULL};
    const options *given = &state->options;
    if (done->script_path == NULL || given->output_path == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "%s is missing, see svocl edit --help",
                            done->script_path == NULL ? "SCRIPT" : "-o OUT");
    }
    if (!input_is_tree(state) && !voxel_input_is_given(state)) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "%s is no file of voxels or of a tree; svocl convert makes one of a mesh", given->input);
    }
    const uint32_t of_trees_alone = input_is_tree(state) ? (uint32_t)SVO_NEED_NORMAL : 0u;
    int exit_code = voxel_input_check_options(state, given->need & ~of_trees_alone);
    if (exit_code == PROGRAM_DONE && done->to == OUTPUT_VOXELS) {
        exit_code = options_refuse(state, of_trees, "to OUT that holds voxels");
    }
    return exit_code == PROGRAM_DONE ? output_check(state, given->output_path) : exit_code;
}

int command_edit(program *state)
{
    editing done = {.script_path = state->options.second_input, .written = SVO_VOXELS_SAVE_INFO_INIT};
    if (state->options.output_path != NULL) {
        done.to = output_kind_of(&state->options, state->options.output_path);
    }
    int exit_code = check_arguments(state, &done);
    if (exit_code == PROGRAM_DONE) {
        program_begin_progress(state, done.to == OUTPUT_VOXELS ? 3 : done.to == OUTPUT_COMPACT ? 6 : 5);
        exit_code = edit_voxels(state, &done);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = done.to == OUTPUT_VOXELS ? write_file(state, &done) : write_tree(state, &done);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = report(state, &done);
    }
    svo_edit_destroy(&done.edit);
    svo_compact_destroy(&done.compact);
    job_release(&done.made);
    return exit_code;
}
