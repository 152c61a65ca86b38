/* SPDX-License-Identifier: MIT */
/* svocl mesh: a closed mesh around a mesh, or around a tree with leaf lists, out of its signed distance field. */
#include <math.h>

#include "support/json.h"
#include "support/output.h"
#include "support/table.h"
#include "svocl/commands.h"
#include "svocl/distance_field.h"
#include "svocl/io.h"
#include "svocl/surface.h"

/* Voxels of room around the surface, so that it does not reach the grid's end. */
#define ROOM 2.0

/* Voxels on each side of the surface in the band. */
#define BAND 3.0

typedef struct meshing {
    distance_field field;
    svo_surface *surface;
    svo_surface_info info;
    double make_ms;
} meshing;

/* ---- making ---- */

/* Columns of voxels where the surface of the input is not closed. */
static uint64_t count_open(const meshing *done)
{
    const uint64_t *open = done->field.info.open_columns;
    return open[0] + open[1] + open[2];
}

static int make_field(program *state, meshing *done)
{
    const options *given = &state->options;
    const uint32_t need = SVO_NEED_RAYS | (given->colors != 0 ? (uint32_t)SVO_NEED_COLOR : 0);
    const double room = given->margin >= 0 ? given->margin : ROOM;
    int exit_code = distance_field_open(state, need, room, fmax(given->iso, 0), 4, &done->field);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    svo_tree_info tree = SVO_TREE_INFO_INIT;
    (void)svo_tree_get_info(done->field.made.result.tree, &tree);
    const double voxels = fabs(given->iso) / ldexp(tree.edge, -(int)tree.depth);
    exit_code = distance_field_make(state, (float)(voxels + BAND), &done->field);
    if (exit_code == PROGRAM_DONE && count_open(done) > 0) {
        /* Signs may change where the band has nothing. */
        svo_sdf_destroy(&done->field.sdf);
        exit_code = distance_field_make(state, 0, &done->field);
    }
    if (exit_code != PROGRAM_DONE) {
        distance_field_release(&done->field);
    }
    return exit_code;
}

static int make_surface(program *state, meshing *done)
{
    const options *given = &state->options;
    svo_message message = {""};
    svo_surface_field field = SVO_SURFACE_FIELD_INIT;
    const svo_surface_options asked = {.struct_size = sizeof asked,
                                       .level = (float)given->iso,
                                       .parts = SVO_SURFACE_NORMALS |
                                                (given->colors != 0 ? (uint32_t)SVO_SURFACE_COLORS : 0),
                                       .tree = done->field.made.result.tree};
    progress_step(state->progress, "finding the surface");
    const double started_ms = input_now_ms();
    (void)svo_surface_field_of(done->field.sdf, &field);
    if (svo_surface_create(&field, &asked, &done->surface, &message) != SVO_OK) {
        return program_fail_library(state, message.text);
    }
    done->make_ms = input_now_ms() - started_ms;
    done->info = (svo_surface_info)SVO_SURFACE_INFO_INIT;
    (void)svo_surface_get_info(done->surface, &done->info);
    return done->info.triangle_count > 0
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_FAILED, "%s has no inside at --iso %g", state->options.input, given->iso);
}

static int write_mesh(program *state, const meshing *done)
{
    output_file file;
    svo_message message = {""};
    const char *path = state->options.output_path;
    progress_step(state->progress, "writing the mesh");
    const int exit_code = output_open(state, path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    /* Standard output has no suffix. */
    const svo_mesh_format by_name = svo_mesh_format_of_path(path);
    const svo_mesh_format format = by_name == SVO_MESH_FORMAT_AUTO ? SVO_MESH_FORMAT_PLY : by_name;
    const svo_status status = svo_mesh_save(svo_surface_get_mesh(done->surface), output_sink(&file), format, &message);
    if (status != SVO_OK && file.error == 0) { /* else output_commit reports it */
        output_abandon(&file);
        return program_fail_library(state, message.text);
    }
    return output_commit(state, &file);
}

/* ---- the report ---- */

static int report_json(program *state, const meshing *done)
{
    const svo_sdf_info *field = &done->field.info;
    cJSON *document = json_document();
    json_add_text(document, "input", state->options.input);
    json_add_text(document, "file", state->options.output_path);
    json_add_count(document, "depth", field->depth);
    cJSON_AddNumberToObject(document, "iso", state->options.iso);
    json_add_text(document, "sign", distance_field_sign(state));
    json_add_count(document, "vertices", done->info.vertex_count);
    json_add_count(document, "triangles", done->info.triangle_count);
    json_add_count(document, "end_triangles", done->info.end_triangles);
    cJSON_AddNumberToObject(document, "spacing", field->spacing);
    json_add_vector(document, "origin", field->origin);
    cJSON_AddNumberToObject(document, "edge", field->edge);
    json_add_count(document, "open_columns", count_open(done));
    cJSON_AddNumberToObject(document, "sdf_ms", done->field.make_ms);
    cJSON_AddNumberToObject(document, "surface_ms", done->make_ms);
    return json_print(state, document);
}

static int report(program *state, const meshing *done)
{
    if (state->options.json) {
        return report_json(state, done);
    }
    if (state->options.quiet) {
        return PROGRAM_DONE;
    }
    progress_hide(state->progress);
    table_line("%s: %s triangles, %s vertices, of %u^3 voxels; distances in %s, surface in %s",
               output_name(state->options.output_path), figure_count(done->info.triangle_count).text,
               figure_count(done->info.vertex_count).text, 1U << done->field.info.depth,
               figure_ms(done->field.make_ms).text, figure_ms(done->make_ms).text);
    if (done->info.end_triangles > 0) {
        table_line("the surface reaches the grid's end and is cut off there: %s triangles",
                   figure_count(done->info.end_triangles).text);
    }
    if (count_open(done) > 0) {
        table_line("the input is not closed: %s columns of voxels", figure_count(count_open(done)).text);
    }
    return PROGRAM_DONE;
}

/* ---- the command ---- */

static int check_options(program *state)
{
    const options *given = &state->options;
    if (given->output_path == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "-o FILE is missing");
    }
    if (given->sign == OPTION_SIGN_NONE && !(given->iso > 0)) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "--sign none needs --iso above 0: without signs, what is nearer "
                            "than that is inside");
    }
    const int exit_code = distance_field_check(state, "surfaces");
    return exit_code == PROGRAM_DONE ? output_check(state, given->output_path) : exit_code;
}

int command_mesh(program *state)
{
    meshing done = {.surface = NULL};
    int exit_code = check_options(state);
    if (exit_code == PROGRAM_DONE) {
        exit_code = make_field(state, &done);
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = make_surface(state, &done);
    if (exit_code == PROGRAM_DONE) {
        exit_code = write_mesh(state, &done);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = report(state, &done);
    }
    svo_surface_destroy(&done.surface);
    distance_field_release(&done.field);
    return exit_code;
}
