/* SPDX-License-Identifier: MIT */
/* The steps of building in parts, with what they say when they fail. */
#include "support/parts_job.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "support/job.h"

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

int parts_fail(program *state, svo_status status, const char *message)
{
    switch (status) {
    case SVO_OUT_OF_DEVICE_MEMORY:
    case SVO_OUT_OF_HOST_MEMORY:
    case SVO_NO_DEVICE:
    case SVO_COMPILE_FAILED:
    case SVO_CL_ERROR:
    case SVO_GL_ERROR:
        return program_fail(state, PROGRAM_TRY_AGAIN, "%s", program_words(message));
    default:
        return program_fail_library(state, message);
    }
}

/* Bytes of a mesh's arrays. */
static uint64_t mesh_bytes_of(const svo_mesh *mesh)
{
    const uint64_t per_vertex = (mesh->positions != NULL ? 12u : 24u) + (mesh->normals != NULL ? 12u : 0u) +
                                (mesh->colors != NULL ? 4u : 0u) + (mesh->uvs != NULL ? 8u : 0u);
    const uint64_t per_triangle = (mesh->indices != NULL ? 12u : 0u) + (mesh->triangle_materials != NULL ? 2u : 0u);
    return mesh->vertex_count * per_vertex + mesh->triangle_count * per_triangle;
}

int parts_plan(program *state, session *opened, const char *folder, uint64_t *mesh_bytes)
{
    input source = {0};
    svo_message message;
    int exit_code = input_open(state, &source);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (mesh_bytes != NULL) {
        *mesh_bytes = mesh_bytes_of(source.mesh);
    }
    progress_step(state->progress, "planning parts");
    const svo_plan_options asked = job_plan_options(state, state->options.need);
    const svo_status status = svo_parts_create(opened->device, source.mesh, (unsigned)state->options.depth, &asked,
                                               state->options.max_memory, folder, &message);
    input_close(&source);
    return status == SVO_OK ? PROGRAM_DONE : parts_fail(state, status, message.text);
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

int parts_finish(program *state, const svo_parts *parts, const char *path)
{
    svo_message message;
    const svo_status status = svo_parts_finish(parts, path, &message);
    return status == SVO_OK ? PROGRAM_DONE : parts_fail(state, status, message.text);
}
