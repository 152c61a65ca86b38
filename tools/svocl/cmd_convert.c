/* SPDX-License-Identifier: MIT */
/* svocl convert: voxel files and trees to voxel files, trees, points and cubes. */
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "support/input.h"
#include "support/json.h"
#include "support/output.h"
#include "support/session.h"
#include "support/table.h"
#include "svocl/commands.h"

/* What was read and written. */
typedef struct conversion {
    voxel_input source;
    bool from_tree;
    svo_voxels_save_info written; /* format AUTO: a tree */
    svo_tree_info tree; /* where one was written */
} conversion;

static bool is_tree_path(const char *path)
{
    const size_t length = strlen(path);
    return length >= 4 && strcasecmp(path + length - 4, ".svo") == 0;
}

static int check_arguments(program *state)
{
    const options *given = &state->options;
    if (given->output_path == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "OUT is missing, see svocl convert --help");
    }
    if (!input_is_tree(state) && !voxel_input_is_given(state)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "IN %s is not .vox, .svx, .binvox or .svo", given->input);
    }
    if (input_is_tree(state) && (given->given_groups & (unsigned)OPTION_VOXELS) != 0) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--hidden and --frame do not apply to a tree, IN %s",
                            given->input);
    }
    if (!input_is_tree(state) && given->last_level != 0) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--levels applies to .svo files, not to IN %s", given->input);
    }
    const bool to_tree = is_tree_path(given->output_path);
    if (!to_tree && svo_voxel_format_of_path(given->output_path) == SVO_VOXEL_FORMAT_AUTO) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "output %s has no suffix that tells the format",
                            given->output_path);
    }
    if (given->compress && !to_tree) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--compress applies to .svo, not to OUT %s",
                            given->output_path);
    }
    return output_check(state, given->output_path);
}

/* The voxels of a finished tree. */
static int read_tree(program *state, voxel_input *source)
{
    svo_tree *tree = NULL;
    svo_message message = {""};
    int exit_code = input_load_tree(state, &tree);
    if (exit_code == PROGRAM_DONE && svo_tree_get_voxels(tree, &source->voxels, &message) != SVO_OK) {
        exit_code = program_fail_library(state, message.text);
    }
    if (exit_code == PROGRAM_DONE) {
        (void)svo_voxels_set_axes(source->voxels, (svo_axes)state->options.axes);
    }
    svo_tree_destroy(&tree);
    if (exit_code == PROGRAM_DONE) {
        source->list = (svo_voxels_info)SVO_VOXELS_INFO_INIT;
        (void)svo_voxels_get_info(source->voxels, &source->list);
    }
    return exit_code;
}

static int read_voxels(program *state, conversion *done)
{
    done->from_tree = input_is_tree(state);
    if (done->from_tree) {
        return read_tree(state, &done->source);
    }
    progress_step(state->progress, "reading the voxels");
    return voxel_input_open(state, &done->source);
}

static int write_tree(program *state, conversion *done)
{
    session opened;
    svo_tree *tree = NULL;
    int exit_code = session_open_device(state, &opened);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    progress_step(state->progress, "building the tree");
    if (svo_voxels_build(opened.device, done->source.voxels, 0, NULL, opened.queue, &tree, NULL) != SVO_OK ||
        svo_tree_download(tree, opened.queue) != SVO_OK) {
        exit_code = program_fail_library(state, svo_device_message(opened.device));
    }
    if (exit_code == PROGRAM_DONE) {
        done->tree = (svo_tree_info)SVO_TREE_INFO_INIT;
        (void)svo_tree_get_info(tree, &done->tree);
        exit_code = tree_output_write(state, tree, NULL, state->options.output_path);
    }
    svo_tree_destroy(&tree);
    session_close(&opened);
    return exit_code;
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
    /* A write that failed is reported by output_commit. */
    if (svo_voxels_save(done->source.voxels, output_sink(&file), svo_voxel_format_of_path(path), &done->written,
                        &message) != SVO_OK &&
        file.error == 0) {
        output_abandon(&file);
        return program_fail(state, PROGRAM_FAILED, "%s: %s", path, program_words(message.text));
    }
    return output_commit(state, &file);
}

/* Parts of a list that a format may not hold. */
#define PARTS_MAX 5

/* What the list has and the format does not. Returns how many parts it is. */
static size_t find_left_out(const conversion *done, const char *out[PARTS_MAX])
{
    const svo_voxels_info *list = &done->source.list;
    const svo_voxel *voxels = svo_voxels_get(done->source.voxels);
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
    const char *const parts[PARTS_MAX] = {
        colors && binvox ? "colors" : NULL, alpha && (binvox || svx || obj) ? "alpha" : NULL,
        list->material_count > 1 && (binvox || obj || (svx && list->material_count > 256)) ? "materials" : NULL,
        list->property_count > 0 && !vox ? "properties of materials" : NULL,
        moved && vox ? "the place and the width of voxels" : NULL};
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
    if (written->format == SVO_VOXEL_FORMAT_AUTO) {
        json_add_text(object, "format", "svo");
        json_add_count(object, "depth", done->tree.depth);
        json_add_count(object, "leaves", done->tree.leaf_count);
        json_add_count(object, "nodes", done->tree.node_count);
        return;
    }
    json_add_text(object, "format", svo_name(SVO_NAME_VOXEL_FORMAT, (svo_voxel_format)written->format));
    json_add_count(object, "bytes", written->bytes);
    json_add_count(object, "models", written->models);
    json_add_count(object, "colors", written->colors);
    json_add_count(object, "color_error", written->color_error);
    json_add_count(object, "faces", written->faces);
}

static void add_written(cJSON *document, const conversion *done)
{
    cJSON *object = cJSON_AddObjectToObject(document, "written");
    add_counts(object, done);
    const char *parts[PARTS_MAX];
    const int count = (int)find_left_out(done, parts);
    cJSON_AddItemToObject(object, "left_out", cJSON_CreateStringArray(parts, count));
}

static void add_left_out_row(table *rows, const conversion *done)
{
    const char *parts[PARTS_MAX];
    const size_t count = find_left_out(done, parts);
    char text[128] = "";
    size_t used = 0;
    for (size_t i = 0; i < count; ++i) {
        used += (size_t)snprintf(text + used, sizeof text - used, "%s%s", i > 0 ? ", " : "", parts[i]);
    }
    if (count > 0) {
        table_cell(rows, "left out");
        table_cell(rows, "%s", text);
    }
}

/* What was written, as a row of the table. */
static void add_written_row(table *rows, const conversion *done)
{
    const svo_voxels_save_info *written = &done->written;
    table_cell(rows, "written");
    if (written->format == SVO_VOXEL_FORMAT_AUTO) {
        table_cell(rows, "%s leaves, %s nodes, depth %u", figure_count(done->tree.leaf_count).text,
                   figure_count(done->tree.node_count).text, done->tree.depth);
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
    add_left_out_row(rows, done);
}

static int report(program *state, const conversion *done)
{
    const options *given = &state->options;
    progress_destroy(&state->progress);
    if (given->json) {
        cJSON *document = json_document();
        json_add_text(document, "input", given->input);
        json_add_text(document, "file", given->output_path);
        if (done->from_tree) {
            json_add_count(document, "leaves", done->source.list.voxel_count);
        } else {
            voxel_input_add_json(document, &done->source);
        }
        add_written(document, done);
        return json_print(state, document);
    }
    if (given->quiet) {
        return PROGRAM_DONE;
    }
    table_heading("%s -> %s", given->input, output_name(given->output_path));
    table *rows = table_create("ll");
    if (done->from_tree) {
        table_cell(rows, "leaves");
        table_cell(rows, "%s", figure_count(done->source.list.voxel_count).text);
    } else {
        voxel_input_add_rows(rows, &done->source);
    }
    const int32_t *low = done->source.list.low;
    const int32_t *high = done->source.list.high;
    table_cell(rows, "bounds");
    table_cell(rows, "%d, %d, %d to %d, %d, %d", low[0], low[1], low[2], high[0], high[1], high[2]);
    add_written_row(rows, done);
    table_print(rows);
    return PROGRAM_DONE;
}

int command_convert(program *state)
{
    conversion done = {.written = SVO_VOXELS_SAVE_INFO_INIT};
    int exit_code = check_arguments(state);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    program_begin_progress(state, 3);
    exit_code = read_voxels(state, &done);
    if (exit_code == PROGRAM_DONE) {
        exit_code = is_tree_path(state->options.output_path) ? write_tree(state, &done) : write_file(state, &done);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = report(state, &done);
    }
    voxel_input_close(&done.source);
    return exit_code;
}
