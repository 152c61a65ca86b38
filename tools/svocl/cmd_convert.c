/* SPDX-License-Identifier: MIT */
/* svocl convert: meshes, voxel files, point clouds and trees to voxel files, trees, compact trees, points and cubes. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "support/build_report.h"
#include "support/job.h"
#include "support/json.h"
#include "support/options_parse.h"
#include "support/output.h"
#include "support/parts_input.h"
#include "support/picture.h"
#include "support/table.h"
#include "support/tree_form.h"
#include "svocl/commands.h"
#include "svocl/voxel_scene.h"

/* What IN is. */
typedef enum source_kind { FROM_TREE = 0, FROM_VOXELS, FROM_MESH } source_kind;

/* What was read and written. */
typedef struct conversion {
    source_kind from;
    output_kind to;
    job made; /* the tree, on the device unless it is only read for its voxels; voxels that it was built of */
    voxel_input list; /* of a voxel file that becomes another, or of the leaves of the tree */
    solid_result solid;
    svo_compact *compact; /* where one is written that is not the solid's */
    svo_voxels_save_info written; /* format AUTO: a tree */
    svo_tree_info tree; /* where one was written */
    bool is_copy; /* a .vox file that is written again as it is: list has no voxels */
    bool is_region; /* of parts, whose bytes go to the file without a tree in memory */
} conversion;

/* ---- what does not apply ---- */

static source_kind kind_of_input(const program *state)
{
    return input_is_tree(state) ? FROM_TREE : voxel_input_is_given(state) ? FROM_VOXELS : FROM_MESH;
}

/* Options that neither IN nor OUT takes. */
static int check_options(program *state, const conversion *done)
{
    static const char *const none[] = {NULL};
    static const char *const of_axes[] = {"axes", NULL};
    static const char *const of_clouds[] = {"depth", "origin", "edge", "voxel-size", NULL};
    static const char *const of_lists[] = {"drop-alpha", NULL};
    const uint64_t all = OPTION_DEVICE | OPTION_JSON | OPTION_CONVERT_COMMAND | OPTION_UNFOLDED | OPTION_TREE_FORM;
    if (done->from == FROM_TREE) {
        const int exit_code = options_take_only(state, all | OPTION_LEVELS, none, "to IN that is a finished tree");
        return exit_code == PROGRAM_DONE && done->to != OUTPUT_VOXELS
                   ? options_refuse(state, of_axes, "from a tree to a tree")
                   : exit_code;
    }
    if (done->from == FROM_VOXELS && done->to == OUTPUT_VOXELS) {
        return options_take_only(state, all | OPTION_VOXELS, points_input_is_given(state) ? of_clouds : none,
                                 "from voxels to voxels");
    }
    return solid_is_wanted(state)
               ? options_refuse(state, of_lists, "with --solid, which counts crossings of the whole surface")
               : PROGRAM_DONE;
}

static int check_arguments(program *state, const conversion *done)
{
    const options *given = &state->options;
    if (given->compress && done->to == OUTPUT_VOXELS) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--compress applies to .svo and .svc, not to OUT %s",
                            given->output_path);
    }
    const svo_voxel_format format = svo_voxel_format_of_path(given->output_path);
    if (given->merge && format != SVO_VOXEL_FORMAT_PLY && format != SVO_VOXEL_FORMAT_OBJ) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--merge applies to .ply and .obj, not to OUT %s",
                            given->output_path);
    }
    if (done->to != OUTPUT_VOXELS &&
        !output_has_suffix(given->output_path, done->to == OUTPUT_TREE ? ".svo" : ".svc")) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "output %s has no suffix that tells the format",
                            given->output_path);
    }
    const int exit_code = check_options(state, done);
    return exit_code == PROGRAM_DONE ? output_check(state, given->output_path) : exit_code;
}

/* ---- reading ---- */

/* A finished tree, on a device where it is not its voxels alone that are needed. */
static int load_tree(program *state, conversion *done)
{
    job *made = &done->made;
    int exit_code = input_load_tree(state, &made->result.tree);
    if (exit_code != PROGRAM_DONE || done->to != OUTPUT_COMPACT) {
        return exit_code;
    }
    exit_code = session_open_device(state, &made->opened);
    return exit_code != PROGRAM_DONE ||
                   svo_tree_upload(made->result.tree, made->opened.device, made->opened.queue) == SVO_OK
               ? exit_code
               : program_fail_library(state, svo_device_message(made->opened.device));
}

/* The svo_need bits of a build: of its voxels colors alone are written. */
static uint32_t need_of(const program *state, const conversion *done)
{
    const uint32_t asked = state->options.need;
    const bool is_open = done->to == OUTPUT_VOXELS && asked == (uint32_t)SVO_NEED_DEFAULT;
    return solid_need(state, is_open ? (uint32_t)SVO_NEED_COLOR : asked);
}

/* Where voxels are wanted of a solid, the solid's tree takes the place of the surface's. */
static int fill(program *state, conversion *done)
{
    job *made = &done->made;
    int exit_code = solid_make(state, made->opened.device, made->result.tree, &done->solid);
    if (exit_code != PROGRAM_DONE || done->solid.solid == NULL || done->to != OUTPUT_VOXELS) {
        return exit_code;
    }
    svo_tree_destroy(&made->result.tree);
    return svo_compact_expand(done->solid.solid, made->opened.queue, &made->result.tree) == SVO_OK &&
                   svo_tree_download(made->result.tree, made->opened.queue) == SVO_OK
               ? PROGRAM_DONE
               : program_fail_library(state, svo_device_message(made->opened.device));
}

static int build_tree(program *state, conversion *done)
{
    uint32_t need = need_of(state, done);
    int exit_code = job_open(state, need, 3, &done->made);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (solid_is_wanted(state) && state->options.need == (uint32_t)SVO_NEED_DEFAULT) {
        need |= picture_need(&done->made.source, SVO_NEED_DEFAULT); /* what the default means beside the solid's bits */
    }
    exit_code = job_build(state, need, &done->made);
    return exit_code == PROGRAM_DONE ? fill(state, done) : exit_code;
}

/* The leaves of the tree, as a list. */
static int list_leaves(program *state, conversion *done)
{
    voxel_input *list = &done->list;
    svo_message message = {""};
    if (svo_tree_get_voxels(done->made.result.tree, &list->voxels, &message) != SVO_OK) {
        return program_fail_library(state, message.text);
    }
    (void)svo_voxels_set_axes(list->voxels, (svo_axes)state->options.axes);
    list->list = (svo_voxels_info)SVO_VOXELS_INFO_INIT;
    (void)svo_voxels_get_info(list->voxels, &list->list);
    return PROGRAM_DONE;
}

static int read_source(program *state, conversion *done)
{
    if (done->from == FROM_VOXELS && done->to == OUTPUT_VOXELS) {
        program_begin_progress(state, 2);
        progress_step(state->progress, "reading the voxels");
        return voxel_input_open(state, &done->list);
    }
    if (done->from == FROM_TREE) {
        program_begin_progress(state, 3);
    }
    const int exit_code = done->from == FROM_TREE ? load_tree(state, done) : build_tree(state, done);
    return exit_code == PROGRAM_DONE && done->to == OUTPUT_VOXELS ? list_leaves(state, done) : exit_code;
}

/* ---- writing ---- */

/* What OUT is in place of the tree; NULL: the tree. */
static svo_compact *compact_of(const conversion *done)
{
    const bool is_solid = done->compact == NULL && done->to == OUTPUT_COMPACT;
    return is_solid ? done->solid.solid : done->compact;
}

/* The solid, the compact tree of IN where that fits, or else the tree, in the form that --tree-form names. */
static int make_compact(program *state, conversion *done)
{
    const session *opened = &done->made.opened;
    int exit_code = PROGRAM_DONE;
    if (done->from == FROM_TREE && input_is_compact(state)) {
        exit_code = input_load_compact(state, &done->compact);
        if (exit_code != PROGRAM_DONE) {
            return exit_code;
        }
        if (tree_form_keeps(state, done->compact)) {
            return tree_form_pack(state, opened, &done->compact);
        }
        svo_compact_destroy(&done->compact);
    }
    if (state->options.tree_form != 0) {
        exit_code = done->solid.solid != NULL ? tree_form_change(state, opened, &done->solid.solid)
                                              : tree_form_make(state, opened, done->made.result.tree, &done->compact);
    }
    return exit_code != PROGRAM_DONE || svo_compact_download(compact_of(done), opened->queue) == SVO_OK
               ? exit_code
               : program_fail_library(state, svo_device_message(opened->device));
}

static int write_tree(program *state, conversion *done)
{
    const svo_tree *tree = done->made.result.tree;
    done->tree = (svo_tree_info)SVO_TREE_INFO_INIT;
    (void)svo_tree_get_info(tree, &done->tree);
    const int exit_code = done->to == OUTPUT_COMPACT ? make_compact(state, done) : PROGRAM_DONE;
    return exit_code == PROGRAM_DONE ? tree_output_write(state, tree, compact_of(done), state->options.output_path)
                                     : exit_code;
}

static int write_file(program *state, conversion *done)
{
    output_file file;
    svo_message message = {""};
    const char *path = state->options.output_path;
    progress_step(state->progress, "writing the voxels");
    const int exit_code = output_open(state, path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    const svo_voxel_format format = svo_voxel_format_of_path(path);
    const svo_sink sink = output_sink(&file);
    const svo_status status = state->options.merge
                                  ? svo_voxels_save_faces(done->list.voxels, sink, format, &done->written, &message)
                                  : svo_voxels_save(done->list.voxels, sink, format, &done->written, &message);
    if (status != SVO_OK && file.error == 0) { /* else output_commit reports it */
        output_abandon(&file);
        return program_fail(state, PROGRAM_FAILED, "%s: %s", path, program_words(message.text));
    }
    return output_commit(state, &file);
}

/* Whether parts become a .svo file as they are. */
static bool wants_region(const program *state, const conversion *done)
{
    return input_is_parts(state) && done->to == OUTPUT_TREE && !state->options.compress;
}

static int write_region(program *state, conversion *done)
{
    output_file file;
    svo_parts_region region;
    svo_parts_tree *tree = NULL;
    svo_message message = {""};
    done->is_region = true;
    done->tree = (svo_tree_info)SVO_TREE_INFO_INIT;
    progress_step(state->progress, "writing the tree");
    int exit_code = parts_input_region(state, &region);
    if (exit_code == PROGRAM_DONE) {
        exit_code = parts_input_open(state, &tree);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = output_open(state, state->options.output_path, &file);
    }
    if (exit_code == PROGRAM_DONE) {
        const svo_status status = svo_parts_tree_save(tree, &region, output_sink(&file), &done->tree, &message);
        if (status != SVO_OK && file.error == 0) { /* else output_commit reports it */
            output_abandon(&file);
            exit_code = parts_input_fail(state, status, &message);
        } else {
            exit_code = output_commit(state, &file);
        }
    }
    svo_parts_tree_close(&tree);
    return exit_code;
}

/* Whether a .vox file becomes a .vox file without a choice of its parts: then it keeps all that it holds. */
static bool wants_copy(const program *state, const conversion *done)
{
    const options *given = &state->options;
    const char *name = piped_is(&state->piped, given->input) ? state->piped.suffix : given->input;
    return done->from == FROM_VOXELS && svo_voxel_format_of_path(given->output_path) == SVO_VOXEL_FORMAT_VOX &&
           svo_voxel_format_of_path(name) == SVO_VOXEL_FORMAT_VOX && !options_is_given(given, "hidden") &&
           !options_is_given(given, "frame");
}

/* Writes the file again; done->is_copy: whether it could, which other formats with that suffix cannot. */
static int copy_file(program *state, conversion *done)
{
    output_file file;
    svo_message message = {""};
    program_begin_progress(state, 1);
    progress_step(state->progress, "copying the voxels");
    int exit_code = input_measure(state, &done->written.bytes);
    if (exit_code == PROGRAM_DONE) {
        exit_code = output_open(state, state->options.output_path, &file);
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    const svo_status status = voxel_input_copy(state, output_sink(&file), &done->list, &message);
    if (status != SVO_OK && file.error == 0) { /* else output_commit reports it */
        output_abandon(&file);
        return status == SVO_UNSUPPORTED ? PROGRAM_DONE : program_fail_library(state, message.text);
    }
    done->is_copy = true;
    done->written.format = SVO_VOXEL_FORMAT_VOX;
    done->written.models = done->list.file.models;
    return output_commit(state, &file);
}

/* ---- the report ---- */

/* The list that was read or written; its voxels are NULL between a mesh or a tree and a tree. */
static const voxel_input *list_of(const conversion *done)
{
    return done->is_copy || done->list.voxels != NULL ? &done->list : &done->made.source.voxels;
}

/* Parts of a list that a format may not hold. */
#define PARTS_MAX 6

/* Whether voxels do not begin at whole multiples of their width. */
static bool is_between(const svo_voxels_info *list)
{
    bool between = false;
    for (int axis = 0; axis < 3; ++axis) {
        between = between || rint(list->origin[axis] / list->voxel_edge) * list->voxel_edge != list->origin[axis];
    }
    return between;
}

/* What the list has and the format does not. Returns how many parts it is. */
static size_t find_left_out(const conversion *done, const char *out[PARTS_MAX])
{
    const svo_voxels_info *list = &list_of(done)->list;
    if (list_of(done)->voxels == NULL) {
        return 0;
    }
    const svo_voxel *voxels = svo_voxels_get(list_of(done)->voxels);
    const bool moved =
        list->voxel_edge != 1.0 || list->origin[0] != 0.0 || list->origin[1] != 0.0 || list->origin[2] != 0.0;
    bool colors = false;
    bool alpha = false;
    for (uint64_t i = 0; i < list->voxel_count; ++i) {
        const uint8_t *rgba = voxels[i].rgba;
        colors = colors || rgba[0] != 255 || rgba[1] != 255 || rgba[2] != 255;
        alpha = alpha || rgba[3] != 255;
    }
    const uint32_t format = done->written.format;
    const bool binvox = format == SVO_VOXEL_FORMAT_BINVOX;
    const bool svx = format == SVO_VOXEL_FORMAT_SVX;
    const bool obj = format == SVO_VOXEL_FORMAT_OBJ;
    const bool vox = format == SVO_VOXEL_FORMAT_VOX;
    const bool bt = format == SVO_VOXEL_FORMAT_BT;
    const bool vdb = format == SVO_VOXEL_FORMAT_VDB;
    const bool faces = done->written.voxel_faces > 0;
    const char *const parts[PARTS_MAX] = {
        colors && (binvox || bt) ? "colors" : NULL,
        alpha && (binvox || svx || obj || bt || vdb) ? "alpha" : NULL,
        list->material_count > 1 && (binvox || obj || bt || faces || (svx && list->material_count > 256)) ? "materials"
                                                                                                          : NULL,
        list->property_count > 0 && !vox ? "properties of materials" : NULL,
        svo_voxels_get_normals(list_of(done)->voxels) != NULL ? "normals" : NULL,
        moved && vox             ? "the place and the width of voxels"
        : bt && is_between(list) ? "the places between whole multiples of the width"
                                 : NULL};
    size_t count = 0;
    for (size_t i = 0; i < PARTS_MAX; ++i) {
        if (parts[i] != NULL) {
            out[count++] = parts[i];
        }
    }
    return count;
}

static void add_counts(cJSON *object, const conversion *done)
{
    const svo_voxels_save_info *written = &done->written;
    if (done->to != OUTPUT_VOXELS) {
        json_add_text(object, "format", done->to == OUTPUT_COMPACT ? "svc" : "svo");
        json_add_count(object, "depth", done->tree.depth);
        json_add_count(object, "leaves", done->tree.leaf_count);
        json_add_count(object, "nodes", done->tree.node_count);
        if (done->to == OUTPUT_COMPACT) {
            tree_form_add_json(object, compact_of(done));
        }
        return;
    }
    json_add_text(object, "format", svo_name(SVO_NAME_VOXEL_FORMAT, (svo_voxel_format)written->format));
    json_add_count(object, "bytes", written->bytes);
    json_add_count(object, "models", written->models);
    cJSON_AddBoolToObject(object, "is_copy", done->is_copy);
    if (done->is_copy) {
        return;
    }
    json_add_count(object, "colors", written->colors);
    json_add_count(object, "color_error", written->color_error);
    json_add_count(object, "faces", written->faces);
    json_add_count(object, "voxel_faces", written->voxel_faces);
}

static void add_written(cJSON *document, const conversion *done)
{
    cJSON *object = cJSON_AddObjectToObject(document, "written");
    add_counts(object, done);
    const char *parts[PARTS_MAX];
    const int count = (int)find_left_out(done, parts);
    cJSON_AddItemToObject(object, "left_out", cJSON_CreateStringArray(parts, count));
}

/* The parts in words; "": none is left out. */
typedef struct parts_text {
    char text[128];
} parts_text;

static parts_text words_of_left_out(const conversion *done)
{
    parts_text words = {""};
    const char *parts[PARTS_MAX];
    const size_t count = find_left_out(done, parts);
    size_t used = 0;
    for (size_t i = 0; i < count; ++i) {
        used += (size_t)snprintf(words.text + used, sizeof words.text - used, "%s%s", i > 0 ? ", " : "", parts[i]);
    }
    return words;
}

static void add_left_out_row(table *rows, const conversion *done)
{
    const parts_text words = words_of_left_out(done);
    if (words.text[0] != '\0') {
        table_cell(rows, "left out");
        table_cell(rows, "%s", words.text);
    }
}

/* What was written, as a row of the table. */
static void add_written_row(table *rows, const conversion *done)
{
    const svo_voxels_save_info *written = &done->written;
    table_cell(rows, "written");
    if (done->to != OUTPUT_VOXELS) {
        table_cell(rows, "%s leaves, %s nodes, depth %u", figure_count(done->tree.leaf_count).text,
                   figure_count(done->tree.node_count).text, done->tree.depth);
    } else if (done->is_copy) {
        table_cell(rows, "%s; all that the file holds", figure_bytes(written->bytes).text);
    } else if (written->voxel_faces > 0) {
        table_cell(rows, "%s rectangles of %s faces, %s", figure_count(written->faces).text,
                   figure_count(written->voxel_faces).text, figure_bytes(written->bytes).text);
    } else if (written->format == SVO_VOXEL_FORMAT_OBJ) {
        table_cell(rows, "%s faces, %s", figure_count(written->faces).text, figure_bytes(written->bytes).text);
    } else if (written->format == SVO_VOXEL_FORMAT_VOX) {
        table_cell(rows, "%s; models: %s; colors: %s", figure_bytes(written->bytes).text,
                   figure_count(written->models).text, figure_count(written->colors).text);
        if (written->color_error > 0) {
            table_cell(rows, "%s", "");
            table_cell(rows, "255 colors are kept; others differ by at most %u in a component", written->color_error);
        }
    } else {
        table_cell(rows, "%s", figure_bytes(written->bytes).text);
    }
    if (done->to == OUTPUT_COMPACT) {
        tree_form_add_rows(rows, compact_of(done));
    }
    add_left_out_row(rows, done);
}

/* The leaves of what is no voxel file: of the list, or of the tree. */
static uint64_t leaves_of(const conversion *done)
{
    return done->list.voxels != NULL ? done->list.list.voxel_count : done->tree.leaf_count;
}

static int report_json(program *state, const conversion *done)
{
    const options *given = &state->options;
    cJSON *document = json_document();
    json_add_text(document, "input", given->input);
    json_add_text(document, "file", given->output_path);
    if (done->from == FROM_VOXELS) {
        voxel_input_add_json(document, list_of(done));
    } else {
        json_add_count(document, "leaves", leaves_of(done));
    }
    add_written(document, done);
    solid_add_json(document, state, &done->solid);
    return json_print(state, document);
}

static void report_text(const program *state, const conversion *done)
{
    const svo_voxels_info *list = &list_of(done)->list;
    table_heading("%s -> %s", state->options.input, output_name(state->options.output_path));
    table *rows = table_create("ll");
    if (done->from == FROM_VOXELS) {
        voxel_input_add_rows(rows, list_of(done));
    } else {
        table_cell(rows, "leaves");
        table_cell(rows, "%s", figure_count(leaves_of(done)).text);
    }
    if (list->voxel_count > 0) {
        table_cell(rows, "bounds");
        table_cell(rows, "%d, %d, %d to %d, %d, %d", list->low[0], list->low[1], list->low[2], list->high[0],
                   list->high[1], list->high[2]);
    }
    add_written_row(rows, done);
    table_print(rows);
    solid_print(state, &done->solid);
}

static int report(program *state, const conversion *done)
{
    progress_destroy(&state->progress);
    if (!done->is_copy) {
        voxel_input_warn(state, list_of(done), words_of_left_out(done).text);
    }
    if (state->options.json) {
        return report_json(state, done);
    }
    if (!state->options.quiet) {
        report_text(state, done);
    }
    return PROGRAM_DONE;
}

int command_convert(program *state)
{
    conversion done = {.from = kind_of_input(state), .written = SVO_VOXELS_SAVE_INFO_INIT};
    if (state->options.output_path == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "OUT is missing, see svocl convert --help");
    }
    if (voxel_scene_is_output(state)) {
        return voxel_scene_convert(state);
    }
    done.to = output_kind_of(&state->options, state->options.output_path);
    int exit_code = check_arguments(state, &done);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (wants_copy(state, &done)) {
        exit_code = copy_file(state, &done);
    } else if (wants_region(state, &done)) {
        exit_code = write_region(state, &done);
    }
    const bool is_written = done.is_copy || done.is_region;
    if (exit_code == PROGRAM_DONE && !is_written) {
        exit_code = read_source(state, &done);
    }
    if (exit_code == PROGRAM_DONE && !is_written) {
        exit_code = done.to == OUTPUT_VOXELS ? write_file(state, &done) : write_tree(state, &done);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = report(state, &done);
    }
    svo_compact_destroy(&done.compact);
    solid_release(&done.solid);
    voxel_input_close(&done.list);
    job_release(&done.made);
    return exit_code;
}
