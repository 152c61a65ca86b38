/* SPDX-License-Identifier: MIT */
/* Reads meshes and trees, generates scenes, and counts the triangles that will be refused. */
#include "support/input.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>
#include <strings.h>
#include <time.h>

double input_now_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

bool input_is_tree(const char *name)
{
    const size_t length = strlen(name);
    return strncmp(name, "scene:", 6) != 0 && length > 4 && strcasecmp(name + length - 4, ".svo") == 0;
}

int input_refuse_build_options(program *state)
{
    if ((state->options.given_groups & (unsigned)OPTION_BUILD) == 0) {
        return PROGRAM_DONE;
    }
    return program_fail(state, PROGRAM_WRONG_USAGE, "%s is a finished tree, build options do not apply",
                        state->options.input);
}

static bool is_finite_vertex(const svo_mesh *mesh, size_t vertex)
{
    for (size_t axis = 0; axis < 3; ++axis) {
        const bool finite = mesh->positions_double != NULL ? isfinite(mesh->positions_double[vertex * 3 + axis])
                                                           : isfinite(mesh->positions[vertex * 3 + axis]);
        if (!finite) {
            return false;
        }
    }
    return true;
}

static void note_refused(const svo_mesh *mesh, size_t triangle, refused_triangles *refused)
{
    bool finite = true;
    for (size_t corner = 0; corner < 3; ++corner) {
        const size_t vertex = mesh->indices != NULL ? mesh->indices[triangle * 3 + corner] : triangle * 3 + corner;
        if (vertex >= mesh->vertex_count) {
            if (refused->bad_index_count++ == 0) {
                refused->first_bad_index = triangle;
            }
            return;
        }
        finite = finite && is_finite_vertex(mesh, vertex);
    }
    if (!finite && refused->not_finite_count++ == 0) {
        refused->first_not_finite = triangle;
    }
}

static int open_scene(program *state, input *opened)
{
    svo_message message = {""};
    const svo_status status = scene_create(opened->name + strlen("scene:"), &opened->made, &message);
    if (status != SVO_OK) {
        return program_fail_scene(state, status, message.text);
    }
    opened->mesh = scene_mesh(opened->made);
    return PROGRAM_DONE;
}

static int open_file(program *state, input *opened)
{
    svo_message message = {""};
    const svo_import_options import_options = {.struct_size = sizeof import_options};
    if (svo_import_file(opened->name, &import_options, program_log, state, &opened->import, &message) != SVO_OK) {
        return program_fail_library(state, message.text);
    }
    opened->mesh = svo_import_mesh(opened->import);
    return PROGRAM_DONE;
}

/* A mesh without a valid triangle is an input error, not an empty tree. */
static int check_triangles(program *state, input *opened)
{
    const uint64_t given = opened->mesh->triangle_count;
    if (given == 0) {
        return program_fail(state, PROGRAM_FAILED, "%s: the mesh has no triangles", opened->name);
    }
    for (size_t i = 0; i < opened->mesh->triangle_count; ++i) {
        note_refused(opened->mesh, i, &opened->refused);
    }
    const refused_triangles *refused = &opened->refused;
    if (refused->bad_index_count + refused->not_finite_count < given) {
        return PROGRAM_DONE;
    }
    if (refused->bad_index_count == 0) {
        return program_fail(state, PROGRAM_FAILED,
                            "%s: no valid triangle in it: all %" PRIu64 " have a coordinate that is not finite",
                            opened->name, given);
    }
    return program_fail(state, PROGRAM_FAILED,
                        "%s: no valid triangle in it: %" PRIu64 " of %" PRIu64 " have an index out of range, %" PRIu64
                        " a coordinate that is not finite",
                        opened->name, refused->bad_index_count, given, refused->not_finite_count);
}

int input_open(program *state, input *opened)
{
    *opened = (input){.name = state->options.input};
    const bool is_scene = strncmp(opened->name, "scene:", 6) == 0;
    progress_step(state->progress, is_scene ? "generating the scene" : "reading the mesh");
    if (input_is_tree(opened->name)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "%s is a finished tree, a mesh is needed here", opened->name);
    }
    const double started_ms = input_now_ms();
    int result = is_scene ? open_scene(state, opened) : open_file(state, opened);
    opened->import_ms = input_now_ms() - started_ms;
    if (result == PROGRAM_DONE) {
        result = check_triangles(state, opened);
    }
    if (result != PROGRAM_DONE) {
        input_close(opened);
    }
    return result;
}

void input_close(input *opened)
{
    svo_import_destroy(&opened->import);
    scene_destroy(&opened->made);
    *opened = (input){0};
}

int input_load_tree(program *state, svo_tree **out)
{
    svo_message message = {""};
    progress_step(state->progress, "reading the tree");
    if (svo_tree_load(state->options.input, out, &message) != SVO_OK) {
        return program_fail_library(state, message.text);
    }
    return PROGRAM_DONE;
}
