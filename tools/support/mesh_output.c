/* SPDX-License-Identifier: MIT */
/* Which format a path asks for, and the library of materials beside an OBJ file. */
#include "support/mesh_output.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "scenes/scenes.h"
#include "support/output.h"

static bool has_suffix(const char *path, const char *suffix)
{
    const size_t path_bytes = strlen(path);
    const size_t suffix_bytes = strlen(suffix);
    return path_bytes > suffix_bytes && strcasecmp(path + path_bytes - suffix_bytes, suffix) == 0;
}

/* Passes a failure of a writer on; the file is abandoned. */
static int fail(program *state, output_file *file, svo_status status, const char *words)
{
    output_abandon(file);
    return program_fail_scene(state, status, words);
}

static int write_ply(program *state, const svo_mesh *mesh, const char *path)
{
    output_file file;
    svo_message message = {""};
    const int exit_code = output_open(state, path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    const svo_status status = scene_write_ply(mesh, file.stream, &message);
    return status == SVO_OK ? output_commit(state, &file) : fail(state, &file, status, message.text);
}

static int write_library(program *state, const svo_mesh *mesh, const char *path)
{
    output_file file;
    const int exit_code = output_open(state, path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    scene_write_mtl(mesh, file.stream);
    return output_commit(state, &file);
}

/* The library gets its name first: an object without its library would be half a result. */
static int write_obj(program *state, const svo_mesh *mesh, const char *path, const char *library_path)
{
    output_file file;
    svo_message message = {""};
    int exit_code = output_open(state, path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    const char *slash = strrchr(library_path, '/');
    const svo_status status = scene_write_obj(mesh, slash != NULL ? slash + 1 : library_path, file.stream, &message);
    if (status != SVO_OK) {
        return fail(state, &file, status, message.text);
    }
    /* If the object failed already, its failure is what output_commit reports, and there is no library. */
    if (output_flush(&file) && mesh->material_count > 0) {
        exit_code = write_library(state, mesh, library_path);
    }
    if (exit_code != PROGRAM_DONE) {
        output_abandon(&file);
        return exit_code;
    }
    return output_commit(state, &file);
}

int mesh_output_write(program *state, const svo_mesh *mesh, const char *path)
{
    if (!has_suffix(path, ".obj")) {
        return write_ply(state, mesh, path);
    }
    const size_t path_bytes = strlen(path) + 1;
    char *library_path = malloc(path_bytes);
    if (library_path == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory");
    }
    snprintf(library_path, path_bytes, "%.*s.mtl", (int)(strlen(path) - strlen(".obj")), path);
    const int exit_code = write_obj(state, mesh, path, library_path);
    free(library_path);
    return exit_code;
}
