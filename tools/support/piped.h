/* SPDX-License-Identifier: MIT */
/*
 * INPUT from standard input or a pipe. A pipe has no suffix that tells the format and cannot be read twice, so all of
 * it is read and judged by its first bytes. What a pipe cannot carry, a mesh in several files, is refused by name.
 */
#ifndef SVOCL_TOOLS_SUPPORT_PIPED_H
#define SVOCL_TOOLS_SUPPORT_PIPED_H

#include <stdbool.h>
#include <stddef.h>

#include "svocl/files.h"

typedef struct piped_input {
    const char *name; /* "standard input", or the path of a named pipe; NULL: INPUT is no pipe */
    char *bytes; /* by malloc */
    size_t byte_count;
    const char *suffix; /* ".svo", ".ply", ".vox", ...: what the bytes are */
} piped_input;

/* Whether a path is "-" or leads to standard input. */
bool piped_is_standard_input(const char *path);

/* Whether a path is standard input, a pipe, or what else is neither a file nor a folder. */
bool piped_is_stream(const char *path);

/* Reads such a path to its end; piped.name is set then. Returns 0 or the errno. */
int piped_read(const char *path, piped_input *piped);

/* Sets the suffix. Returns NULL, or why the bytes cannot be used. */
const char *piped_judge(piped_input *piped);

/* Whether a path is piped.name, and the bytes are what to read for it. */
bool piped_is(const piped_input *piped, const char *path);

/* What to read for a path: the bytes, if piped_is, else the file. */
svo_source piped_source(const piped_input *piped, const char *path);

/* Frees the bytes alone, once they are elsewhere. */
void piped_release_bytes(piped_input *piped);
void piped_free(piped_input *piped);

#endif
