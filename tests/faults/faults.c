/* SPDX-License-Identifier: MIT */
/* Decides which call fails, and wraps allocations, files, processes and the loader. */
#define _GNU_SOURCE
#include "faults.h"

#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

faults_objects faults_live;

static struct {
    bool armed, spared;
    uint64_t left; /* calls before the one that fails */
    faults_call failed;
    FILE *broken; /* a stream that has failed, for ferror */
    uint64_t *places; /* NULL: places are not noted */
    size_t place_count, noted;
} turn;

const char *fault_kind_name(fault_kind kind)
{
    static const char *const names[FAULT_KINDS] = {"allocation", "OpenCL",  "OpenGL", "EGL",
                                                   "file",       "process", "loader"};
    return names[kind];
}

void faults_arm(uint64_t index)
{
    turn.armed = true;
    turn.left = index;
    turn.failed = (faults_call){0};
}

faults_call faults_disarm(void)
{
    turn.armed = false;
    turn.places = NULL;
    return turn.failed;
}

void faults_note(uint64_t *places, size_t place_count)
{
    turn.places = places;
    turn.place_count = place_count;
    turn.noted = 0;
    turn.failed = (faults_call){0};
}

size_t faults_noted(void)
{
    return turn.noted;
}

void faults_spare(bool on)
{
    turn.spared = on;
}

faults_call faults_failed(void)
{
    return turn.failed;
}

/* Above this function and faults_turn: the wrapper, its caller and the one above. */
static __attribute__((noinline)) void note_place(void)
{
    enum { OWN_FRAMES = 2, FRAMES = OWN_FRAMES + 3 };
    void *frames[FRAMES] = {NULL};
    const int count = backtrace(frames, FRAMES);
    uint64_t hash = 0;
    for (int i = OWN_FRAMES; i < count; ++i) {
        hash = (hash ^ ((uintptr_t)frames[i] - (uintptr_t)faults_turn)) * 0x9E3779B97F4A7C15;
        hash ^= hash >> 32;
    }
    if (turn.noted < turn.place_count) {
        turn.places[turn.noted] = hash;
    }
    ++turn.noted;
}

__attribute__((noinline)) bool faults_turn(fault_kind kind, const char *name)
{
    if (turn.places != NULL && !turn.spared) {
        note_place();
        return false;
    }
    if (!turn.armed || turn.spared || turn.failed.name != NULL || turn.left-- > 0) {
        return false;
    }
    turn.failed = (faults_call){name, kind};
    return true;
}

/* The linker's names for the real calls and for their wrappers. */
/* NOLINTBEGIN(readability-identifier-naming) */
#define DECLARE(type, name, parameters) \
    type __real_##name parameters;      \
    type __wrap_##name parameters;      \
    type __wrap_##name parameters

/* A call without effect on the counts. */
#define PLAIN(kind, type, name, parameters, arguments, failed, error) \
    DECLARE(type, name, parameters)                                   \
    {                                                                 \
        if (faults_turn(kind, #name)) {                               \
            errno = (error);                                          \
            return failed;                                            \
        }                                                             \
        return __real_##name arguments;                               \
    }

/* ---- allocations ---- */

#define ALLOCATE(name, parameters, arguments)        \
    DECLARE(void *, name, parameters)                \
    {                                                \
        if (faults_turn(FAULT_ALLOCATION, #name)) {  \
            errno = ENOMEM;                          \
            return NULL;                             \
        }                                            \
        void *block = __real_##name arguments;       \
        faults_live.blocks += block != NULL ? 1 : 0; \
        return block;                                \
    }

ALLOCATE(malloc, (size_t bytes), (bytes))
ALLOCATE(calloc, (size_t count, size_t bytes), (count, bytes))
ALLOCATE(aligned_alloc, (size_t alignment, size_t bytes), (alignment, bytes))

DECLARE(void *, realloc, (void *old, size_t bytes))
{
    if (faults_turn(FAULT_ALLOCATION, "realloc")) {
        errno = ENOMEM;
        return NULL;
    }
    void *block = __real_realloc(old, bytes);
    faults_live.blocks += old == NULL && block != NULL ? 1 : 0;
    return block;
}

DECLARE(int, posix_memalign, (void **out, size_t alignment, size_t bytes))
{
    if (faults_turn(FAULT_ALLOCATION, "posix_memalign")) {
        return ENOMEM;
    }
    const int error = __real_posix_memalign(out, alignment, bytes);
    faults_live.blocks += error == 0 ? 1 : 0;
    return error;
}

#define DUPLICATE(name, parameters, arguments)      \
    DECLARE(char *, name, parameters)               \
    {                                               \
        if (faults_turn(FAULT_ALLOCATION, #name)) { \
            errno = ENOMEM;                         \
            return NULL;                            \
        }                                           \
        char *copy = __real_##name arguments;       \
        faults_live.blocks += copy != NULL ? 1 : 0; \
        return copy;                                \
    }

DUPLICATE(strdup, (const char *text), (text))
DUPLICATE(strndup, (const char *text, size_t bytes), (text, bytes))

DECLARE(char *, realpath, (const char *path, char *resolved))
{
    if (faults_turn(FAULT_FILE, "realpath")) {
        errno = EIO;
        return NULL;
    }
    char *text = __real_realpath(path, resolved);
    faults_live.blocks += resolved == NULL && text != NULL ? 1 : 0;
    return text;
}

DECLARE(void, free, (void *block))
{
    faults_live.blocks -= block != NULL ? 1 : 0;
    __real_free(block);
}

/* ---- files ---- */

static int opened(int file)
{
    faults_live.files += file >= 0 ? 1 : 0;
    return file;
}

DECLARE(int, open, (const char *path, int flags, ...))
{
    va_list arguments;
    va_start(arguments, flags);
    const int mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, int) : 0;
    va_end(arguments);
    if (faults_turn(FAULT_FILE, "open")) {
        errno = EIO;
        return -1;
    }
    return opened(__real_open(path, flags, mode));
}

DECLARE(int, pipe2, (int ends[2], int flags))
{
    if (faults_turn(FAULT_FILE, "pipe2")) {
        errno = EMFILE;
        return -1;
    }
    const int result = __real_pipe2(ends, flags);
    faults_live.files += result == 0 ? 2 : 0;
    return result;
}

DECLARE(int, close, (int file))
{
    const bool fails = faults_turn(FAULT_FILE, "close");
    const int result = __real_close(file);
    faults_live.files -= result == 0 ? 1 : 0;
    errno = fails ? EIO : errno;
    return fails ? -1 : result;
}

DECLARE(FILE *, fopen, (const char *path, const char *mode))
{
    if (faults_turn(FAULT_FILE, "fopen")) {
        errno = EIO;
        return NULL;
    }
    FILE *stream = __real_fopen(path, mode);
    faults_live.files += stream != NULL ? 1 : 0;
    return stream;
}

DECLARE(int, fclose, (FILE * stream))
{
    const bool fails = faults_turn(FAULT_FILE, "fclose");
    turn.broken = turn.broken == stream ? NULL : turn.broken;
    const int result = __real_fclose(stream);
    --faults_live.files;
    errno = fails ? EIO : errno;
    return fails ? EOF : result;
}

/* A failed read or write of a stream sets the stream's error. */
static bool breaks(FILE *stream, const char *name)
{
    if (!faults_turn(FAULT_FILE, name)) {
        return false;
    }
    turn.broken = stream;
    errno = EIO;
    return true;
}

DECLARE(size_t, fread, (void *to, size_t bytes, size_t count, FILE *stream))
{
    return breaks(stream, "fread") ? 0 : __real_fread(to, bytes, count, stream);
}

DECLARE(size_t, fwrite, (const void *from, size_t bytes, size_t count, FILE *stream))
{
    return breaks(stream, "fwrite") ? 0 : __real_fwrite(from, bytes, count, stream);
}

DECLARE(int, fgetc, (FILE * stream))
{
    return breaks(stream, "fgetc") ? EOF : __real_fgetc(stream);
}

DECLARE(int, fflush, (FILE * stream))
{
    return breaks(stream, "fflush") ? EOF : __real_fflush(stream);
}

DECLARE(int, ferror, (FILE * stream))
{
    return turn.broken == stream ? 1 : __real_ferror(stream);
}

PLAIN(FAULT_FILE, int, fseek, (FILE * stream, long offset, int whence), (stream, offset, whence), -1, EIO)
PLAIN(FAULT_FILE, int, rmdir, (const char *path), (path), -1, EIO)
PLAIN(FAULT_FILE, int, fstat, (int file, struct stat *entry), (file, entry), -1, EIO)
PLAIN(FAULT_FILE, int, stat, (const char *path, struct stat *entry), (path, entry), -1, EIO)
PLAIN(FAULT_FILE, int, lstat, (const char *path, struct stat *entry), (path, entry), -1, EIO)
PLAIN(FAULT_FILE, int, fsync, (int file), (file), -1, EIO)
PLAIN(FAULT_FILE, int, poll, (struct pollfd * files, nfds_t count, int timeout_ms), (files, count, timeout_ms), -1,
      ENOMEM)
PLAIN(FAULT_FILE, ssize_t, read, (int file, void *to, size_t bytes), (file, to, bytes), -1, EIO)
PLAIN(FAULT_FILE, ssize_t, write, (int file, const void *from, size_t bytes), (file, from, bytes), -1, EIO)
PLAIN(FAULT_FILE, ssize_t, pread, (int file, void *to, size_t bytes, off_t offset), (file, to, bytes, offset), -1, EIO)
PLAIN(FAULT_FILE, ssize_t, pwrite, (int file, const void *from, size_t bytes, off_t offset),
      (file, from, bytes, offset), -1, EIO)
PLAIN(FAULT_FILE, int, rename, (const char *from, const char *to), (from, to), -1, EIO)
PLAIN(FAULT_FILE, int, link, (const char *from, const char *to), (from, to), -1, EIO)
PLAIN(FAULT_FILE, int, linkat, (int from_folder, const char *from, int to_folder, const char *to, int flags),
      (from_folder, from, to_folder, to, flags), -1, EIO)
PLAIN(FAULT_FILE, int, ftruncate, (int file, off_t bytes), (file, bytes), -1, EIO)
PLAIN(FAULT_FILE, off_t, lseek, (int file, off_t offset, int whence), (file, offset, whence), -1, EIO)
PLAIN(FAULT_FILE, ssize_t, readlink, (const char *path, char *to, size_t bytes), (path, to, bytes), -1, EIO)
PLAIN(FAULT_FILE, int, access, (const char *path, int mode), (path, mode), -1, EIO)
PLAIN(FAULT_FILE, int, mkdir, (const char *path, mode_t mode), (path, mode), -1, EIO)

DECLARE(void *, mmap, (void *address, size_t bytes, int protection, int flags, int file, off_t offset))
{
    if (faults_turn(FAULT_FILE, "mmap")) {
        errno = ENOMEM;
        return MAP_FAILED;
    }
    void *mapped = __real_mmap(address, bytes, protection, flags, file, offset);
    faults_live.mappings += mapped != MAP_FAILED ? 1 : 0;
    return mapped;
}

DECLARE(int, munmap, (void *mapped, size_t bytes))
{
    const bool fails = faults_turn(FAULT_FILE, "munmap");
    const int result = __real_munmap(mapped, bytes);
    faults_live.mappings -= result == 0 ? 1 : 0;
    errno = fails ? EINVAL : errno;
    return fails ? -1 : result;
}

PLAIN(FAULT_FILE, int, fchmod, (int file, mode_t mode), (file, mode), -1, EPERM)
PLAIN(FAULT_FILE, int, fchown, (int file, uid_t owner, gid_t group), (file, owner, group), -1, EPERM)

DECLARE(int, fcntl, (int file, int command, ...))
{
    va_list arguments;
    va_start(arguments, command);
    void *argument = va_arg(arguments, void *); /* an int is passed in the same register */
    va_end(arguments);
    if (faults_turn(FAULT_FILE, "fcntl")) {
        errno = EIO;
        return -1;
    }
    const int result = __real_fcntl(file, command, argument);
    return command == F_DUPFD_CLOEXEC || command == F_DUPFD ? opened(result) : result;
}

DECLARE(DIR *, opendir, (const char *path))
{
    if (faults_turn(FAULT_FILE, "opendir")) {
        errno = EIO;
        return NULL;
    }
    DIR *folder = __real_opendir(path);
    faults_live.files += folder != NULL ? 1 : 0;
    return folder;
}

DECLARE(int, closedir, (DIR * folder))
{
    const bool fails = faults_turn(FAULT_FILE, "closedir");
    const int result = __real_closedir(folder);
    --faults_live.files;
    errno = fails ? EIO : errno;
    return fails ? -1 : result;
}

PLAIN(FAULT_FILE, struct dirent *, readdir, (DIR * folder), (folder), NULL, EIO)

/* Reports an error after it has removed the file. */
DECLARE(int, unlink, (const char *path))
{
    const bool fails = faults_turn(FAULT_FILE, "unlink");
    const int result = __real_unlink(path);
    errno = fails ? EIO : errno;
    return fails ? -1 : result;
}

/* ---- the import child ---- */

PLAIN(FAULT_PROCESS, int, posix_spawn_file_actions_init, (posix_spawn_file_actions_t * actions), (actions), ENOMEM, 0)
PLAIN(FAULT_PROCESS, int, posix_spawn_file_actions_adddup2, (posix_spawn_file_actions_t * actions, int from, int to),
      (actions, from, to), ENOMEM, 0)
PLAIN(FAULT_PROCESS, int, posix_spawn_file_actions_addopen,
      (posix_spawn_file_actions_t * actions, int file, const char *path, int flags, mode_t mode),
      (actions, file, path, flags, mode), ENOMEM, 0)
PLAIN(FAULT_PROCESS, int, posix_spawnattr_init, (posix_spawnattr_t * attributes), (attributes), ENOMEM, 0)
PLAIN(FAULT_PROCESS, int, posix_spawnattr_setflags, (posix_spawnattr_t * attributes, short flags), (attributes, flags),
      EINVAL, 0)
PLAIN(FAULT_PROCESS, int, posix_spawnattr_setsigdefault, (posix_spawnattr_t * attributes, const sigset_t *signals),
      (attributes, signals), EINVAL, 0)
PLAIN(FAULT_PROCESS, int, posix_spawnattr_setsigmask, (posix_spawnattr_t * attributes, const sigset_t *signals),
      (attributes, signals), EINVAL, 0)
PLAIN(FAULT_PROCESS, int, setrlimit, (__rlimit_resource_t resource, const struct rlimit *limit), (resource, limit), -1,
      EPERM)
PLAIN(FAULT_PROCESS, int, getrlimit, (__rlimit_resource_t resource, struct rlimit *limit), (resource, limit), -1, EPERM)
PLAIN(FAULT_PROCESS, int, nanosleep, (const struct timespec *time, struct timespec *left), (time, left), -1, EINTR)

DECLARE(int, posix_spawn,
        (pid_t * process, const char *path, const posix_spawn_file_actions_t *actions,
         const posix_spawnattr_t *attributes, char *const arguments[], char *const environment[]))
{
    if (faults_turn(FAULT_PROCESS, "posix_spawn")) {
        return ENOMEM;
    }
    const int error = __real_posix_spawn(process, path, actions, attributes, arguments, environment);
    faults_live.processes += error == 0 ? 1 : 0;
    return error;
}

/* Fails as where the caller ignores SIGCHLD: the child is gone, and its exit status with it. */
DECLARE(pid_t, waitpid, (pid_t process, int *status, int options))
{
    const bool fails = faults_turn(FAULT_PROCESS, "waitpid");
    int real_status = 0;
    const pid_t result = __real_waitpid(process, &real_status, fails ? 0 : options);
    faults_live.processes -= result > 0 ? 1 : 0;
    if (fails) {
        errno = ECHILD;
        return -1;
    }
    if (result > 0 && status != NULL) {
        *status = real_status;
    }
    return result;
}

/* Reports an error after it has sent the signal. */
DECLARE(int, kill, (pid_t process, int number))
{
    const bool fails = faults_turn(FAULT_PROCESS, "kill");
    const int result = __real_kill(process, number);
    errno = fails ? ESRCH : errno;
    return fails ? -1 : result;
}

/* ---- the loader ---- */

DECLARE(void *, dlopen, (const char *name, int flags))
{
    if (faults_turn(FAULT_LOADER, "dlopen")) {
        return NULL;
    }
    void *library = __real_dlopen(name, flags);
    faults_live.libraries += library != NULL ? 1 : 0;
    return library;
}

DECLARE(int, dlclose, (void *library))
{
    const bool fails = faults_turn(FAULT_LOADER, "dlclose");
    const int result = __real_dlclose(library);
    faults_live.libraries -= result == 0 ? 1 : 0;
    return fails ? -1 : result;
}

PLAIN(FAULT_LOADER, int, dladdr, (const void *address, Dl_info *info), (address, info), 0, 0)

/* RTLD_NEXT is a sanitizer's, which looks its functions up before memory can be watched. */
DECLARE(void *, dlsym, (void *library, const char *name))
{
    if (library == RTLD_NEXT) {
        return __real_dlsym(library, name);
    }
    if (faults_turn(FAULT_LOADER, "dlsym")) {
        return NULL;
    }
    return faults_hook(name, __real_dlsym(library, name));
}
/* NOLINTEND(readability-identifier-naming) */
