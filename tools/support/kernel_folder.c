/* SPDX-License-Identifier: MIT */
#include "support/kernel_folder.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

bool kernel_folder_name(char path[KERNEL_FOLDER_BYTES])
{
    const char *cache = getenv("XDG_CACHE_HOME");
    const char *home = getenv("HOME");
    int length = 0;
    /* The specification of base directories says to ignore relative paths. */
    if (cache != NULL && cache[0] == '/') {
        length = snprintf(path, KERNEL_FOLDER_BYTES, "%s/svocl", cache);
    } else if (home != NULL && home[0] == '/') {
        length = snprintf(path, KERNEL_FOLDER_BYTES, "%s/.cache/svocl", home);
    }
    return length > 0 && length < KERNEL_FOLDER_BYTES;
}

bool kernel_folder_make(const char *path)
{
    char parent[KERNEL_FOLDER_BYTES];
    (void)snprintf(parent, sizeof parent, "%s", path);
    *strrchr(parent, '/') = '\0';
    const bool has_parent = mkdir(parent, 0700) == 0 || errno == EEXIST;
    return has_parent && (mkdir(path, 0700) == 0 || errno == EEXIST);
}

static bool is_own(const struct stat *entry)
{
    return (entry->st_uid == geteuid() || entry->st_uid == 0) && (entry->st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

bool kernel_folder_is_own(const char *path)
{
    struct stat entry;
    return stat(path, &entry) == 0 && S_ISDIR(entry.st_mode) && is_own(&entry);
}

bool kernel_folder_is_open(const char *path)
{
    struct stat entry;
    return stat(path, &entry) == 0 && S_ISDIR(entry.st_mode) && !is_own(&entry);
}
