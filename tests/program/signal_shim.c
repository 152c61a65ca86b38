/* SPDX-License-Identifier: MIT */
/*
 * For LD_PRELOAD: ends the program by a signal in the middle of writing a file, takes away files without a name, and
 * tells what a child would be started with.
 *
 *   SHIM_SIGNAL=N          the signal
 *   SHIM_AT=fsync|rename   the call before which it is raised: all bytes are written, or a temporary name is there; of
 *                          files in the working folder alone, where drivers keep nothing
 *   SHIM_NO_TMPFILE=1      open fails with O_TMPFILE, as on file systems without it
 *   SHIM_ARGUMENTS=FILE    execv appends its arguments to the file, a line for each child, and starts nothing but
 *                          svocl-lab, which svocl becomes
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void *next(const char *name)
{
    return dlsym(RTLD_NEXT, name);
}

static int is_here(int descriptor)
{
    char entry[64], target[PATH_MAX] = "", folder[PATH_MAX];
    (void)snprintf(entry, sizeof entry, "/proc/self/fd/%d", descriptor);
    return readlink(entry, target, sizeof target - 1) > 0 && getcwd(folder, sizeof folder) != NULL &&
           strncmp(target, folder, strlen(folder)) == 0;
}

static void signal_at(const char *call)
{
    const char *wanted = getenv("SHIM_AT");
    const char *number = getenv("SHIM_SIGNAL");
    if (wanted != NULL && number != NULL && strcmp(wanted, call) == 0) {
        kill(getpid(), atoi(number));
        usleep(50000); /* it may reach another thread first */
    }
}

/* The C library's headers name the parameters otherwise. */
/* NOLINTBEGIN(readability-inconsistent-declaration-parameter-name) */

int fsync(int descriptor)
{
    int (*real)(int) = NULL;
    *(void **)&real = next("fsync");
    if (is_here(descriptor)) {
        signal_at("fsync");
    }
    return real(descriptor);
}

int rename(const char *from, const char *to)
{
    int (*real)(const char *, const char *) = NULL;
    *(void **)&real = next("rename");
    if (strchr(to, '/') == NULL) {
        signal_at("rename");
    }
    return real(from, to);
}

int open(const char *path, int flags, ...)
{
    int (*real)(const char *, int, ...) = NULL;
    mode_t mode = 0;
    *(void **)&real = next("open");
    if ((flags & O_CREAT) != 0 || (flags & O_TMPFILE) == O_TMPFILE) {
        va_list arguments;
        va_start(arguments, flags);
        mode = va_arg(arguments, mode_t);
        va_end(arguments);
    }
    if ((flags & O_TMPFILE) == O_TMPFILE && getenv("SHIM_NO_TMPFILE") != NULL) {
        errno = EOPNOTSUPP;
        return -1;
    }
    return real(path, flags, mode);
}

int execv(const char *path, char *const arguments[])
{
    int (*real)(const char *, char *const[]) = NULL;
    *(void **)&real = next("execv");
    const char *list = getenv("SHIM_ARGUMENTS");
    const char *slash = strrchr(path, '/');
    if (list == NULL || (slash != NULL && strcmp(slash, "/svocl-lab") == 0)) {
        return real(path, arguments);
    }
    FILE *file = fopen(list, "a");
    for (size_t i = 0; file != NULL && arguments[i] != NULL; ++i) {
        (void)fprintf(file, "%s%s", i > 0 ? " " : "", arguments[i]);
    }
    if (file != NULL) {
        (void)fputc('\n', file);
        (void)fclose(file);
    }
    errno = EACCES; /* so that nothing is looked for along PATH */
    return -1;
}

/* NOLINTEND(readability-inconsistent-declaration-parameter-name) */
