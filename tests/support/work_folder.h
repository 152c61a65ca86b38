/* SPDX-License-Identifier: MIT */
/* A folder for the files of one test program, removed with them at its end. */
#ifndef SVOCL_TESTS_WORK_FOLDER_H
#define SVOCL_TESTS_WORK_FOLDER_H

#include <stddef.h>

/* Group setup and teardown of cmocka; removing fails where a file is left that was not remembered. */
int work_folder_make(void **unused);
int work_folder_remove(void **unused);

const char *work_folder(void);
/* The path of a file in it; valid until the next call. */
const char *path_of(const char *name);
/* A file in it to be removed at the end; those that are written here are remembered. */
void work_folder_remember(const char *name);
void write_bytes(const char *name, const void *bytes, size_t byte_count);
void write_text(const char *name, const char *text);

#endif
