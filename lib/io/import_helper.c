/* SPDX-License-Identifier: MIT */
/*
 * Where the helper program of imports is. The installation may have been moved, so the file that holds this code is
 * asked for first: the shared library, or the program that it is linked into.
 */
#define _GNU_SOURCE /* dladdr */
#include <dlfcn.h>
#include <limits.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "core/message.h"
#include "svocl/io.h"

/* FROM_LIBRARY and FROM_PROGRAM, the helper's folder from that of libraries and that of programs, and INSTALLED, its
   absolute path, come from the build. */
#define HELPER_NAME "/svocl-import"

/* Whether a program is there; its path without links and dots goes to path. */
static bool take_program(const char *candidate, char *path, size_t path_bytes)
{
    char real[PATH_MAX];
    const bool is_there = access(candidate, X_OK) == 0 && realpath(candidate, real) != NULL;
    const int length = is_there ? snprintf(path, path_bytes, "%s", real) : -1;
    return length > 0 && (size_t)length < path_bytes;
}

/* The program at a path relative to the folder of a file. */
static bool take_beside(const char *file, const char *relative, char *path, size_t path_bytes)
{
    char candidate[PATH_MAX];
    char *slash = realpath(file, candidate) != NULL ? strrchr(candidate, '/') : NULL;
    if (slash == NULL) {
        return false;
    }
    const size_t left_bytes = sizeof candidate - (size_t)(slash - candidate);
    const int length = snprintf(slash, left_bytes, "/%s", relative);
    return length > 0 && (size_t)length < left_bytes && take_program(candidate, path, path_bytes);
}

svo_status svo_import_helper(char *path, size_t path_bytes, svo_message *message)
{
    static const char own_address = 0;
    Dl_info info = {0};
    if (path == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_import_helper: path is NULL");
    }
    const bool is_known = dladdr(&own_address, &info) != 0 && info.dli_fname != NULL;
    if ((is_known && take_beside(info.dli_fname, FROM_LIBRARY HELPER_NAME, path, path_bytes)) ||
        take_beside("/proc/self/exe", FROM_PROGRAM HELPER_NAME, path, path_bytes) ||
        take_program(INSTALLED HELPER_NAME, path, path_bytes)) {
        return SVO_OK;
    }
    return svo_i_fail(
        message, SVO_FILE_ERROR,
        "svo_import_helper: no program svocl-import in %s of the library's folder, %s of the program's, or %s",
        FROM_LIBRARY, FROM_PROGRAM, INSTALLED);
}
