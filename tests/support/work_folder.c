/* SPDX-License-Identifier: MIT */
/* A folder for the files of one test program. */
#define _XOPEN_SOURCE 700
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "work_folder.h"

#define PATH_BYTES 512
#define FILES_MAX  512
#define NAME_BYTES 64

static char directory[PATH_BYTES];
static char made_files[FILES_MAX][NAME_BYTES];
static size_t made_file_count;

int work_folder_make(void **unused)
{
    (void)unused;
    const char *parent = getenv("TMPDIR");
    (void)snprintf(directory, sizeof directory, "%s/svocl-test-XXXXXX", parent != NULL ? parent : "/tmp");
    return mkdtemp(directory) != NULL ? 0 : -1;
}

int work_folder_remove(void **unused)
{
    (void)unused;
    for (size_t i = 0; i < made_file_count; ++i) {
        (void)unlink(path_of(made_files[i]));
    }
    return rmdir(directory);
}

const char *work_folder(void)
{
    return directory;
}

const char *path_of(const char *name)
{
    static char path[2 * PATH_BYTES];
    const int length = snprintf(path, sizeof path, "%s/%s", directory, name);
    assert_true(length > 0 && (size_t)length < sizeof path);
    return path;
}

void work_folder_remember(const char *name)
{
    for (size_t i = 0; i < made_file_count; ++i) {
        if (strcmp(made_files[i], name) == 0) {
            return;
        }
    }
    assert_true(made_file_count < FILES_MAX);
    assert_true(strlen(name) < NAME_BYTES);
    memcpy(made_files[made_file_count++], name, strlen(name) + 1);
}

void write_bytes(const char *name, const void *bytes, size_t byte_count)
{
    FILE *file = fopen(path_of(name), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, byte_count, file), byte_count);
    assert_int_equal(fclose(file), 0);
    work_folder_remember(name);
}

void write_text(const char *name, const char *text)
{
    write_bytes(name, text, strlen(text));
}
