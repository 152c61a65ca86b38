/* SPDX-License-Identifier: MIT */
/* Output files as streams, their messages, and standard output as a file; trees and meshes as files. */
#include "support/output.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "scenes/scenes.h"
#include "svocl/io.h"
#include "svocl/voxel_files.h"

static bool is_standard_output(const char *path)
{
    return strcmp(path, "-") == 0;
}

const char *output_name(const char *path)
{
    return is_standard_output(path) ? "standard output" : path;
}

static int fail_errno(program *state, const char *path, int error)
{
    return program_fail(state, PROGRAM_FAILED, "%s: %s", output_name(path), strerror(error));
}

/* ---- inputs stay ---- */

/* The regular file or the folder that a path leads to, where "-" is a stream of this process. */
static bool find_file(const char *path, int stream, struct stat *entry)
{
    const bool is_there = strcmp(path, "-") == 0 ? fstat(stream, entry) == 0 : stat(path, entry) == 0;
    return is_there && (S_ISREG(entry->st_mode) || S_ISDIR(entry->st_mode));
}

static int fail_clash(program *state, const char *output, const char *input)
{
    return input == file_register_no_memory || output == file_register_no_memory
               ? program_fail(state, PROGRAM_FAILED, "out of memory")
               : program_fail(state, PROGRAM_WRONG_USAGE, "output %s would replace %s, which this run reads", output,
                              input);
}

int output_protect(program *state, const char *path)
{
    struct stat entry;
    if (!find_file(path, STDIN_FILENO, &entry)) {
        return PROGRAM_DONE; /* whoever reads it says what is wrong */
    }
    const char *name = strcmp(path, "-") == 0 ? "standard input" : path;
    const char *clash = file_register_read(&state->files, &entry, name);
    return clash == NULL ? PROGRAM_DONE : fail_clash(state, clash, name);
}

/* Fails where an output would replace an input, or another output of this run. */
static int claim(program *state, const char *path)
{
    struct stat entry;
    const char *name = output_name(path);
    const char *clash = is_standard_output(path) ? NULL : file_register_input_at(&state->files, path);
    if (clash == NULL && find_file(path, state->file_descriptor, &entry)) {
        clash = file_register_write(&state->files, &entry, name);
    }
    if (clash == NULL) {
        return PROGRAM_DONE;
    }
    return file_register_is_output(&state->files, clash)
               ? program_fail(state, PROGRAM_WRONG_USAGE, "outputs %s and %s are one file", clash, name)
               : fail_clash(state, name, clash);
}

/* ---- suffixes: what is written where ---- */

bool output_has_suffix(const char *path, const char *suffix)
{
    const size_t path_bytes = strlen(path);
    const size_t suffix_bytes = strlen(suffix);
    return path_bytes > suffix_bytes && strcasecmp(path + path_bytes - suffix_bytes, suffix) == 0;
}

output_kind output_kind_of(const options *given, const char *path)
{
    const svo_voxel_format format = svo_voxel_format_of_path(path);
    if (format != SVO_VOXEL_FORMAT_AUTO && format != SVO_VOXEL_FORMAT_LAS && format != SVO_VOXEL_FORMAT_LAZ) {
        return OUTPUT_VOXELS;
    }
    return given->tree_form != 0 || given->solid != 0 ? OUTPUT_COMPACT : OUTPUT_TREE;
}

/* Whether a list with spaces, ".obj .ply", has the suffix. */
static bool is_listed(const char *suffixes, const char *suffix)
{
    const size_t length = strlen(suffix);
    for (const char *at = suffixes; *at != '\0'; at += strspn(at, " ")) {
        const size_t one = strcspn(at, " ");
        if (one == length && strncasecmp(at, suffix, length) == 0) {
            return true;
        }
        at += one;
    }
    return false;
}

/* ".obj .ply" as ".obj or .ply". */
static void write_list(const char *suffixes, char *text, size_t text_bytes)
{
    size_t used = 0;
    for (const char *at = suffixes; *at != '\0' && used < text_bytes; at += strspn(at, " ")) {
        const size_t one = strcspn(at, " ");
        const char *between = at == suffixes ? "" : at[one] == '\0' ? " or " : ", ";
        used += (size_t)snprintf(text + used, text_bytes - used, "%s%.*s", between, (int)one, at);
        at += one;
    }
}

/* Where a name's suffix begins; NULL: it has none, since a leading dot hides a file. */
static const char *suffix_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    const char *name = slash != NULL ? slash + 1 : path;
    return name[0] != '\0' ? strrchr(name + 1, '.') : NULL;
}

int output_check_tree(program *state, const char *path, const char *needs)
{
    const options *given = &state->options;
    const char *suffix = suffix_of(path);
    const bool is_compact = suffix != NULL && strcasecmp(suffix, ".svc") == 0;
    const output_kind kind = output_kind_of(given, path);
    if (is_compact && kind != OUTPUT_COMPACT) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "output %s is a compact tree, which needs %s", path, needs);
    }
    return suffix == NULL || is_compact || (given->tree_form == 0 && kind != OUTPUT_COMPACT)
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_WRONG_USAGE, "output %s does not end in .svc, as files of --%s do", path,
                              given->tree_form != 0 ? "tree-form" : "solid");
}

static int check_suffix(program *state, const command *which, const char *path)
{
    char known[128] = "";
    const char *suffix = suffix_of(path);
    if (which->suffixes == NULL || piped_is_stream(path) || (suffix == NULL && !which->needs_suffix)) {
        return PROGRAM_DONE;
    }
    if (suffix == NULL || !is_listed(which->suffixes, suffix)) {
        write_list(which->suffixes, known, sizeof known);
        return program_fail(state, PROGRAM_WRONG_USAGE, "output %s does not end in %s", path, known);
    }
    const bool takes_solid = (which->groups & (unsigned)OPTION_SOLID) != 0;
    return is_listed(which->suffixes, ".svc")
               ? output_check_tree(state, path, takes_solid ? "--tree-form or --solid" : "--tree-form")
               : PROGRAM_DONE;
}

/* ---- standard output ---- */

/* The path of the command's file leads to standard output: keeps that for the file. */
static int take_standard_output(program *state, enum option_output kind)
{
    options *given = &state->options;
    const char *option = (given->given_groups & OPTION_DIFF_COMMAND) != 0 ? "--picture" : "-o";
    if (kind == OPTION_OUTPUT_FOLDER) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "%s %s is standard output, a folder is needed", option,
                            given->output_path);
    }
    if (given->json) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--json and %s %s both write to standard output", option,
                            given->output_path);
    }
    if (kind == OPTION_OUTPUT_BYTES && isatty(STDOUT_FILENO)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "%s %s writes bytes that no terminal shows, redirect them",
                            option, given->output_path);
    }
    given->output_path = "-";
    state->file_descriptor = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    if (state->file_descriptor < 0 || dup2(STDERR_FILENO, STDOUT_FILENO) < 0) {
        return fail_errno(state, given->output_path, errno);
    }
    return PROGRAM_DONE;
}

int output_begin(program *state, const command *which)
{
    const char *path = state->options.output_path;
    if (path == NULL) {
        return PROGRAM_DONE;
    }
    if (is_standard_output(path) || svo_i_output_descriptor_of(path) == STDOUT_FILENO) {
        return take_standard_output(state, which->output);
    }
    const char *input = which->output != OPTION_OUTPUT_FOLDER ? file_register_input_at(&state->files, path) : NULL;
    return input != NULL ? fail_clash(state, path, input) : check_suffix(state, which, path);
}

/* ---- files ---- */

int output_check(program *state, const char *path)
{
    const int error = is_standard_output(path) ? 0 : svo_i_output_check(path);
    return error == 0 ? claim(state, path) : fail_errno(state, path, error);
}

int output_open(program *state, const char *path, output_file *file)
{
    *file = (output_file){.path = path};
    const int claimed = claim(state, path);
    if (claimed != PROGRAM_DONE) {
        return claimed;
    }
    cleanup_add(&file->temporary);
    int error = is_standard_output(path) ? svo_i_output_open_descriptor(state->file_descriptor, &file->target)
                                         : svo_i_output_open(path, &file->temporary.watch, &file->target);
    if (error == 0) {
        /* A descriptor of its own, so that the stream is flushed and closed before the file gets its name. */
        const int descriptor = fcntl(file->target.descriptor, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
        file->stream = descriptor >= 0 ? fdopen(descriptor, "wb") : NULL;
        error = file->stream == NULL ? errno : 0;
        if (error != 0 && descriptor >= 0) {
            (void)close(descriptor);
        }
    }
    if (error == 0) {
        return PROGRAM_DONE;
    }
    svo_i_output_abandon(&file->target);
    cleanup_remove(&file->temporary);
    return fail_errno(state, path, error);
}

void output_write(output_file *file, const void *bytes, size_t byte_count)
{
    if (file->error == 0 && fwrite(bytes, 1, byte_count, file->stream) != byte_count) {
        file->error = errno != 0 ? errno : EIO;
    }
}

bool output_flush(output_file *file)
{
    errno = 0;
    if (file->error == 0 && (fflush(file->stream) != 0 || ferror(file->stream) != 0)) {
        file->error = errno != 0 ? errno : EIO;
    }
    return file->error == 0;
}

int output_commit(program *state, output_file *file)
{
    const int claimed = claim(state, file->path); /* another output may have appeared there */
    if (claimed != PROGRAM_DONE) {
        output_abandon(file);
        return claimed;
    }
    int error = output_flush(file) ? 0 : file->error;
    if (fclose(file->stream) != 0 && error == 0) {
        error = errno;
    }
    file->stream = NULL;
    if (error == 0) {
        error = svo_i_output_commit(&file->target);
    }
    struct stat entry;
    if (error == 0 && find_file(file->path, state->file_descriptor, &entry)) {
        file_register_written(&state->files, &entry, output_name(file->path));
    }
    const int result = error != 0 ? fail_errno(state, file->path, error) : PROGRAM_DONE;
    output_abandon(file);
    return result;
}

void output_abandon(output_file *file)
{
    if (file->path == NULL) {
        return;
    }
    if (file->stream != NULL) {
        (void)fclose(file->stream);
    }
    svo_i_output_abandon(&file->target);
    cleanup_remove(&file->temporary);
    *file = (output_file){.target = {.descriptor = -1}};
}

static int write_bytes(void *user, const void *bytes, size_t byte_count)
{
    output_file *file = user;
    output_write(file, bytes, byte_count);
    return file->error;
}

svo_sink output_sink(output_file *file)
{
    return svo_to_callback(write_bytes, file);
}

/* ---- trees ---- */

int tree_output_write(program *state, const svo_tree *tree, const svo_compact *compact, const char *path)
{
    output_file file;
    svo_message message = {""};
    const svo_save_options save_options = {.struct_size = sizeof save_options,
                                           .compress = (uint32_t)state->options.compress};
    progress_step(state->progress, "writing the tree");
    const int exit_code = output_open(state, path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    /* A write that failed is reported by output_commit. */
    const svo_status status = compact != NULL ? svo_compact_save(compact, output_sink(&file), &save_options, &message)
                                              : svo_tree_save(tree, output_sink(&file), &save_options, &message);
    if (status != SVO_OK && file.error == 0) {
        output_abandon(&file);
        return program_fail_library(state, message.text);
    }
    return output_commit(state, &file);
}

/* ---- meshes ---- */

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
    if (!output_has_suffix(path, ".obj")) {
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
