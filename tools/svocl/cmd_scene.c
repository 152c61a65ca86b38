/* SPDX-License-Identifier: MIT */
/* svocl scene: writes a procedural scene as a mesh file, or lists the scenes. */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "scenes/scenes.h"
#include "support/json.h"
#include "support/options_parse.h"
#include "support/output.h"
#include "support/table.h"
#include "svocl/commands.h"

static int list_scenes(program *state)
{
    if (state->options.json) {
        cJSON *document = json_document();
        cJSON *array = cJSON_AddArrayToObject(document, "scenes");
        for (size_t i = 0; scene_describe(i) != NULL; ++i) {
            cJSON *one = cJSON_CreateObject();
            json_add_text(one, "name", scene_describe(i)->name);
            json_add_text(one, "summary", scene_describe(i)->summary);
            json_add_count(one, "default_triangles", scene_describe(i)->default_triangles);
            cJSON_AddItemToArray(array, one);
        }
        return json_print(state, document);
    }
    table_heading("scenes and their default triangle counts");
    table *rows = table_create("lrl");
    for (size_t i = 0; scene_describe(i) != NULL; ++i) {
        table_cell(rows, "%s", scene_describe(i)->name);
        table_cell(rows, "%s", figure_count(scene_describe(i)->default_triangles).text);
        table_cell(rows, "%s", scene_describe(i)->summary);
    }
    table_print(rows);
    return PROGRAM_DONE;
}

/* NAME:triangles:seed, with the default triangle count of the scene if none was given. scene_create rejects unknown
   names. */
static void write_spec(const options *given, char *spec, size_t spec_bytes)
{
    uint64_t triangles = given->triangles;
    for (size_t i = 0; triangles == 0 && scene_describe(i) != NULL; ++i) {
        if (strcmp(scene_describe(i)->name, given->input) == 0) {
            triangles = scene_describe(i)->default_triangles;
        }
    }
    if (triangles == 0) {
        snprintf(spec, spec_bytes, "%s", given->input);
    } else {
        snprintf(spec, spec_bytes, "%s:%" PRIu64 ":%" PRIu64, given->input, triangles, given->seed);
    }
}

static int report_scene(program *state, const scene *made)
{
    const svo_mesh *mesh = scene_mesh(made);
    if (state->options.json) {
        cJSON *document = json_document();
        json_add_text(document, "scene", state->options.input);
        json_add_count(document, "seed", scene_seed(made));
        json_add_count(document, "triangles", mesh->triangle_count);
        json_add_count(document, "vertices", mesh->vertex_count);
        json_add_text(document, "file", state->options.output_path);
        return json_print(state, document);
    }
    if (state->options.quiet) {
        return PROGRAM_DONE;
    }
    progress_hide(state->progress);
    table_line("%s: %s triangles, %s vertices", output_name(state->options.output_path),
               figure_count(mesh->triangle_count).text, figure_count(mesh->vertex_count).text);
    return PROGRAM_DONE;
}

/* Options that a list of the scenes, or a NAME with numbers of its own, does not take. */
static int check_options(program *state)
{
    static const char *const of_scenes[] = {"triangles", "seed", "output", NULL};
    static const char *const numbers[] = {"triangles", "seed", NULL};
    const char *name = state->options.input;
    if (name == NULL) {
        return options_refuse(state, of_scenes, "without NAME");
    }
    return strchr(name, ':') == NULL ? PROGRAM_DONE
                                     : options_refuse(state, numbers, "to a NAME with numbers of its own");
}

int command_scene(program *state)
{
    if (check_options(state) != PROGRAM_DONE) {
        return PROGRAM_WRONG_USAGE;
    }
    if (state->options.input == NULL) {
        return list_scenes(state);
    }
    if (state->options.output_path == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "-o FILE is missing");
    }
    int exit_code = output_check(state, state->options.output_path);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    char spec[256];
    write_spec(&state->options, spec, sizeof spec);
    program_begin_progress(state, 2);
    progress_step(state->progress, "generating the scene");
    scene *made = NULL;
    svo_message message = {""};
    const svo_status status = scene_create(spec, &made, &message);
    if (status != SVO_OK) {
        return program_fail_scene(state, status, message.text);
    }
    progress_step(state->progress, "writing the mesh");
    exit_code = mesh_output_write(state, scene_mesh(made), state->options.output_path);
    if (exit_code == PROGRAM_DONE) {
        exit_code = report_scene(state, made);
    }
    scene_destroy(&made);
    return exit_code;
}
