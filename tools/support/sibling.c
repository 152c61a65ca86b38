/* SPDX-License-Identifier: MIT */
/* Installed and in the build folder alike, both programs lie in one folder. */
#include "support/sibling.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define PATH_BYTES 4096

void sibling_become(const char *name, char *const arguments[])
{
    char path[PATH_BYTES];
    const ssize_t length = readlink("/proc/self/exe", path, sizeof path - 1);
    path[length > 0 ? length : 0] = '\0';
    char *slash = strrchr(path, '/');
    const size_t left = slash != NULL ? sizeof path - (size_t)(slash + 1 - path) : 0;
    if (left > strlen(name)) {
        (void)snprintf(slash + 1, left, "%s", name);
        (void)execv(path, arguments);
        if (errno != ENOENT) {
            return;
        }
    }
    (void)execvp(name, arguments);
}
