/* SPDX-License-Identifier: MIT */
/* Output files as streams, their messages, and standard output as a file. */
#include "support/output.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <unistd.h>

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

int output_begin(program *state, enum option_output kind)
{
    options *given = &state->options;
    if (given->output_path == NULL ||
        (!is_standard_output(given->output_path) && svo_i_output_descriptor_of(given->output_path) != STDOUT_FILENO)) {
        return PROGRAM_DONE;
    }
    if (kind == OPTION_OUTPUT_FOLDER) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "-o %s is standard output, a folder is needed",
                            given->output_path);
    }
    if (given->json) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--json and -o %s both write to standard output",
                            given->output_path);
    }
    if (kind == OPTION_OUTPUT_BYTES && isatty(STDOUT_FILENO)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "-o %s writes bytes that no terminal shows, redirect them",
                            given->output_path);
    }
    given->output_path = "-";
    state->file_descriptor = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    if (state->file_descriptor < 0 || dup2(STDERR_FILENO, STDOUT_FILENO) < 0) {
        return fail_errno(state, given->output_path, errno);
    }
    return PROGRAM_DONE;
}

int output_check(program *state, const char *path)
{
    const int error = is_standard_output(path) ? 0 : svo_i_output_check(path);
    return error == 0 ? PROGRAM_DONE : fail_errno(state, path, error);
}

int output_open(program *state, const char *path, output_file *file)
{
    *file = (output_file){.path = path};
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
    int error = output_flush(file) ? 0 : file->error;
    if (fclose(file->stream) != 0 && error == 0) {
        error = errno;
    }
    file->stream = NULL;
    if (error == 0) {
        error = svo_i_output_commit(&file->target);
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
