/* SPDX-License-Identifier: MIT */
/*
 * From a path to the place of its bytes, and from complete bytes to a file.
 *
 * A file without a name vanishes with the process, however that ends. Linux can name it by linkat, which replaces
 * nothing: where there is an old file, the new one gets a temporary name first and is renamed at once.
 */
#define _GNU_SOURCE /* O_TMPFILE */
#include "output/output.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define LINKS_MAX      40 /* as the kernel */
#define NAME_ATTEMPTS  1000
#define FD_PATH_BYTES  32
#define NAME_BYTES_MAX 64 /* of a temporary name within its folder */

typedef enum place_kind {
    PLACE_FILE, /* a file to make or to replace */
    PLACE_STRAIGHT, /* a device, a pipe and the like */
    PLACE_DESCRIPTOR /* an open descriptor of this process */
} place_kind;

/* Where the bytes for a path go. */
typedef struct place {
    place_kind kind;
    char *path; /* with links followed, by malloc; NULL after a failure */
    int descriptor;
} place;

/* ---- paths ---- */

/* The folder of a path, by malloc; NULL with errno. */
static char *folder_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    if (slash == NULL) {
        return strdup(".");
    }
    return slash == path ? strdup("/") : strndup(path, (size_t)(slash - path));
}

/* "folder/name", by malloc; NULL with errno. */
static char *join(const char *folder, const char *name)
{
    const size_t bytes = strlen(folder) + strlen(name) + 2;
    char *path = malloc(bytes);
    if (path != NULL) {
        (void)snprintf(path, bytes, "%s/%s", folder, name);
    }
    return path;
}

static bool is_same_folder(const char *real, const char *other)
{
    char *other_real = realpath(other, NULL);
    const bool same = other_real != NULL && strcmp(real, other_real) == 0;
    free(other_real);
    return same;
}

/* The descriptor N of "FOLDER/N", where FOLDER lists the descriptors of this process; -1: it is none. */
static int descriptor_at(const char *path)
{
    const char *slash = strrchr(path, '/');
    char *end = NULL;
    if (slash == NULL || slash[1] < '0' || slash[1] > '9') {
        return -1;
    }
    const long number = strtol(slash + 1, &end, 10);
    if (*end != '\0' || number > INT_MAX) {
        return -1;
    }
    char *folder = folder_of(path);
    char *real = folder != NULL ? realpath(folder, NULL) : NULL;
    const bool own =
        real != NULL && (is_same_folder(real, "/proc/self/fd") || is_same_folder(real, "/proc/thread-self/fd"));
    free(real);
    free(folder);
    return own ? (int)number : -1;
}

/* Where a symbolic link leads, by malloc; NULL with errno: EINVAL where path is no link. */
static char *read_link(const char *path)
{
    char text[PATH_MAX];
    const ssize_t length = readlink(path, text, sizeof text - 1);
    if (length < 0) {
        return NULL;
    }
    text[length] = '\0';
    if (text[0] == '/') {
        return strdup(text);
    }
    char *folder = folder_of(path);
    char *next = folder != NULL ? join(folder, text) : NULL;
    free(folder);
    return next;
}

/* Follows the links of a path's last component, down to a descriptor of this process or to what is no link; the kernel
   follows those of its folders. */
static int follow_links(const char *path, place *out)
{
    char *current = strdup(path);
    *out = (place){.descriptor = -1};
    for (int i = 0; current != NULL && i < LINKS_MAX; ++i) {
        out->descriptor = descriptor_at(current);
        char *next = out->descriptor < 0 ? read_link(current) : NULL;
        const int error = errno;
        if (next == NULL && (out->descriptor >= 0 || error == EINVAL || error == ENOENT)) {
            out->path = current;
            return 0;
        }
        free(current);
        current = next;
        if (next == NULL) {
            return error;
        }
    }
    const int error = current == NULL ? ENOMEM : ELOOP;
    free(current);
    return error;
}

int svo_i_output_descriptor_of(const char *path)
{
    place found;
    (void)follow_links(path, &found);
    free(found.path);
    return found.descriptor;
}

/* Whether it is what a rename to path would replace. A link in /proc to what another process has open need not lead to
   its name. */
static bool is_at(const struct stat *entry, const char *path)
{
    struct stat other;
    return stat(path, &other) == 0 && other.st_dev == entry->st_dev && other.st_ino == entry->st_ino;
}

static int find_place(const char *path, place *out)
{
    struct stat entry;
    int error = follow_links(path, out);
    if (error != 0) {
        return error;
    }
    if (out->descriptor >= 0) {
        out->kind = PLACE_DESCRIPTOR;
    } else if (stat(path, &entry) != 0) {
        out->kind = PLACE_FILE;
        error = errno == ENOENT && path[0] != '\0' ? 0 : errno;
    } else if (S_ISDIR(entry.st_mode)) {
        error = EISDIR;
    } else {
        out->kind = S_ISREG(entry.st_mode) && is_at(&entry, out->path) ? PLACE_FILE : PLACE_STRAIGHT;
    }
    if (error != 0) {
        free(out->path);
        out->path = NULL;
    }
    return error;
}

static int check_folder(const char *path)
{
    struct stat entry;
    char *folder = folder_of(path);
    int error = folder == NULL ? ENOMEM : 0;
    if (error == 0 && stat(folder, &entry) != 0) {
        error = errno;
    } else if (error == 0 && !S_ISDIR(entry.st_mode)) {
        error = ENOTDIR;
    } else if (error == 0 && access(folder, W_OK | X_OK) != 0) {
        error = errno;
    }
    free(folder);
    return error;
}

static int check_descriptor(int descriptor)
{
    const int flags = fcntl(descriptor, F_GETFL);
    return flags < 0 || (flags & O_ACCMODE) == O_RDONLY ? EBADF : 0;
}

int svo_i_output_check(const char *path)
{
    place found;
    int error = find_place(path, &found);
    if (error != 0) {
        return error;
    }
    if (found.kind == PLACE_DESCRIPTOR) {
        error = check_descriptor(found.descriptor);
    } else if (found.kind == PLACE_FILE) {
        error = check_folder(found.path);
    } else if (access(path, W_OK) != 0) {
        error = errno;
    }
    free(found.path);
    return error;
}

/* ---- temporary names ---- */

static void hold(const svo_i_output *output)
{
    if (output->watch != NULL) {
        output->watch->hold(output->watch->user);
    }
}

static void release(const svo_i_output *output)
{
    if (output->watch != NULL) {
        output->watch->release(output->watch->user, output->temporary);
    }
}

/* The path of a descriptor that linkat can follow. */
static void write_fd_path(int descriptor, char text[FD_PATH_BYTES])
{
    (void)snprintf(text, FD_PATH_BYTES, "/proc/self/fd/%d", descriptor);
}

/* Makes a file with a new temporary name, or gives the file without a name one. Names are short, since a file's own
   name may be as long as the file system allows. */
static int take_temporary_name(svo_i_output *output)
{
    char name[NAME_BYTES_MAX], unnamed[FD_PATH_BYTES];
    char *folder = folder_of(output->target);
    int error = folder == NULL ? ENOMEM : EEXIST;
    write_fd_path(output->descriptor, unnamed);
    for (int i = 0; error == EEXIST && i < NAME_ATTEMPTS; ++i) {
        (void)snprintf(name, sizeof name, ".svocl-%ld-%d.tmp", (long)getpid(), i);
        char *path = join(folder, name);
        if (path == NULL) {
            error = ENOMEM;
        } else if (output->descriptor < 0) {
            output->descriptor = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
            error = output->descriptor < 0 ? errno : 0;
        } else {
            error = linkat(AT_FDCWD, unnamed, AT_FDCWD, path, AT_SYMLINK_FOLLOW) != 0 ? errno : 0;
        }
        if (error == 0) {
            output->temporary = path;
        } else {
            free(path);
        }
    }
    free(folder);
    return error;
}

/* ---- opening ---- */

/* Where this fails, a temporary name is tried, and its error is the one to report. */
static void open_unnamed(svo_i_output *output)
{
#ifdef O_TMPFILE
    char path[FD_PATH_BYTES];
    char *folder = folder_of(output->target);
    if (folder != NULL) {
        output->descriptor = open(folder, O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
    }
    free(folder);
    write_fd_path(output->descriptor, path);
    if (output->descriptor >= 0 && access(path, F_OK) != 0) { /* no /proc, so it could never get a name */
        (void)close(output->descriptor);
        output->descriptor = -1;
    }
#else
    (void)output;
#endif
}

static int open_file(char *target, const svo_i_output_watch *watch, svo_i_output *output)
{
    int error = 0;
    output->target = target;
    output->watch = watch;
    open_unnamed(output);
    if (output->descriptor < 0) {
        hold(output);
        error = take_temporary_name(output);
        release(output);
    }
    return error;
}

int svo_i_output_open_descriptor(int descriptor, svo_i_output *output)
{
    *output = (svo_i_output){.descriptor = -1};
    const int error = check_descriptor(descriptor);
    if (error != 0) {
        return error;
    }
    output->descriptor = fcntl(descriptor, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    return output->descriptor < 0 ? errno : 0;
}

int svo_i_output_open(const char *path, const svo_i_output_watch *watch, svo_i_output *output)
{
    place found;
    *output = (svo_i_output){.descriptor = -1};
    int error = find_place(path, &found);
    if (error != 0) {
        return error;
    }
    if (found.kind == PLACE_FILE) {
        error = open_file(found.path, watch, output);
        found.path = NULL;
    } else if (found.kind == PLACE_DESCRIPTOR) {
        error = svo_i_output_open_descriptor(found.descriptor, output);
    } else {
        output->descriptor = open(path, O_WRONLY | O_TRUNC | O_CLOEXEC | O_NOCTTY);
        error = output->descriptor < 0 ? errno : 0;
    }
    free(found.path);
    if (error != 0) {
        svo_i_output_abandon(output);
    }
    return error;
}

/* ---- writing ---- */

static int write_all(int descriptor, const char *bytes, size_t byte_count)
{
    while (byte_count > 0) {
        const ssize_t written = write(descriptor, bytes, byte_count);
        if (written < 0 && errno != EINTR) {
            return errno;
        }
        bytes += written > 0 ? written : 0;
        byte_count -= written > 0 ? (size_t)written : 0;
    }
    return 0;
}

/* A pipe without a reader raises SIGPIPE in the thread that writes, which would end the process. The signal is held
   back here and taken away, whatever the process has set for it. */
static int write_without_signal(int descriptor, const char *bytes, size_t byte_count)
{
    sigset_t pipe_signal, pending, before;
    sigemptyset(&pipe_signal);
    sigaddset(&pipe_signal, SIGPIPE);
    const bool was_pending = sigpending(&pending) == 0 && sigismember(&pending, SIGPIPE) == 1;
    int error = pthread_sigmask(SIG_BLOCK, &pipe_signal, &before);
    if (error != 0) {
        return error;
    }
    error = write_all(descriptor, bytes, byte_count);
    if (error == EPIPE && !was_pending) {
        const struct timespec now = {0};
        while (sigtimedwait(&pipe_signal, NULL, &now) < 0 && errno == EINTR) {
        }
    }
    (void)pthread_sigmask(SIG_SETMASK, &before, NULL);
    return error;
}

int svo_i_output_write(const svo_i_output *output, const void *bytes, size_t byte_count)
{
    return output->target != NULL ? write_all(output->descriptor, bytes, byte_count)
                                  : write_without_signal(output->descriptor, bytes, byte_count);
}

/* ---- the end ---- */

/* A file that is replaced keeps its owner and its permissions. Where that fails the new file is the caller's. */
static void keep_attributes(const svo_i_output *output)
{
    struct stat old;
    if (stat(output->target, &old) == 0 && fchown(output->descriptor, old.st_uid, old.st_gid) == 0) {
        (void)fchmod(output->descriptor, old.st_mode & 0777);
    }
}

/* Gives the complete file its name. */
static int take_name(svo_i_output *output)
{
    if (output->temporary == NULL) {
        char unnamed[FD_PATH_BYTES];
        write_fd_path(output->descriptor, unnamed);
        if (linkat(AT_FDCWD, unnamed, AT_FDCWD, output->target, AT_SYMLINK_FOLLOW) == 0) {
            return 0;
        }
        const int error = errno == EEXIST ? take_temporary_name(output) : errno;
        if (error != 0) {
            return error;
        }
    }
    if (rename(output->temporary, output->target) != 0) {
        return errno;
    }
    free(output->temporary);
    output->temporary = NULL;
    return 0;
}

/* Makes the name durable. Failure is ignored: the file is complete and has its name, and some file systems cannot
   synchronize folders. */
static void sync_folder(const char *path)
{
    char *folder = folder_of(path);
    const int descriptor = folder != NULL ? open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
    if (descriptor >= 0) {
        (void)fsync(descriptor);
        (void)close(descriptor);
    }
    free(folder);
}

static int commit_file(svo_i_output *output)
{
    if (fsync(output->descriptor) != 0) {
        return errno;
    }
    keep_attributes(output);
    hold(output);
    const int error = take_name(output);
    release(output);
    if (error == 0) {
        sync_folder(output->target);
    }
    return error;
}

int svo_i_output_commit(svo_i_output *output)
{
    int error = 0;
    if (output->target != NULL) {
        error = commit_file(output);
    } else {
        error = close(output->descriptor) != 0 ? errno : 0;
        output->descriptor = -1;
    }
    svo_i_output_abandon(output);
    return error;
}

void svo_i_output_abandon(svo_i_output *output)
{
    if (output->descriptor >= 0) {
        (void)close(output->descriptor);
    }
    if (output->temporary != NULL) {
        hold(output);
        (void)unlink(output->temporary);
        free(output->temporary);
        output->temporary = NULL;
        release(output);
    }
    free(output->target);
    *output = (svo_i_output){.descriptor = -1};
}
