/* SPDX-License-Identifier: MIT */
/* Writes files completely or not at all. */
#include "support/output.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static int fail_errno(program *state, const char *path, int error)
{
    return program_fail(state, PROGRAM_FAILED, "%s: %s", path, strerror(error));
}

/* Allocated by malloc. */
static char *directory_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    if (slash == NULL) {
        return strdup(".");
    }
    return slash == path ? strdup("/") : strndup(path, (size_t)(slash - path));
}

int output_check(program *state, const char *path)
{
    struct stat status;
    if (stat(path, &status) == 0) {
        return S_ISDIR(status.st_mode) ? fail_errno(state, path, EISDIR) : PROGRAM_DONE;
    }
    char *directory = directory_of(path);
    if (directory == NULL) {
        return fail_errno(state, path, ENOMEM);
    }
    int error = 0;
    if (stat(directory, &status) != 0 || access(directory, W_OK | X_OK) != 0) {
        error = errno;
    } else if (!S_ISDIR(status.st_mode)) {
        error = ENOTDIR;
    }
    int result = PROGRAM_DONE;
    if (error != 0) {
        result = program_fail(state, PROGRAM_FAILED, "%s: directory %s: %s", path, directory, strerror(error));
    }
    free(directory);
    return result;
}

static bool is_special(const char *path)
{
    struct stat status;
    return stat(path, &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

static char *make_temporary_path(const char *path)
{
    const size_t bytes = strlen(path) + 32;
    char *result = malloc(bytes);
    if (result != NULL) {
        snprintf(result, bytes, "%s.%ld.tmp", path, (long)getpid());
    }
    return result;
}

int output_open(program *state, const char *path, output_file *file)
{
    *file = (output_file){.path = path};
    const bool direct = is_special(path);
    if (!direct) {
        file->temporary_path = make_temporary_path(path);
        if (file->temporary_path == NULL) {
            return fail_errno(state, path, ENOMEM);
        }
    }
    const int flags = direct ? O_WRONLY : O_WRONLY | O_CREAT | O_EXCL;
    const int descriptor = open(direct ? path : file->temporary_path, flags | O_CLOEXEC, 0666);
    if (descriptor >= 0) {
        file->stream = fdopen(descriptor, "wb");
    }
    if (file->stream == NULL) {
        const int error = errno;
        if (descriptor >= 0) {
            close(descriptor);
            if (!direct) {
                unlink(file->temporary_path);
            }
        }
        free(file->temporary_path);
        file->temporary_path = NULL;
        return fail_errno(state, path, error);
    }
    return PROGRAM_DONE;
}

static void release(output_file *file)
{
    free(file->temporary_path);
    *file = (output_file){0};
}

void output_write(output_file *file, const void *bytes, size_t byte_count)
{
    if (file->error == 0 && fwrite(bytes, 1, byte_count, file->stream) != byte_count) {
        file->error = errno != 0 ? errno : EIO;
    }
}

int output_commit(program *state, output_file *file)
{
    int error = file->error;
    if (error == 0 && fflush(file->stream) != 0) {
        error = errno;
    }
    if (error == 0 && file->temporary_path != NULL && fsync(fileno(file->stream)) != 0) {
        error = errno;
    }
    if (fclose(file->stream) != 0 && error == 0) {
        error = errno;
    }
    if (error == 0 && file->temporary_path != NULL && rename(file->temporary_path, file->path) != 0) {
        error = errno;
    }
    if (error != 0 && file->temporary_path != NULL) {
        unlink(file->temporary_path);
    }
    const int result = error != 0 ? fail_errno(state, file->path, error) : PROGRAM_DONE;
    release(file);
    return result;
}

void output_abandon(output_file *file)
{
    if (file->stream == NULL) {
        return;
    }
    fclose(file->stream);
    if (file->temporary_path != NULL) {
        unlink(file->temporary_path);
    }
    release(file);
}
