/* SPDX-License-Identifier: MIT */
/* INPUT that is the file of a compact tree (.svc): it is expanded, so that commands see a tree as in a .svo file. */
#ifndef SVOCL_TOOLS_SUPPORT_COMPACT_INPUT_H
#define SVOCL_TOOLS_SUPPORT_COMPACT_INPUT_H

#include <stdbool.h>

#include "support/program.h"
#include "svocl/compact.h"

/* Whether a name, or the suffix that the bytes of a pipe are given, is that of a compact tree. */
bool compact_input_is_name(const char *name);

/* Loads the compact tree of a file, or of the bytes that came through a pipe; bytes: NULL for a file. *out has host
   arrays and is on no device. Returns the exit code. */
int compact_input_load(program *state, const char *name, const void *bytes, size_t byte_count, svo_compact **out);

/* Expands and destroys a compact tree. *out has host arrays and is on no device; name stands
   for its file in messages. Returns the exit code. */
int compact_input_expand(program *state, const char *name, svo_compact **compact, svo_tree **out);

#endif
