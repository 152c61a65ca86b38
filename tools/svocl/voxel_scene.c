/* SPDX-License-Identifier: MIT */
/*
 * svocl convert IN.vox OUT.json: each model once, as a .vox file in the folder OUT_models beside OUT, and OUT itself, a
 * scene whose instances are where the file places them. Files are replaced one by one, and OUT is the last: it never
 * names a model that is not there.
 */
#define _POSIX_C_SOURCE 200809L
#include "voxel_scene.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "support/json.h"
#include "support/options_parse.h"
#include "support/output.h"
#include "support/table.h"
#include "support/text.h"
#include "support/voxel_input.h"

#define SUFFIX     ".json"
#define PATH_BYTES 4096

typedef struct writer {
    program *state;
    char folder[PATH_BYTES]; /* from where the program runs */
    const char *from_scene; /* the same from OUT's folder */
    cJSON *trees, *instances; /* of the document */
    uint64_t models, placed, bytes;
    int exit_code; /* of what failed, its line printed */
} writer;

bool voxel_scene_is_output(const program *state)
{
    return output_has_suffix(state->options.output_path, SUFFIX);
}

static int check(program *state)
{
    static const char *const none[] = {NULL};
    const options *given = &state->options;
    const char *name = piped_is(&state->piped, given->input) ? state->piped.suffix : given->input;
    if (svo_voxel_format_of_path(name) != SVO_VOXEL_FORMAT_VOX) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "OUT %s is a scene, which is made of a .vox file alone",
                            given->output_path);
    }
    const int exit_code =
        options_take_only(state, OPTION_JSON | OPTION_VOXELS | OPTION_UNFOLDED, none, "from a .vox file to a scene");
    return exit_code == PROGRAM_DONE ? output_check(state, given->output_path) : exit_code;
}

/* Writes a model. Returns the exit code. */
static int write_model(writer *w, const svo_voxels *voxels, const char *path)
{
    output_file file;
    svo_message message = {""};
    svo_voxels_save_info written = SVO_VOXELS_SAVE_INFO_INIT;
    const int exit_code = output_open(w->state, path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    const svo_status status = svo_voxels_save(voxels, output_sink(&file), SVO_VOXEL_FORMAT_VOX, &written, &message);
    if (status != SVO_OK && file.error == 0) { /* else output_commit reports it */
        output_abandon(&file);
        return program_fail(w->state, PROGRAM_FAILED, "%s: %s", path, program_words(message.text));
    }
    w->bytes += written.bytes;
    return output_commit(w->state, &file);
}

static void add_instances(writer *w, const char *name, const svo_voxel_part *part)
{
    for (uint64_t i = 0; i < part->transform_count; ++i) {
        cJSON *instance = cJSON_CreateObject();
        json_add_text(instance, "tree", name);
        cJSON_AddItemToObject(instance, "matrix", cJSON_CreateDoubleArray(part->transforms + 12 * i, 12));
        cJSON_AddItemToArray(w->instances, instance);
    }
}

/* Takes a model: svo_voxel_part_callback. */
static svo_status take_model(void *user, const svo_voxel_part *part)
{
    writer *w = user;
    char name[32];
    char path[PATH_BYTES + 64];
    if (w->models == 0 && mkdir(w->folder, 0777) != 0 && errno != EEXIST) {
        w->exit_code = program_fail(w->state, PROGRAM_FAILED, "%s: %s", w->folder, strerror(errno));
        return SVO_FILE_ERROR;
    }
    (void)snprintf(name, sizeof name, "%" PRIu64, part->model);
    (void)snprintf(path, sizeof path, "%s/%s.vox", w->folder, name);
    w->exit_code = write_model(w, part->voxels, path);
    if (w->exit_code != PROGRAM_DONE) {
        return SVO_FILE_ERROR;
    }
    (void)snprintf(path, sizeof path, "%s/%s.vox", w->from_scene, name);
    json_add_text(cJSON_AddObjectToObject(w->trees, name), "path", path);
    add_instances(w, name, part);
    ++w->models;
    w->placed += part->transform_count;
    return SVO_OK;
}

/* What was written. Returns the exit code. */
static int report(const writer *w, const voxel_input *held)
{
    program *state = w->state;
    progress_destroy(&state->progress);
    if (state->options.json) {
        cJSON *document = json_document();
        json_add_text(document, "input", state->options.input);
        json_add_text(document, "file", state->options.output_path);
        voxel_input_add_json(document, held);
        cJSON *object = cJSON_AddObjectToObject(document, "written");
        json_add_text(object, "format", "scene");
        json_add_text(object, "folder", w->folder);
        json_add_count(object, "bytes", w->bytes);
        json_add_count(object, "models", w->models);
        json_add_count(object, "instances", w->placed);
        return json_print(state, document);
    }
    if (!state->options.quiet) {
        table_heading("%s -> %s", state->options.input, state->options.output_path);
        table *rows = table_create("ll");
        voxel_input_add_rows(rows, held);
        table_cell(rows, "written");
        table_cell(rows, "%s instances of %s models in %s, %s", figure_count(w->placed).text,
                   figure_count(w->models).text, w->folder, figure_bytes(w->bytes).text);
        table_print(rows);
    }
    return PROGRAM_DONE;
}

/* Reads IN and writes all. Returns the exit code. */
static int convert(writer *w, cJSON *scene)
{
    program *state = w->state;
    svo_message message = {""};
    voxel_input held;
    program_begin_progress(state, 1);
    progress_step(state->progress, "writing the models");
    const svo_status status = voxel_input_read_parts(state, take_model, w, &held, &message);
    if (status != SVO_OK) {
        return w->exit_code != PROGRAM_DONE ? w->exit_code : program_fail_library(state, message.text);
    }
    if (w->models == 0) {
        return program_fail(state, PROGRAM_FAILED, "%s: no voxel is placed, and a scene needs a tree",
                            state->options.input);
    }
    const int exit_code = json_save(state, state->options.output_path, scene);
    return exit_code == PROGRAM_DONE ? report(w, &held) : exit_code;
}

int voxel_scene_convert(program *state)
{
    const char *path = state->options.output_path;
    const size_t stem = strlen(path) - strlen(SUFFIX);
    writer w = {.state = state, .exit_code = check(state)};
    if (w.exit_code != PROGRAM_DONE) {
        return w.exit_code;
    }
    if (stem + sizeof "_models" > sizeof w.folder) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "OUT has more than %zu letters", sizeof w.folder);
    }
    (void)snprintf(w.folder, sizeof w.folder, "%.*s_models", (int)stem, path);
    const char *slash = strrchr(w.folder, '/');
    w.from_scene = slash != NULL ? slash + 1 : w.folder;
    cJSON *scene = cJSON_CreateObject();
    w.trees = cJSON_AddObjectToObject(scene, "trees");
    w.instances = cJSON_AddArrayToObject(scene, "instances");
    const int exit_code = convert(&w, scene);
    cJSON_Delete(scene);
    return exit_code;
}
