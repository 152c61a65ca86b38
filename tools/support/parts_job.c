/* SPDX-License-Identifier: MIT */
/* The steps of building in parts, with what they say when they fail. */
#include "support/parts_job.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "support/job.h"
#include "support/output.h"
#include "support/tree_form.h"
#include "svocl/io.h"

#define SUFFIX ".parts"

char *parts_folder_of(const char *path)
{
    const size_t bytes = strlen(path) + sizeof SUFFIX;
    char *folder = malloc(bytes);
    if (folder != NULL) {
        (void)snprintf(folder, bytes, "%s" SUFFIX, path);
    }
    return folder;
}

bool parts_folder_exists(const char *folder)
{
    struct stat found;
    return stat(folder, &found) == 0;
}

bool parts_folder_has_plan(const char *folder)
{
    const size_t bytes = strlen(folder) + sizeof "/plan";
    char *path = malloc(bytes);
    if (path == NULL) {
        return true;
    }
    (void)snprintf(path, bytes, "%s/plan", folder);
    const bool is_there = parts_folder_exists(path);
    free(path);
    return is_there;
}

int parts_check_builder(program *state)
{
    const int builder = state->options.builder;
    if (state->options.axes == (int)SVO_AXES_Z_UP) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--axes z-up does not apply to builds in parts");
    }
    return builder == SVO_BUILDER_CL
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_WRONG_USAGE, "--builder %s makes no parts of trees",
                              builder == OPTION_BUILDER_GL_COMPUTE ? "gl-compute"
                                                                   : svo_name(SVO_NAME_BUILDER, (svo_builder)builder));
}

/* Bytes of a mesh's arrays. */
static uint64_t mesh_bytes_of(const svo_mesh *mesh)
{
    const uint64_t per_vertex = (mesh->positions != NULL ? 12u : 24u) + (mesh->normals != NULL ? 12u : 0u) +
                                (mesh->colors != NULL ? 4u : 0u) + (mesh->uvs != NULL ? 8u : 0u);
    const uint64_t per_triangle = (mesh->indices != NULL ? 12u : 0u) + (mesh->triangle_materials != NULL ? 2u : 0u);
    return mesh->vertex_count * per_vertex + mesh->triangle_count * per_triangle;
}

/* Plans parts of a file in blocks. *status: SVO_UNSUPPORTED where the mesh must be in memory. */
static int plan_in_blocks(program *state, session *opened, const char *folder, svo_status *status, svo_message *message)
{
    const svo_plan_options asked = job_plan_options(state, state->options.need);
    if (state->options.voxel_size > 0.0) {
        *status = SVO_UNSUPPORTED;
        (void)snprintf(message->text, sizeof message->text, "--voxel-size needs the whole mesh");
        return PROGRAM_DONE;
    }
    progress_step(state->progress, "reading the mesh");
    *status = svo_parts_create_from_file(opened->device, state->options.input, (unsigned)state->options.depth, &asked,
                                         state->options.max_memory, folder, message);
    state->reads_mesh = true;
    return *status == SVO_OK || *status == SVO_UNSUPPORTED ? PROGRAM_DONE : parts_fail(state, *status, message->text);
}

/* A mesh without a valid triangle is an input error, not an empty tree. */
static int check_triangles(program *state, const char *folder)
{
    svo_part_header header = SVO_PART_HEADER_INIT;
    svo_parts *parts = NULL;
    svo_message message;
    const int exit_code = parts_open(state, folder, &parts);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    const svo_status status = svo_parts_get_header(parts, &header, &message);
    svo_parts_close(&parts);
    if (status == SVO_OK && header.refused_triangles == header.triangles) {
        const bool removed = svo_parts_remove(folder, &message) == SVO_OK;
        return program_fail(state, PROGRAM_FAILED, "%s: no valid triangle in it: all %" PRIu64 " are refused%s%s",
                            state->options.input, header.triangles, removed ? "" : "; ", removed ? "" : message.text);
    }
    return status == SVO_OK ? PROGRAM_DONE : program_fail_library(state, message.text);
}

static int plan_from_memory(program *state, session *opened, const char *folder, parts_mesh *mesh)
{
    input source = {0};
    svo_message message;
    int exit_code = input_open(state, &source);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    mesh->bytes = mesh_bytes_of(source.mesh);
    progress_step(state->progress, "planning parts");
    const svo_plan_options asked = job_plan_options(state, state->options.need);
    const svo_status status = svo_parts_create(opened->device, source.mesh, (unsigned)state->options.depth, &asked,
                                               state->options.max_memory, folder, &message);
    input_close(&source);
    return status == SVO_OK ? PROGRAM_DONE : parts_fail(state, status, message.text);
}

static int plan_either(program *state, session *opened, const char *folder, parts_mesh *mesh)
{
    *mesh = (parts_mesh){.in_blocks = false};
    if (state->options.max_memory > 0 && state->options.strict == 0 && state->options.weld == 0.0 &&
        input_is_mesh_file(state)) {
        svo_status status = SVO_OK;
        const int exit_code = plan_in_blocks(state, opened, folder, &status, &mesh->why_whole);
        if (exit_code != PROGRAM_DONE || status == SVO_OK) {
            mesh->in_blocks = status == SVO_OK;
            return exit_code == PROGRAM_DONE ? check_triangles(state, folder) : exit_code;
        }
    }
    return plan_from_memory(state, opened, folder, mesh);
}

/* A limit that is too small leaves nothing behind. */
int parts_plan(program *state, session *opened, const char *folder, parts_mesh *mesh)
{
    const bool is_new = !parts_folder_exists(folder);
    const int exit_code = plan_either(state, opened, folder, mesh);
    if (exit_code == PROGRAM_WRONG_USAGE && is_new && parts_folder_exists(folder)) {
        (void)svo_parts_remove(folder, NULL);
    }
    return exit_code;
}

int parts_open(program *state, const char *folder, svo_parts **out)
{
    svo_message message;
    const svo_status status = svo_parts_open(folder, out, &message);
    return status == SVO_OK ? PROGRAM_DONE : parts_fail(state, status, message.text);
}

int parts_build(program *state, session *opened, const svo_parts *parts, size_t index)
{
    svo_message message;
    int is_built = 0;
    svo_status status = svo_parts_is_built(parts, index, &is_built, &message);
    if (status == SVO_OK && is_built == 0 && message.text[0] != '\0') {
        char text[sizeof message.text + 32];
        (void)snprintf(text, sizeof text, "%s; it is built again", message.text);
        program_log(state, SVO_LOG_WARNING, text);
    }
    if (status == SVO_OK && is_built == 0) {
        status = svo_parts_build(parts, index, opened->device, opened->frontend, opened->queue, &message);
    }
    return status == SVO_OK ? PROGRAM_DONE : parts_fail(state, status, message.text);
}

/* The exit code of a step of stitching. */
static int end_stitch(program *state, const svo_parts *parts, svo_status status, const svo_message *message)
{
    if ((status == SVO_FILE_ERROR || status == SVO_FILE_DAMAGED) && parts_lack(parts)) {
        return program_fail_status(state, PROGRAM_TRY_AGAIN, message->text);
    }
    return status == SVO_OK ? PROGRAM_DONE : parts_fail(state, status, message->text);
}

static int stitch(program *state, const svo_parts *parts, const char *path)
{
    svo_message message;
    const svo_status status = svo_parts_finish(parts, path, &message);
    return end_stitch(state, parts, status, &message);
}

int parts_begin_shares(program *state, const svo_parts *parts, unsigned count)
{
    svo_message message;
    const svo_status status = svo_parts_shares_begin(parts, count, &message);
    return end_stitch(state, parts, status, &message);
}

int parts_write_share(program *state, const svo_parts *parts, unsigned index, unsigned count)
{
    svo_message message;
    const svo_status status = svo_parts_shares_write(parts, index, count, &message);
    return end_stitch(state, parts, status, &message);
}

int parts_finish_shares(program *state, const svo_parts *parts, unsigned count, const char *path)
{
    svo_message message;
    const svo_status status = svo_parts_shares_finish(parts, count, path, &message);
    return end_stitch(state, parts, status, &message);
}

/* A stitched file as a compact tree with host arrays. */
static int make_compact(program *state, const session *opened, const char *path, svo_compact **out)
{
    svo_tree *tree = NULL;
    svo_message message = {""};
    if (svo_tree_load(svo_from_path(path), NULL, &tree, &message) != SVO_OK) {
        return program_fail_library(state, message.text);
    }
    int exit_code = svo_tree_upload(tree, opened->device, opened->queue) == SVO_OK
                        ? tree_form_make(state, opened, tree, out)
                        : program_fail_library(state, svo_device_message(opened->device));
    if (exit_code == PROGRAM_DONE && svo_compact_download(*out, opened->queue) != SVO_OK) {
        exit_code = program_fail_library(state, svo_device_message(opened->device));
    }
    svo_tree_destroy(&tree);
    return exit_code;
}

int parts_finish(program *state, const session *opened, const svo_parts *parts, const char *path)
{
    if (state->options.tree_form == 0) {
        return stitch(state, parts, path);
    }
    spool_file spool;
    svo_compact *compact = NULL;
    int exit_code = spool_open(state, ".svo", &spool);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = stitch(state, parts, spool.path);
    if (exit_code == PROGRAM_DONE) {
        exit_code = make_compact(state, opened, spool.path, &compact);
    }
    spool_remove(&spool);
    if (exit_code == PROGRAM_DONE) {
        exit_code = tree_output_write(state, NULL, compact, path);
    }
    svo_compact_destroy(&compact);
    return exit_code;
}
