/* SPDX-License-Identifier: MIT */
/* The user's folder of saved kernels, and of what was measured (hybrid.h). */
#ifndef SVOCL_TOOLS_SUPPORT_KERNEL_FOLDER_H
#define SVOCL_TOOLS_SUPPORT_KERNEL_FOLDER_H

#include <stdbool.h>

#define KERNEL_FOLDER_BYTES 4096

/* Its path; false where neither variable is set, or the path is too long. */
bool kernel_folder_name(char path[KERNEL_FOLDER_BYTES]);

/* Makes it, and ~/.cache, for the user alone. Returns false with errno set. */
bool kernel_folder_make(const char *path);

/* Whether a folder is there that only this user, or root, may write to: binaries of others must not be run. */
bool kernel_folder_is_own(const char *path);

/* Whether one is there that others may write to. */
bool kernel_folder_is_open(const char *path);

#endif
