/* SPDX-License-Identifier: MIT */
/*
 * Output files. They are written under a temporary name in the same folder, then renamed: after a failure nothing is
 * left behind and an old file is unchanged. A path that names a device or a pipe is written directly.
 */
#ifndef SVOCL_TOOLS_SUPPORT_OUTPUT_H
#define SVOCL_TOOLS_SUPPORT_OUTPUT_H

#include <stdio.h>

#include "support/program.h"

typedef struct output_file {
    FILE *stream;
    const char *path; /* borrowed */
    char *temporary_path; /* NULL: path itself is written */
    int error; /* errno of the first write that failed; 0: none */
} output_file;

/* Fails early if no file can be created at path: before long work, not after it. */
int output_check(program *state, const char *path);

int output_open(program *state, const char *path, output_file *file);
/* A write that fails shows in output_commit. */
void output_write(output_file *file, const void *bytes, size_t byte_count);
/* Flushes, closes and renames; on failure nothing is left. */
int output_commit(program *state, output_file *file);
void output_abandon(output_file *file);

#endif
