/* SPDX-License-Identifier: MIT */
/* A list of files: runs have few, and an animation writes its frames slower than the list is searched. */
#include "support/file_register.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char file_register_no_memory[] = "out of memory";

static bool is_same(const file_entry *one, const struct stat *entry)
{
    return one->device == entry->st_dev && one->inode == entry->st_ino;
}

static const char *add(file_register *files, const struct stat *entry, const char *name, bool is_output)
{
    if (files->count == files->capacity) {
        const size_t capacity = 2 * files->capacity + 16;
        file_entry *larger = realloc(files->entries, capacity * sizeof *larger);
        if (larger == NULL) {
            return file_register_no_memory;
        }
        files->entries = larger;
        files->capacity = capacity;
    }
    char *copy = strdup(name);
    if (copy == NULL) {
        return file_register_no_memory;
    }
    files->entries[files->count++] =
        (file_entry){.device = entry->st_dev, .inode = entry->st_ino, .name = copy, .is_output = is_output};
    return NULL;
}

const char *file_register_read(file_register *files, const struct stat *entry, const char *name)
{
    for (size_t i = 0; i < files->count; ++i) {
        const file_entry *one = &files->entries[i];
        if (is_same(one, entry)) {
            return one->is_output && !one->is_written ? one->name : NULL;
        }
    }
    return add(files, entry, name, false);
}

/* An output that is written again replaces itself. */
const char *file_register_write(file_register *files, const struct stat *entry, const char *name)
{
    bool is_known = false;
    for (size_t i = 0; i < files->count; ++i) {
        const file_entry *one = &files->entries[i];
        const bool is_itself = one->is_output && strcmp(one->name, name) == 0;
        if (is_same(one, entry) && !is_itself) {
            return one->name;
        }
        is_known = is_known || is_itself;
    }
    return is_known ? NULL : add(files, entry, name, true);
}

void file_register_written(file_register *files, const struct stat *entry, const char *name)
{
    size_t i = 0;
    while (i < files->count && !(files->entries[i].is_output && strcmp(files->entries[i].name, name) == 0)) {
        ++i;
    }
    if (i == files->count && add(files, entry, name, true) != NULL) {
        return; /* what is not noted is not protected from the next output alone */
    }
    files->entries[i].device = entry->st_dev;
    files->entries[i].inode = entry->st_ino;
    files->entries[i].is_written = true;
}

static const char *find_input(const file_register *files, const char *path)
{
    struct stat entry;
    if (stat(path, &entry) != 0) {
        return NULL;
    }
    for (size_t i = 0; i < files->count; ++i) {
        if (!files->entries[i].is_output && is_same(&files->entries[i], &entry)) {
            return files->entries[i].name;
        }
    }
    return NULL;
}

const char *file_register_input_at(const file_register *files, const char *path)
{
    char folder[PATH_MAX];
    const char *found = find_input(files, path);
    const char *slash = strrchr(path, '/');
    if (found != NULL) {
        return found;
    }
    (void)snprintf(folder, sizeof folder, "%.*s/.", slash != NULL ? (int)(slash - path) : 1, slash != NULL ? path : ".");
    return find_input(files, folder);
}

bool file_register_is_output(const file_register *files, const char *name)
{
    size_t i = 0;
    while (i < files->count && files->entries[i].name != name) {
        ++i;
    }
    return i < files->count && files->entries[i].is_output;
}

void file_register_forget(file_register *files, const char *name)
{
    for (size_t i = 0; i < files->count; ++i) {
        if (!files->entries[i].is_output && strcmp(files->entries[i].name, name) == 0) {
            free(files->entries[i].name);
            files->entries[i] = files->entries[--files->count];
            return;
        }
    }
}

void file_register_free(file_register *files)
{
    for (size_t i = 0; i < files->count; ++i) {
        free(files->entries[i].name);
    }
    free(files->entries);
    *files = (file_register){0};
}
