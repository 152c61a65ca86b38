/* SPDX-License-Identifier: MIT */
/*
 * From a path to the place of its bytes, and from complete bytes to a file.
 *
 * A file without a name vanishes with the process, however that ends. Linux can name it by linkat, which replaces
 * nothing: where there is an old file, the new one gets a temporary name first and is renamed at once.
 */
#define _GNU_SOURCE /* O_TMPFILE */
#include "output/output.h"

#include <assert.h>
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

#define TEMPORARY_PREFIX ".svocl-"
#define TEMPORARY_SUFFIX ".tmp"

static_assert(PATH_MAX <= SVO_I_OUTPUT_PATH_BYTES, "paths of outputs are text of at most PATH_MAX bytes");

typedef enum place_kind {
    PLACE_FILE, /* a file to make or to replace */
    PLACE_STRAIGHT, /* a device, a pipe and the like */
    PLACE_DESCRIPTOR /* an open descriptor of this process */
} place_kind;

/* Where the bytes for a path go. */
typedef struct place {
    place_kind kind;
    char path[PATH_MAX]; /* with links followed */
    int descriptor;
} place;

/* ---- paths ----
   They are text of at most PATH_MAX bytes, the kernel's limit; functions return 0 or ENAMETOOLONG. So this room needs
   no memory. */

static int copy_path(const char *from, char to[PATH_MAX])
{
    const int length = snprintf(to, PATH_MAX, "%s", from);
    return length >= 0 && length < PATH_MAX ? 0 : ENAMETOOLONG;
}

/* The folder of a path. */
static int folder_of(const char *path, char out[PATH_MAX])
{
    const char *slash = strrchr(path, '/');
    if (slash == NULL) {
        return copy_path(".", out);
    }
    const size_t length = slash == path ? 1 : (size_t)(slash - path);
    if (length >= PATH_MAX) {
        return ENAMETOOLONG;
    }
    memcpy(out, path, length);
    out[length] = '\0';
    return 0;
}

/* Appends "/name" to a folder. */
static int join(char folder[PATH_MAX], const char *name)
{
    const size_t used = strlen(folder);
    const int length = snprintf(folder + used, PATH_MAX - used, "/%s", name);
    return length >= 0 && (size_t)length < PATH_MAX - used ? 0 : ENAMETOOLONG;
}

static bool is_same_folder(const char *real, const char *other)
{
    char other_real[PATH_MAX];
    return realpath(other, other_real) != NULL && strcmp(real, other_real) == 0;
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
    char folder[PATH_MAX], real[PATH_MAX];
    const bool own = folder_of(path, folder) == 0 && realpath(folder, real) != NULL &&
                     (is_same_folder(real, "/proc/self/fd") || is_same_folder(real, "/proc/thread-self/fd"));
    return own ? (int)number : -1;
}

/* Replaces the path of a symbolic link by where it leads. EINVAL where it is no link. */
static int follow_link(char path[PATH_MAX])
{
    char text[PATH_MAX], folder[PATH_MAX];
    const ssize_t length = readlink(path, text, sizeof text - 1);
    if (length < 0) {
        return errno;
    }
    text[length] = '\0';
    if (text[0] == '/') {
        return copy_path(text, path);
    }
    int error = folder_of(path, folder);
    if (error == 0) {
        error = join(folder, text);
    }
    return error == 0 ? copy_path(folder, path) : error;
}

/* Follows the links of a path's last component, down to a descriptor of this process or to what is no link; the kernel
   follows those of its folders. */
static int follow_links(const char *path, place *out)
{
    *out = (place){.descriptor = -1};
    int error = copy_path(path, out->path);
    for (int i = 0; error == 0 && i < LINKS_MAX; ++i) {
        out->descriptor = descriptor_at(out->path);
        error = out->descriptor < 0 ? follow_link(out->path) : 0;
        if (out->descriptor >= 0 || error == EINVAL || error == ENOENT) {
            return 0;
        }
    }
    return error == 0 ? ELOOP : error;
}

int svo_i_output_descriptor_of(const char *path)
{
    place found;
    (void)follow_links(path, &found);
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
    return error;
}

static int check_folder(const char *path)
{
    struct stat entry;
    char folder[PATH_MAX];
    const int error = folder_of(path, folder);
    if (error != 0) {
        return error;
    }
    if (stat(folder, &entry) != 0) {
        return errno;
    }
    if (!S_ISDIR(entry.st_mode)) {
        return ENOTDIR;
    }
    return access(folder, W_OK | X_OK) != 0 ? errno : 0;
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
        output->watch->release(output->watch->user, output->temporary[0] != '\0' ? output->temporary : NULL);
    }
}

/* The path of a descriptor that linkat can follow. */
static void write_fd_path(int descriptor, char text[FD_PATH_BYTES])
{
    (void)snprintf(text, FD_PATH_BYTES, "/proc/self/fd/%d", descriptor);
}

/* Makes a file of that path, or gives the file without a name that one. */
static int take_path(svo_i_output *output, const char *path)
{
    char unnamed[FD_PATH_BYTES];
    if (output->descriptor < 0) {
        output->descriptor = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        return output->descriptor < 0 ? errno : 0;
    }
    write_fd_path(output->descriptor, unnamed);
    return linkat(AT_FDCWD, unnamed, AT_FDCWD, path, AT_SYMLINK_FOLLOW) != 0 ? errno : 0;
}

/* Makes a file with a new temporary name, or gives the file without a name one. Names are short, since a file's own
   name may be as long as the file system allows. */
static int take_temporary_name(svo_i_output *output)
{
    char name[NAME_BYTES_MAX], path[PATH_MAX] = "";
    int error = EEXIST;
    for (int i = 0; error == EEXIST && i < NAME_ATTEMPTS; ++i) {
        (void)snprintf(name, sizeof name, TEMPORARY_PREFIX "%ld-%d" TEMPORARY_SUFFIX, (long)getpid(), i);
        error = folder_of(output->target, path);
        if (error == 0) {
            error = join(path, name);
        }
        if (error == 0) {
            error = take_path(output, path);
        }
    }
    return error == 0 ? copy_path(path, output->temporary) : error;
}

bool svo_i_output_is_temporary(const char *name)
{
    const size_t suffix_length = sizeof TEMPORARY_SUFFIX - 1;
    const size_t length = strlen(name);
    return strncmp(name, TEMPORARY_PREFIX, sizeof TEMPORARY_PREFIX - 1) == 0 && length > suffix_length &&
           strcmp(name + length - suffix_length, TEMPORARY_SUFFIX) == 0;
}

/* ---- opening ---- */

/* Where this fails, a temporary name is tried, and its error is the one to report. */
static void open_unnamed(svo_i_output *output)
{
#ifdef O_TMPFILE
    char path[FD_PATH_BYTES], folder[PATH_MAX];
    if (folder_of(output->target, folder) == 0) {
        output->descriptor = open(folder, O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
    }
    write_fd_path(output->descriptor, path);
    if (output->descriptor >= 0 && access(path, F_OK) != 0) { /* no /proc, so it could never get a name */
        (void)close(output->descriptor);
        output->descriptor = -1;
    }
#else
    (void)output;
#endif
}

static int open_file(const char *target, const svo_i_output_watch *watch, svo_i_output *output)
{
    int error = copy_path(target, output->target);
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
    } else if (found.kind == PLACE_DESCRIPTOR) {
        error = svo_i_output_open_descriptor(found.descriptor, output);
    } else {
        output->descriptor = open(path, O_WRONLY | O_TRUNC | O_CLOEXEC | O_NOCTTY);
        error = output->descriptor < 0 ? errno : 0;
    }
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
    return output->target[0] != '\0' ? write_all(output->descriptor, bytes, byte_count)
                                     : write_without_signal(output->descriptor, bytes, byte_count);
}

int svo_i_output_write_at(const svo_i_output *output, uint64_t offset, const void *bytes, size_t byte_count)
{
    const char *from = bytes;
    while (byte_count > 0) {
        const ssize_t written = pwrite(output->descriptor, from, byte_count, (off_t)offset);
        if (written < 0 && errno != EINTR) {
            return errno;
        }
        const size_t done = written > 0 ? (size_t)written : 0;
        from += done;
        offset += done;
        byte_count -= done;
    }
    return 0;
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
    if (output->temporary[0] == '\0') {
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
    output->temporary[0] = '\0';
    return 0;
}

/* Makes the name durable. Failure is ignored: the file is complete and has its name, and some file systems cannot
   synchronize folders. */
static void sync_folder(const char *path)
{
    char folder[PATH_MAX];
    const int descriptor = folder_of(path, folder) == 0 ? open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
    if (descriptor >= 0) {
        (void)fsync(descriptor);
        (void)close(descriptor);
    }
}

static int name_file(svo_i_output *output)
{
    keep_attributes(output);
    hold(output);
    const int error = take_name(output);
    release(output);
    return error;
}

static int commit_file(svo_i_output *output)
{
    if (fsync(output->descriptor) != 0) {
        return errno;
    }
    const int error = name_file(output);
    if (error == 0) {
        sync_folder(output->target);
    }
    return error;
}

/* A file that had a name from the start is on a file system without unnamed files. Most of those are on the network,
   and other machines see what is flushed. */
static int name_file_where_seen(svo_i_output *output)
{
    if (output->temporary[0] != '\0' && fsync(output->descriptor) != 0) {
        return errno;
    }
    return name_file(output);
}

static int commit(svo_i_output *output, int (*finish)(svo_i_output *output))
{
    int error = 0;
    if (output->target[0] != '\0') {
        error = finish(output);
    } else {
        error = close(output->descriptor) != 0 ? errno : 0;
        output->descriptor = -1;
    }
    svo_i_output_abandon(output);
    return error;
}

int svo_i_output_commit(svo_i_output *output)
{
    return commit(output, commit_file);
}

int svo_i_output_commit_unflushed(svo_i_output *output)
{
    return commit(output, name_file_where_seen);
}

int svo_i_output_take(const char *complete, const char *path)
{
    place found;
    svo_i_output output = {.descriptor = -1};
    int error = find_place(path, &found);
    if (error == 0 && found.kind != PLACE_FILE) {
        error = EINVAL;
    }
    if (error == 0) {
        error = copy_path(found.path, output.target);
    }
    if (error == 0) {
        error = copy_path(complete, output.temporary);
    }
    if (error == 0) {
        output.descriptor = open(complete, O_WRONLY | O_CLOEXEC);
        error = output.descriptor < 0 ? errno : commit_file(&output);
    }
    output.temporary[0] = '\0'; /* the file stays for another try */
    svo_i_output_abandon(&output);
    return error;
}

void svo_i_output_abandon(svo_i_output *output)
{
    if (output->descriptor >= 0) {
        (void)close(output->descriptor);
    }
    if (output->temporary[0] != '\0') {
        hold(output);
        (void)unlink(output->temporary);
        output->temporary[0] = '\0';
        release(output);
    }
    *output = (svo_i_output){.descriptor = -1};
}
