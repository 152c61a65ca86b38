/* SPDX-License-Identifier: MIT */
/*
 * Output files, written whole or not at all by lib/output: after a failure or a signal nothing is left behind and an
 * old file is unchanged. Symbolic links stay. "-" and what is no file are written straight.
 */
#ifndef SVOCL_TOOLS_SUPPORT_OUTPUT_H
#define SVOCL_TOOLS_SUPPORT_OUTPUT_H

#include <stdbool.h>
#include <stdio.h>

#include "support/cleanup.h"
#include "support/program.h"

/* Stays where it is while it is open. */
typedef struct output_file {
    FILE *stream;
    const char *path; /* borrowed */
    svo_i_output target;
    cleanup_entry temporary;
    int error; /* errno of the first write that failed; 0: none */
} output_file;

/* What messages call the path: "standard output" for "-". */
const char *output_name(const char *path);

/*
 * To be called once, when the inputs of the command line are protected, with the path after -o: checks it, and that the
 * command writes files of its suffix. Where it is "-" or leads to standard output, keeps that for the file. What the
 * program prints then goes to standard error. Returns the exit code.
 */
int output_begin(program *state, const command *which);

/* This run reads path, "-" for standard input: no output may be that file. Fails where one is. */
int output_protect(program *state, const char *path);

/* Fails early if no file can be created at path, or if it is one that this run reads or writes: before long work, not
   after it. output_open checks the latter again. */
int output_check(program *state, const char *path);

int output_open(program *state, const char *path, output_file *file);
/* A write that fails shows in output_commit. */
void output_write(output_file *file, const void *bytes, size_t byte_count);
/* Hands all bytes to the system; false after a write that failed. */
bool output_flush(output_file *file);
/* Flushes, closes and gives the file its name; on failure nothing is left. */
int output_commit(program *state, output_file *file);
void output_abandon(output_file *file);

#endif
